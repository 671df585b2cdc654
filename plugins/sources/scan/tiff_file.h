// SPDX-License-Identifier: Apache-2.0
// The pages of a TIFF file: what a volume of pages needs, and no more of TIFF than that (TIFF 6.0, and BigTIFF).
#pragma once

#include "scan.h"
#include "slice_files.h"
#include "tiff_packing.h"

#include <array>
#include <cstdint>
#include <fstream>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace scan {

/// What all pages of a file have in common.
struct TiffForm {
    std::int64_t columns = 0, rows = 0;
    int parts = 1;  ///< 3: a sample is red, green and blue
    SampleType type = SampleType::uint8;
    bool operator==(const TiffForm&) const = default;
};
/// "12 x 10 of uint8".
std::string textOf(const TiffForm& form);

/// A TIFF or BigTIFF file of pages of one form; thumbnails among them are left out. All members throw "PATH: ..."
/// where the file is damaged, or is of a kind that is not read.
class TiffFile {
  public:
    /// Reads the headers of all pages. `path`, for messages, is what the user knows the file by.
    TiffFile(const SliceFile& file, std::string path);

    const TiffForm& form() const { return m_form; }
    std::int64_t pages() const { return m_pages; }
    const std::string& description() const { return m_description; }  ///< ImageDescription of the first page
    double columnsPerUnit() const { return m_perUnit[0]; }            ///< XResolution; 0: not stated
    double rowsPerUnit() const { return m_perUnit[1]; }
    bool hasPalette() const { return m_hasPalette; }  ///< samples are numbers of colours

    /// Takes the file for one of `count` pages whose samples follow each other behind the only header, as ImageJ writes
    /// files beyond 4 GB. Does nothing where there are more headers than one, or less samples.
    void assumePages(std::int64_t count);

    /// The samples of page `page` from 0 on: x fastest, then y; the parts of a sample follow each other.
    std::vector<float> samples(std::int64_t page);

  private:
    /// A field of a header: `count` values of type `type` that begin at byte `at` of the file.
    struct Field {
        std::uint64_t type = 0, count = 0, at = 0;
    };
    using Fields = std::map<std::uint64_t, Field>;  ///< by their tags
    /// Where a page's samples lie: in strips, or in tiles of equal size.
    struct Layout {
        std::int64_t width = 0, height = 0;  ///< of a strip or a tile
        bool isTiled = false;
        TiffPacking packing = TiffPacking::none;
        std::uint64_t predictor = 1;
        std::vector<std::uint64_t> begins, lengths;  ///< bytes of each, row by row, plane by plane
    };

    std::string bytesAt(std::uint64_t begin, std::uint64_t count);
    std::uint64_t numberIn(std::string_view bytes) const;
    std::uint64_t numberAt(std::uint64_t begin, std::uint64_t bytes);
    Fields fieldsAt(std::uint64_t header, std::uint64_t& next);
    std::vector<std::uint64_t> numbersOf(const Fields& fields, std::uint64_t tag);
    std::uint64_t numberOf(const Fields& fields, std::uint64_t tag, std::uint64_t otherwise);
    double ratioOf(const Fields& fields, std::uint64_t tag);
    TiffForm formOf(const Fields& fields);
    Layout layoutOf(const Fields& fields);
    void readCommon(const Fields& fields);
    void checkBytes(TiffPacking packing) const;
    std::int64_t pageBytes() const;
    std::string chunk(const Layout& layout, std::size_t number, std::int64_t rows);
    std::string plane(const Layout& layout, std::size_t& number);

    std::string m_path, m_description;
    std::ifstream m_file;
    std::uint64_t m_begin = 0, m_size = 0;  ///< the part of the file that is read
    bool m_bigEndian = false, m_isBig = false;
    TiffForm m_form;
    std::vector<std::uint64_t> m_headers;  ///< of the pages
    std::int64_t m_pages = 0;
    std::array<double, 2> m_perUnit{};
    bool m_hasPalette = false, m_isInverted = false, m_isPlanar = false;
};

}  // namespace scan
