// SPDX-License-Identifier: Apache-2.0
// Small files that volume sources read, as bytes: NIfTI, OBJ, PLY, and anything gzipped.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>

#include <fmt/format.h>
#include <zlib.h>

namespace scrim::test {

inline std::string gzipped(const std::string& bytes) {
    constexpr int kGzip = 16 + MAX_WBITS;
    z_stream stream{};
    deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, kGzip, 8, Z_DEFAULT_STRATEGY);
    std::string out(deflateBound(&stream, bytes.size()), '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream.avail_in = static_cast<uInt>(bytes.size());
    stream.next_out = reinterpret_cast<Bytef*>(out.data());
    stream.avail_out = static_cast<uInt>(out.size());
    deflate(&stream, Z_FINISH);
    out.resize(stream.total_out);
    deflateEnd(&stream);
    return out;
}

/// A NIfTI-1 file of uint8 samples.
struct NiftiHeader {
    std::int16_t dims[8]{3, 2, 3, 4, 1, 1, 1, 1};
    std::int16_t type = 2, bits = 8;
    float spacing[8]{1, 2, 3, 4, 0, 0, 0, 0};
    float slope = 0, intercept = 0;
    bool sform = false;
    bool pair = false;  ///< the samples are in another file, "NAME.img" beside "NAME.hdr"

    std::string bytes() const {
        std::string h(352, '\0');
        const auto put = [&](std::size_t at, const auto& value) { std::memcpy(h.data() + at, &value, sizeof value); };
        put(0, std::int32_t{348});
        put(40, dims);
        put(70, type);
        put(72, bits);
        put(76, spacing);
        put(108, pair ? 0.0f : 352.0f);
        put(112, slope);
        put(116, intercept);
        if (sform) {
            put(254, std::int16_t{1});
            const float rows[12]{0, 0, 4, 10, 2, 0, 0, 20, 0, 3, 0, 30};
            put(280, rows);
        }
        std::memcpy(h.data() + 344, pair ? "ni1" : "n+1", 4);
        return h;
    }
};

/// A cube of edge 2 about the origin.
inline constexpr const char* kCubeObj =
    "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n"
    "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 1 5 8 4\nf 2 3 7 6\n";

/// The same cube as PLY. `format`: "ascii", "binary_little_endian" or "binary_big_endian".
inline std::string cubePly(const std::string& format) {
    const float points[8][3]{{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                             {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
    const std::int32_t faces[6][4]{{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {2, 3, 7, 6}, {0, 4, 7, 3}, {1, 2, 6, 5}};
    std::string out = "ply\nformat " + format +
                      " 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
                      "element face 6\nproperty list uchar int vertex_indices\nend_header\n";
    const auto put = [&](auto value) {
        std::string bytes(sizeof value, '\0');
        std::memcpy(bytes.data(), &value, sizeof value);
        if ((format == "binary_big_endian") == (std::endian::native == std::endian::little))
            std::reverse(bytes.begin(), bytes.end());
        out += format == "ascii" ? fmt::format("{} ", value) : bytes;
    };
    for (const auto& p : points) {
        for (const float c : p) put(c);
        if (format == "ascii") out += "\n";
    }
    for (const auto& f : faces) {
        out += format == "ascii" ? "4 " : std::string(1, '\4');
        for (const std::int32_t i : f) put(i);
        if (format == "ascii") out += "\n";
    }
    return out;
}

}  // namespace scrim::test
