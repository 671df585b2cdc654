// SPDX-License-Identifier: Apache-2.0
#include "usd_scenes.h"

#include "interrupt.h"

#include <scrim/base/error.h>
#include <scrim/shot/shot_text.h>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

namespace scrim::cli {
namespace {

constexpr const char* kHowToInstall =
    "stages are read by Scrim's Python package and usd-core (pip install usd-core); $SCRIM_PYTHON names the Python "
    "that has both";

/// The Python program: the one named by the environment, or python3 beside this program, or the one in PATH.
std::string pythonProgram() {
    if (const char* const named = std::getenv("SCRIM_PYTHON"); named != nullptr && *named != '\0') return named;
    std::error_code ignored;
    const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", ignored);
    const std::filesystem::path beside = self.parent_path() / "python3";
    return !self.empty() && std::filesystem::exists(beside, ignored) ? beside.string() : "python3";
}

std::vector<std::string> argumentsFor(const std::string& path, const std::string& folder, const SceneOptions& options) {
    std::vector<std::string> words = {pythonProgram(), "-m", "scrim.usd"};
    const auto add = [&words](const char* name, const std::string& value) {
        // Option and value form one word, so that no value is taken for an option.
        if (!value.empty()) words.push_back(fmt::format("--{}={}", name, value));
    };
    add("frames", fmt::format("{}", fmt::join(options.frames, ",")));
    if (options.resolution) add("res", fmt::format("{}x{}", options.resolution->x, options.resolution->y));
    add("camera", options.usd.camera);
    add("settings", options.usd.settings);
    add("purpose", options.usd.purpose);
    add("sidecar", options.usd.sidecar);
    add("distant", options.usd.distant);
    add("meshes", options.usd.meshes);
    words.insert(words.end(), {"--", path, folder});
    return words;
}

/// A child process whose standard output is read here; its standard error is ours.
class Child {
  public:
    explicit Child(std::vector<std::string> words) {
        int ends[2];
        if (::pipe2(ends, O_CLOEXEC) != 0)
            throw Error(ErrorKind::render, std::string("cannot make a pipe: ") + std::strerror(errno));
        m_output = ends[0];
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
        posix_spawn_file_actions_adddup2(&actions, ends[1], 1);
        std::vector<char*> arguments;
        for (std::string& word : words) arguments.push_back(word.data());
        arguments.push_back(nullptr);
        const int error = ::posix_spawnp(&m_pid, arguments[0], &actions, nullptr, arguments.data(), environ);
        posix_spawn_file_actions_destroy(&actions);
        ::close(ends[1]);
        if (error == 0) return;
        ::close(m_output);
        throw Error(ErrorKind::input,
                    fmt::format("cannot start '{}': {}; {}", words[0], std::strerror(error), kHowToInstall));
    }
    ~Child() {
        ::close(m_output);
        if (m_pid > 0) ::kill(m_pid, SIGTERM);  // only after an exception; otherwise the child has been waited for
        if (m_pid > 0) status();
    }
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;

    /// Reads the child's output until it ends.
    std::string output() const {
        std::string text;
        char part[4096];
        for (;;) {
            throwIfInterrupted();
            const ssize_t count = ::read(m_output, part, sizeof part);
            if (count < 0 && errno == EINTR) continue;
            if (count <= 0) return text;
            text.append(part, static_cast<std::size_t>(count));
        }
    }
    /// The child's exit status.
    int status() {
        int status = 0;
        while (::waitpid(m_pid, &status, 0) < 0 && errno == EINTR) {
        }
        m_pid = -1;
        return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    }

  private:
    pid_t m_pid = -1;
    int m_output = -1;
};

std::vector<std::string> fieldsOf(const std::string& line) {
    std::vector<std::string> fields(1);
    for (const char c : line) {
        if (c == '\t')
            fields.emplace_back();
        else
            fields.back() += c;
    }
    fields.resize(std::max<std::size_t>(fields.size(), 4));
    return fields;
}

std::string textOf(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) throw Error(ErrorKind::input, path + ": cannot be read: " + std::strerror(errno));
    return {std::istreambuf_iterator<char>(file), {}};
}

void addScene(UsdScenes& out, const std::vector<std::string>& fields) {
    UsdScene scene{{std::stoi(fields[1])}, textOf(out.folder->path() + "/" + fields[2]), {}};
    if (!fields[3].empty()) scene.crop = parseCrop(fields[3]);
    if (!out.scenes.empty() && out.scenes.back().toml == scene.toml && out.scenes.back().crop == scene.crop)
        out.scenes.back().frames.push_back(scene.frames.front());
    else
        out.scenes.push_back(std::move(scene));
}

}  // namespace

TemporaryFolder::TemporaryFolder() {
    const char* const named = std::getenv("TMPDIR");
    m_path = std::string(named != nullptr && *named != '\0' ? named : "/tmp") + "/scrim-usd-XXXXXX";
    if (::mkdtemp(m_path.data()) == nullptr)
        throw Error(ErrorKind::output,
                    fmt::format("cannot make a folder for a stage's scenes: '{}': {}", m_path, std::strerror(errno)));
}

TemporaryFolder::~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(m_path, ignored);
}

bool isStage(const std::string& path) {
    const std::string extension = lowerExtension(path);
    return extension == ".usd" || extension == ".usda" || extension == ".usdc" || extension == ".usdz";
}

UsdScenes readStage(const std::string& path, const SceneOptions& options) {
    UsdScenes out;
    out.folder = std::make_shared<TemporaryFolder>();
    const std::vector<std::string> words = argumentsFor(path, out.folder->path(), options);
    Child child(words);
    std::istringstream lines(child.output());
    const int status = child.status();
    std::string first, last;
    for (std::string line; std::getline(lines, line);) {
        const std::vector<std::string> fields = fieldsOf(line);
        if (fields[0] == "stage") std::tie(first, last) = std::tie(fields[1], fields[2]);
        if (fields[0] == "scene") addScene(out, fields);
        if (fields[0] == "warning") out.warnings.push_back(fields[1]);
        if (fields[0] == "note") out.notes.push_back(fields[1]);
        if (fields[0] == "error")
            throw Error(fields[1] == "usage" ? ErrorKind::usage : ErrorKind::input,
                        fields[2].starts_with(path) ? fields[2] : path + ": " + fields[2]);
    }
    throwIfInterrupted();
    if (status != 0 || out.scenes.empty())
        throw Error(ErrorKind::input, fmt::format("{}: '{} -m scrim.usd' ended with status {}; {}", path, words[0],
                                                  status, kHowToInstall));
    if (options.frames.empty() && !options.printScene && first != last)
        throw Error(ErrorKind::usage,
                    fmt::format("{}: give the frames with --frames (the stage has {} to {})", path, first, last));
    return out;
}

}  // namespace scrim::cli
