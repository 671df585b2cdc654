// SPDX-License-Identifier: Apache-2.0
// Reads MRC and CCP4 maps of electron microscopy (MRC2014, A. Cheng et al., J. Struct. Biol. 192, 2015): a header of
// 1024 bytes, an extended one, and the samples. A world unit is an angstrom.
#include "scan.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>

#include <fmt/format.h>

namespace scan {
namespace {

constexpr std::size_t kHeader = 1024;

class Header {
  public:
    explicit Header(const std::string& path) {
        std::ifstream file(path, std::ios::binary);
        file.read(m_bytes.data(), kHeader);
        if (file.gcount() != static_cast<std::streamsize>(kHeader)) refuse(path, "is not an MRC map: it is too short");
        // The stamp of the machine is often missing; then the mode shows the order.
        constexpr std::size_t kStamp = 212;
        m_big = m_bytes[kStamp] == 0x11;
        if (m_bytes[kStamp] != 0x11 && m_bytes[kStamp] != 0x44) m_big = mode() < 0 || mode() > 127;
        if (std::string_view(&m_bytes[208], 3) != "MAP" &&
            (mode() < 0 || mode() > 127 || word(1) < 1 || word(1) > 1 << 20))
            refuse(path, "is not an MRC map");
    }
    /// Words are numbered from 1, as the standard does.
    std::int32_t word(int number) const { return read<std::int32_t>(number); }
    double real(int number) const { return static_cast<double>(read<float>(number)); }
    std::int32_t mode() const { return word(4); }
    bool bigEndian() const { return m_big; }

  private:
    template <typename T>
    T read(int number) const {
        std::array<char, 4> raw{};
        std::copy_n(m_bytes.begin() + 4 * (number - 1), 4, raw.begin());
        if (m_big == (std::endian::native == std::endian::little)) std::reverse(raw.begin(), raw.end());
        return std::bit_cast<T>(raw);
    }
    std::array<char, kHeader> m_bytes{};
    bool m_big = false;
};

SampleType typeOf(const Header& header, const std::string& path) {
    switch (header.mode()) {
        case 0:
            return SampleType::int8;
        case 1:
            return SampleType::int16;
        case 2:
            return SampleType::float32;
        case 6:
            return SampleType::uint16;
        case 12:
            return SampleType::float16;
        default:
            refuse(path,
                   fmt::format("holds samples of mode {}, expected 0, 1, 2, 6 or 12 (real numbers)", header.mode()));
    }
}

/// Steps and origin: the cell is divided into intervals along the crystal's axes, which columns, rows and sections
/// follow in any order.
void place(const Header& header, const std::string& path, Scan& scan) {
    std::array<int, 3> axisOf{header.word(17), header.word(18), header.word(19)};
    if (axisOf == std::array{0, 0, 0}) axisOf = {1, 2, 3};
    std::array<int, 3> sorted = axisOf;
    std::sort(sorted.begin(), sorted.end());
    if (sorted != std::array{1, 2, 3}) refuse(path, "its axes are damaged (MAPC, MAPR, MAPS)");
    glm::dvec3 origin(header.real(50), header.real(51), header.real(52));
    const bool isPlaced = origin != glm::dvec3(0) && glm::dot(origin, origin) < 1e30;
    scan.axes = glm::dmat3(0);
    scan.origin = isPlaced ? origin : glm::dvec3(0);
    for (int k = 0; k < 3; ++k) {
        const int axis = axisOf[static_cast<std::size_t>(k)] - 1;
        const double cell = header.real(11 + axis);
        const int intervals = header.word(8 + axis);
        const double step = cell > 0 && intervals > 0 && std::isfinite(cell) ? cell / intervals : 1;
        scan.axes[k][axis] = step;
        if (!isPlaced) scan.origin[axis] = step * header.word(5 + k);
    }
}

}  // namespace

Scan readMrc(const std::string& path) {
    fileBytes(path);
    const Header header(path);
    RawLayout layout;
    layout.size = {header.word(1), header.word(2), header.word(3)};
    layout.type = typeOf(header, path);
    layout.bigEndian = header.bigEndian();
    layout.header = static_cast<std::int64_t>(kHeader) + std::max(header.word(24), 0);
    layout.exact = false;
    Scan scan;
    scan.size = layout.size;
    scan.type = nameOf(layout.type);
    place(header, path, scan);
    scan.values = readRaw(path, layout);
    return scan;
}

}  // namespace scan
