// SPDX-License-Identifier: Apache-2.0
// A folder for the files of one test, gone when the test is.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>

namespace scrim::test {

/// A new empty folder under the system's temporary one; the destructor removes it with all that is in it.
class TempFolder {
  public:
    TempFolder() {
        std::string pattern = (std::filesystem::temp_directory_path() / "scrim-test-XXXXXX").string();
        if (::mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("cannot make " + pattern);
        m_path = pattern;
    }
    ~TempFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(m_path, ignored);
    }
    TempFolder(const TempFolder&) = delete;
    TempFolder& operator=(const TempFolder&) = delete;

    const std::string& path() const { return m_path; }
    /// The path of `name` in this folder; nothing is created.
    std::string file(const std::string& name) const { return m_path + "/" + name; }
    /// Number of entries, hidden ones too.
    std::size_t entryCount() const {
        std::size_t count = 0;
        for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(m_path)) ++count;
        return count;
    }

  private:
    std::string m_path;
};

}  // namespace scrim::test
