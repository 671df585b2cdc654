// SPDX-License-Identifier: Apache-2.0
// Volumes of TIFF pages: which page is which slice, how far samples are apart (as ImageJ and OME write it into the
// first page's description), and slices in many files, sorted by the number in their names.
#include "scan.h"
#include "slice_files.h"
#include "tiff_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <string_view>

#include <fmt/format.h>

namespace scan {
namespace {

/// What a description says of the pages.
struct Stack {
    std::int64_t pages = 0;               ///< that should be there; 0: any number
    std::array<std::int64_t, 3> count{};  ///< slices, channels, frames; 0: not stated
    std::string order = "CZT";            ///< what changes from page to page first
    glm::dvec3 spacing{1};
    bool isSpaced = false;  ///< spacing was stated
    std::string unit;       ///< of spacing: "micron"; "": not stated
};

double numberIn(std::string_view text, double otherwise) {
    double value = otherwise;
    std::from_chars(text.data(), text.data() + text.size(), value);
    return std::isfinite(value) ? value : otherwise;
}

std::int64_t countIn(std::string_view text) {
    constexpr double kMost = 1e9;
    return static_cast<std::int64_t>(std::clamp(numberIn(text, 0), 0.0, kMost));
}

/// A unit as ImageJ and OME write it, which have several ways to write a micrometre; none that a terminal could stumble
/// over.
std::string unitIn(std::string_view text) {
    for (const std::string_view micron : {"micron", "um", "\\u00B5m", "\xb5m", "\xc2\xb5m", "\xce\xbcm", "microns"})
        if (text == micron) return "micron";
    const bool isPlain = std::all_of(text.begin(), text.end(), [](char c) { return c > ' ' && c <= '~'; });
    return isPlain && text.size() <= 16 && text != "pixel" ? std::string(text) : "";
}

/// The value of a line "key=value" of ImageJ's description.
std::string_view lineOf(std::string_view text, std::string_view key) {
    for (std::size_t at = 0; at < text.size(); at = std::min(text.find('\n', at), text.size() - 1) + 1) {
        const std::string_view line = text.substr(at, text.find('\n', at) - at);
        if (line.starts_with(key) && line.substr(key.size()).starts_with('=')) return line.substr(key.size() + 1);
    }
    return {};
}

Stack imageJ(std::string_view text, const TiffFile& file) {
    Stack stack;
    stack.pages = countIn(lineOf(text, "images"));
    stack.count = {countIn(lineOf(text, "slices")), countIn(lineOf(text, "channels")), countIn(lineOf(text, "frames"))};
    stack.unit = unitIn(lineOf(text, "unit"));
    const double depth = std::abs(numberIn(lineOf(text, "spacing"), 1));
    if (depth > 0) stack.spacing.z = depth;
    if (file.columnsPerUnit() > 0) stack.spacing.x = 1 / file.columnsPerUnit();
    if (file.rowsPerUnit() > 0) stack.spacing.y = 1 / file.rowsPerUnit();
    stack.isSpaced = !stack.unit.empty() || stack.spacing != glm::dvec3(1);
    return stack;
}

/// The value of an attribute of OME's element Pixels.
std::string_view attributeOf(std::string_view element, std::string_view name) {
    const std::string start = fmt::format(" {}=\"", name);
    const std::size_t at = element.find(start);
    if (at == std::string_view::npos) return {};
    const std::string_view rest = element.substr(at + start.size());
    return rest.substr(0, rest.find('"'));
}

Stack ome(std::string_view text, const TiffFile& file) {
    std::string_view pixels = text.substr(std::min(text.find("<Pixels "), text.size()));
    pixels = pixels.substr(0, pixels.find('>'));
    const auto of = [&](std::string_view name) { return attributeOf(pixels, name); };
    Stack stack;
    stack.count = {countIn(of("SizeZ")), countIn(of("SizeC")), countIn(of("SizeT"))};
    if (file.form().parts > 1) stack.count[1] = 1;        // the colours of one page
    const std::string_view order = of("DimensionOrder");  // "XYZCT"
    if (order.size() == 5) stack.order = order.substr(2);
    constexpr std::array<const char*, 3> kSizes{"PhysicalSizeX", "PhysicalSizeY", "PhysicalSizeZ"};
    for (int k = 0; k < 3; ++k) {
        const double size = numberIn(of(kSizes[static_cast<std::size_t>(k)]), 0);
        if (size > 0) stack.spacing[k] = size, stack.isSpaced = true;
    }
    const std::string_view unit = of("PhysicalSizeXUnit");
    if (stack.isSpaced) stack.unit = unit.empty() ? "micron" : unitIn(unit);
    return stack;
}

Stack stackOf(const TiffFile& file) {
    const std::string_view text = file.description();
    if (text.starts_with("ImageJ=")) return imageJ(text, file);
    if (text.find("<OME") != std::string_view::npos) return ome(text, file);
    return {};
}

/// The pages of one volume, from its first slice to its last.
std::vector<std::int64_t> pagesOf(Stack stack, std::int64_t pages, std::int64_t component, Scan& scan,
                                  const std::string& path) {
    auto& [slices, channels, frames] = stack.count;
    const bool isStated = stack.count != std::array<std::int64_t, 3>{};
    for (std::int64_t* const count : {&channels, &frames}) *count = std::clamp<std::int64_t>(*count, 1, pages + 1);
    if (slices == 0) slices = pages / channels / frames;
    const bool fits = slices > 0 && slices <= pages && channels <= pages / slices &&
                      frames == pages / (slices * channels) && slices * channels * frames == pages;
    if (!fits) {  // a file of a set describes all of the set
        stack.count = {pages, 1, 1};
        if (isStated)
            scan.notes.push_back(
                fmt::format("{}: its {} pages are not as many as its description states: read as slices", path, pages));
    }
    if (slices == 1 && channels == 1 && frames > 1) {
        scan.notes.push_back(fmt::format("{}: its {} pages are frames of a film: read as slices", path, frames));
        std::swap(slices, frames);
    }
    checkComponent(component, channels * frames, path);
    const std::int64_t volume = std::max<std::int64_t>(component, 0);
    std::vector<std::int64_t> chosen;
    for (std::int64_t z = 0; z < slices; ++z) {
        std::int64_t page = 0, step = 1;
        for (const char what : stack.order) {
            const std::size_t k = what == 'Z' ? 0 : what == 'C' ? 1 : 2;
            page += step * std::array{z, volume % channels, volume / channels}[k];
            step *= stack.count[k];
        }
        if (page >= pages) refuse(path, "its description is damaged");
        chosen.push_back(page);
    }
    return chosen;
}

void place(const Stack& stack, Scan& scan) {
    for (int k = 0; k < 3; ++k) scan.axes[k][k] = stack.spacing[k];
    scan.isSpaced = stack.isSpaced;
    scan.unit = stack.unit;
}

void begin(const TiffFile& file, std::int64_t slices, const std::string& path, Scan& scan) {
    scan.size = {file.form().columns, file.form().rows, slices};
    scan.type = file.form().parts == 3 ? colourTypeOf(file.form().type) : nameOf(file.form().type);
    if (file.hasPalette())
        scan.notes.push_back(fmt::format("{}: its samples are numbers of colours, which are taken for values", path));
    sampleCount(scan.size, path);
}

void add(const std::vector<float>& samples, const TiffForm& form, Scan& scan) {
    if (form.parts == 3) return addColours(samples, form.type, scan);
    scan.values.insert(scan.values.end(), samples.begin(), samples.end());
}

/// A name in turns of text and digits: text first, which may be "".
std::vector<std::string> partsOf(const std::string& name) {
    std::vector<std::string> parts{""};
    for (const char c : name) {
        const bool isDigit = c >= '0' && c <= '9';
        if (isDigit != (parts.size() % 2 == 0)) parts.emplace_back();
        parts.back() += c;
    }
    return parts;
}

/// The number that the digits stand for; -1: too large.
std::int64_t numberOf(const std::string& digits) {
    std::int64_t number = -1;
    std::from_chars(digits.data(), digits.data() + digits.size(), number);
    return number;
}

/// Sorts slices by the one number in which their names differ, and refuses files among which one is missing.
void sortByNumber(std::vector<SliceFile>& files, const std::string& path) {
    struct Numbered {
        std::int64_t number;
        SliceFile file;
    };
    const std::vector<std::string> first = partsOf(files.front().name);
    std::vector<std::vector<std::string>> names;
    for (const SliceFile& file : files) names.push_back(partsOf(file.name));
    std::size_t place = 0, places = 0;
    for (std::size_t i = 0; i < first.size(); ++i) {
        const auto differs = [&](const auto& name) {
            return name.size() != first.size() ||
                   (i % 2 == 0 ? name[i] != first[i] : numberOf(name[i]) != numberOf(first[i]));
        };
        const auto other = std::find_if(names.begin(), names.end(), differs);
        if (other == names.end()) continue;
        place = i;
        if (++places > 1 || i % 2 == 0)
            refuse(path, fmt::format("'{}' and '{}' differ in more than one number, expected the slices of one volume; "
                                     "name them by a pattern, such as 'cell_C1_*.tif'",
                                     files.front().name, files[static_cast<std::size_t>(other - names.begin())].name));
    }
    std::vector<Numbered> sorted;
    for (std::size_t k = 0; k < files.size(); ++k)
        sorted.push_back({places == 0 ? 0 : numberOf(names[k][place]), std::move(files[k])});
    std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.number < b.number; });
    std::int64_t least = 0;
    for (std::size_t k = 1; k < sorted.size(); ++k) {
        const std::int64_t step = sorted[k].number - sorted[k - 1].number;
        if (step < 1)
            refuse(path,
                   fmt::format("'{}' and '{}' have the same number", sorted[k - 1].file.name, sorted[k].file.name));
        least = k == 1 ? step : std::min(least, step);
    }
    for (std::size_t k = 1; k < sorted.size(); ++k)
        if (sorted[k].number - sorted[k - 1].number != least)
            refuse(path, fmt::format("a slice is missing between '{}' and '{}'", sorted[k - 1].file.name,
                                     sorted[k].file.name));
    for (std::size_t k = 0; k < sorted.size(); ++k) files[k] = std::move(sorted[k].file);
}

