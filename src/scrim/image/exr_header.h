// SPDX-License-Identifier: Apache-2.0
// The parts that flat and deep OpenEXR files share: the header, the output stream, and the report of failures. For code
// that writes them. No other header than this and exr_tile.h, for code that merges them, includes OpenEXR.
#pragma once

#include <scrim/base/atomic_file.h>
#include <scrim/base/error.h>
#include <scrim/image/exr.h>

#include <Imath/half.h>
#include <OpenEXR/ImfCompression.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <exception>
#include <fstream>
#include <new>
#include <string>

namespace scrim {

/// An output stream that remembers its first failure. OpenEXR swallows exceptions while it closes a
/// file, so a full disk would go unnoticed; `close` reports it.
class CheckedStream : public Imf::OStream {
  public:
    explicit CheckedStream(const std::string& path);
    void write(const char bytes[], int count) override;
    uint64_t tellp() override { return static_cast<uint64_t>(std::streamoff(m_file.tellp())); }
    void seekp(uint64_t position) override;
    void close();

  private:
    void check();

    std::ofstream m_file;
    int m_error = 0;
};

/// The window as OpenEXR's closed box, which includes both corners.
Imath::Box2i closedBox(const PixelWindow& window);

/// The compression for one of the names in exrCompressions(). Throws Error(usage) for any other name.
Imf::Compression exrCompressionNamed(const std::string& name);

/// The header of a scanline file, still without channels. Throws Error(usage) where the compression is unknown.
Imf::Header makeExrHeader(const PixelWindow& dataWindow, const ExrOptions& options, const ExrAttributes& attributes);

/// Converts to half (see ExrOptions::half); values beyond its range are clamped and counted.
inline half clampedHalf(float value, std::size_t& clamped) {
    constexpr float kLargestHalf = 65504.0f;
    if (std::fabs(value) > kLargestHalf) {
        ++clamped;
        value = std::copysign(kLargestHalf, value);
    }
    return half(value);
}

/// Calls `write` with an AtomicFile for `path`, commits the file, and returns the result of
/// `write`. Exceptions of OpenEXR become Errors.
template <typename Write>
auto writingExr(const std::string& path, const Write& write) {
    AtomicFile file(path);
    try {
        const auto result = write(file);
        file.commit();
        return result;
    } catch (const Error&) {
        throw;
    } catch (const std::bad_alloc&) {
        throw Error(ErrorKind::memory, fmt::format("cannot write '{}': out of memory", path));
    } catch (const std::exception& exception) {
        throw Error(ErrorKind::output, fmt::format("cannot write '{}': {}", path, shortened(exception.what())));
    }
}

}  // namespace scrim