bool isTiffSlice(const SliceFile& file) {
    return isTiffFile(file.name) && beginsAsTiff(file.contents(kStart));
}

}  // namespace

bool isTiffFile(const std::string& path) {
    const std::string name = lowerCase(path);
    return name.ends_with(".tif") || name.ends_with(".tiff");
}

bool holdsTiffSlices(const std::string& folder) {
    const std::vector<SliceFile> files = filesIn(folder);
    const auto isDicom = [](const SliceFile& file) { return beginsAsDicom(file.contents(kStart)); };
    return std::any_of(files.begin(), files.end(), isTiffSlice) && std::none_of(files.begin(), files.end(), isDicom);
}

Scan readTiff(const std::string& path, std::int64_t component) {
    fileBytes(path);
    TiffFile file({"", path}, path);
    const Stack stack = stackOf(file);
    file.assumePages(stack.pages);
    if (stack.pages > 0 && stack.pages != file.pages())
        refuse(path, fmt::format("holds {} of the {} pages that its description states", file.pages(), stack.pages));
    Scan scan;
    const std::vector<std::int64_t> pages = pagesOf(stack, file.pages(), component, scan, path);
    begin(file, static_cast<std::int64_t>(pages.size()), path, scan);
    place(stack, scan);
    if (pages.size() == 1 && file.pages() == 1)
        scan.notes.push_back(fmt::format(
            "{}: holds one slice; slices in many files are read by their folder, or by a pattern such as '{}'", path,
            "slice_*.tif"));
    for (const std::int64_t page : pages) add(file.samples(page), file.form(), scan);
    return scan;
}

Scan readTiffSlices(const std::string& path) {
    std::vector<SliceFile> files = isPattern(path) ? filesMatching(path) : filesIn(path);
    std::erase_if(files, [](const SliceFile& file) { return !isTiffSlice(file); });
    if (files.empty()) refuse(path, "there is no TIFF file of such a name");
    sortByNumber(files, path);
    Scan scan;
    TiffForm form;
    for (const SliceFile& slice : files) {
        const std::string name = fmt::format("{}: '{}'", path, slice.name);
        TiffFile file(slice, name);
        if (file.pages() != 1)
            refuse(name, fmt::format("holds {} pages beside other slices, expected one", file.pages()));
        if (scan.values.empty()) {
            form = file.form();
            begin(file, static_cast<std::int64_t>(files.size()), path, scan);
            place(stackOf(file), scan);
        }
        if (file.form() != form)
            refuse(name,
                   fmt::format("is {}, expected {} as '{}'", textOf(file.form()), textOf(form), files.front().name));
        add(file.samples(0), form, scan);
    }
    return scan;
}

}  // namespace scan
