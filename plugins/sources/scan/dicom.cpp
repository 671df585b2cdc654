// SPDX-License-Identifier: Apache-2.0
// Reads DICOM series with GDCM: the headers of all slices first, which decide what belongs together, where it lies and
// whether anything is missing; then the samples, slice by slice.
#include "scan.h"
#include "slice_files.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <sstream>

#include <fmt/format.h>
#include <gdcmAttribute.h>
#include <gdcmImageReader.h>
#include <gdcmTrace.h>
#include <glm/geometric.hpp>

namespace scan {
namespace {

constexpr const char* kNoDicom = "is not a DICOM file, or holds no picture";

/// What makes values of samples: Hounsfield units for CT.
struct Line {
    double slope = 1, intercept = 0;
};

/// What a header says of a slice, or of a file of many frames, of which each becomes a slice.
struct Slice {
    SliceFile file;
    std::string series, syntax;
    std::int64_t columns = 0, rows = 0, frames = 1;
    std::int64_t frame = 0;  ///< the one that this slice is, of `frames`
    int highBit = -1;        ///< the highest bit of a sample in its word; -1: the header does not say
    glm::dvec3 position{0}, right{1, 0, 0}, down{0, 1, 0};  ///< of the first sample; directions of columns and rows
    glm::dvec2 spacing{1};                                  ///< along right and down
    double thickness = 1;
    bool placed = false;  ///< the header has a position and directions
    bool isGrey = true;
    std::shared_ptr<const std::vector<Line>> lines = nullptr;  ///< of each frame of the file; null: one for all of it
    /// What messages call it.
    std::string name() const { return frames > 1 ? fmt::format("frame {}", frame + 1) : file.name; }
    glm::dvec3 normal() const { return glm::cross(right, down); }
    double along(const glm::dvec3& axis) const { return glm::dot(position, axis); }
};

template <typename Attribute>
bool read(const gdcm::DataSet& data, Attribute& attribute) {
    const gdcm::DataElement& element = data.GetDataElement(attribute.GetTag());
    if (!data.FindDataElement(attribute.GetTag()) || element.IsEmpty()) return false;
    attribute.SetFromDataElement(element);
    return true;
}

std::string textOf(const gdcm::DataSet& data, const gdcm::Tag& tag) {
    if (!data.FindDataElement(tag)) return "";
    const gdcm::ByteValue* value = data.GetDataElement(tag).GetByteValue();
    if (value == nullptr) return "";
    std::string text(value->GetPointer(), value->GetLength());
    while (!text.empty() && (text.back() == '\0' || text.back() == ' ')) text.pop_back();
    return text;
}

/// The header of a slice; none where the file holds no picture.
std::optional<Slice> headerOf(const SliceFile& file, const std::string& path) {
    const std::string bytes = file.contents();
    if (!beginsAsDicom(bytes)) return {};
    std::istringstream in(bytes);
    gdcm::Reader reader;
    reader.SetStream(in);
    if (!reader.ReadUpToTag(gdcm::Tag(0x7fe0, 0x0010)))
        refuse(path, fmt::format("the DICOM header of '{}' is damaged", file.name));
    const gdcm::DataSet& data = reader.GetFile().GetDataSet();
    gdcm::Attribute<0x0028, 0x0010> rows;
    gdcm::Attribute<0x0028, 0x0011> columns;
    if (!read(data, rows) || !read(data, columns)) return {};
    Slice slice;
    slice.file = file;
    slice.series = textOf(data, gdcm::Tag(0x0020, 0x000e));
    slice.syntax = reader.GetFile().GetHeader().GetDataSetTransferSyntax().GetString();
    slice.rows = rows.GetValue();
    slice.columns = columns.GetValue();
    gdcm::Attribute<0x0028, 0x0002> samples{1};
    if (read(data, samples)) slice.isGrey = samples.GetValue() == 1;
    gdcm::Attribute<0x0028, 0x0102> highBit;  // GDCM's PixelFormat replaces what is unusual
    if (read(data, highBit)) slice.highBit = highBit.GetValue();
    gdcm::Attribute<0x0028, 0x0008> frames{1};
    if (read(data, frames)) slice.frames = std::max(frames.GetValue(), 1);
    gdcm::Attribute<0x0020, 0x0032> position;
    gdcm::Attribute<0x0020, 0x0037> directions;
    if (read(data, position) && read(data, directions)) {
        slice.placed = true;
        for (int k = 0; k < 3; ++k) {
            slice.position[k] = position.GetValue(static_cast<unsigned>(k));
            slice.right[k] = directions.GetValue(static_cast<unsigned>(k));
            slice.down[k] = directions.GetValue(static_cast<unsigned>(k + 3));
        }
    }
    gdcm::Attribute<0x0028, 0x0030> spacing;
    if (read(data, spacing)) slice.spacing = {spacing.GetValue(1), spacing.GetValue(0)};
    gdcm::Attribute<0x0018, 0x0050> thickness;
    if (read(data, thickness)) slice.thickness = thickness.GetValue();
    return slice;
}

/// The slices of the series that `chosen`, a file's name, belongs to; "": of the only one. `path` is for messages.
std::vector<Slice> seriesOf(const std::vector<SliceFile>& files, const std::string& chosen, const std::string& path) {
    std::map<std::string, std::vector<Slice>> all;
    std::string wanted;
    bool isChosen = false;
    for (const SliceFile& file : files) {
        std::optional<Slice> slice = headerOf(file, path);
        if (!slice) continue;
        if (file.name == chosen) {
            wanted = slice->series;
            isChosen = true;
        }
        all[slice->series].push_back(std::move(*slice));
    }
    if (!chosen.empty() && !isChosen) refuse(path, kNoDicom);
    if (all.empty()) refuse(path, "no file in the folder holds a DICOM picture");
    if (!chosen.empty()) return all[wanted];
    if (all.size() > 1) {
        std::string found;
        for (const auto& [series, slices] : all)
            found += fmt::format("{}{} from '{}' on ({})", found.empty() ? "" : ", ", slices.size(),
                                 slices.front().file.name, series);
        refuse(path, fmt::format("the folder holds {} series: {}; expected one, or one of its files in place of the "
                                 "folder",
                                 all.size(), found.substr(0, 600)));
    }
    return std::move(all.begin()->second);
}

/// Refuses slices that are no stack of equal pictures.
void checkStack(const std::vector<Slice>& slices, const std::string& path) {
    constexpr double kParallel = 1e-3;
    const Slice& first = slices.front();
    for (const Slice& slice : slices) {
        const std::string& name = slice.file.name;
        if (!slice.isGrey) refuse(path, fmt::format("'{}' holds colours, expected one value for each sample", name));
        if (slices.size() > 1 && slice.frames > 1)
            refuse(path, fmt::format("'{}' holds {} frames beside other slices, expected one", name, slice.frames));
        if (slice.rows != first.rows || slice.columns != first.columns || slice.spacing != first.spacing)
            refuse(path, fmt::format("'{}' has {} x {} samples of {} x {} mm, '{}' has {} x {} of {} x {}; expected "
                                     "equal slices",
                                     name, slice.columns, slice.rows, slice.spacing.x, slice.spacing.y, first.file.name,
                                     first.columns, first.rows, first.spacing.x, first.spacing.y));
        if (slices.size() == 1) continue;
        if (!slice.placed)
            refuse(path, fmt::format("'{}' has no position (ImagePositionPatient and ImageOrientationPatient), without "
                                     "which slices cannot be sorted",
                                     name));
        if (glm::length(slice.right - first.right) > kParallel || glm::length(slice.down - first.down) > kParallel)
            refuse(path, fmt::format("'{}' is turned against '{}'; expected parallel slices", name, first.file.name));
    }
}

/// Item number `item`, from 1 on, of a sequence of attributes; none where it is not there.
std::optional<gdcm::DataSet> itemOf(const gdcm::DataSet& data, const gdcm::Tag& sequence, std::int64_t item = 1) {
    if (!data.FindDataElement(sequence)) return {};
    const auto items = data.GetDataElement(sequence).GetValueAsSQ();
    if (!items || item > static_cast<std::int64_t>(items->GetNumberOfItems())) return {};
    return items->GetItem(static_cast<std::size_t>(item)).GetNestedDataSet();
}

/// A group of attributes of a frame, numbered from 1 on: its own, or that of all frames.
std::optional<gdcm::DataSet> frameGroup(const gdcm::DataSet& data, const gdcm::Tag& group, std::int64_t frame) {
    const gdcm::Tag shared(0x5200, 0x9229), perFrame(0x5200, 0x9230);
    const auto own = itemOf(data, perFrame, frame), all = itemOf(data, shared);
    const auto found = own ? itemOf(*own, group) : std::nullopt;
    return found || !all ? found : itemOf(*all, group);
}

/// The positions of a file's frames; none unless each has one.
std::vector<glm::dvec3> framePositions(const gdcm::DataSet& data, std::int64_t frames) {
    std::vector<glm::dvec3> positions;
    for (std::int64_t k = 1; k <= frames; ++k) {
        const auto plane = frameGroup(data, gdcm::Tag(0x0020, 0x9113), k);
        gdcm::Attribute<0x0020, 0x0032> position;
        if (!plane || !read(*plane, position)) return {};
        positions.emplace_back(position.GetValue(0), position.GetValue(1), position.GetValue(2));
    }
    return positions;
}

/// The slopes and intercepts of a file's frames, of which each may have its own; null unless each has one.
std::shared_ptr<const std::vector<Line>> frameLines(const gdcm::DataSet& data, std::int64_t frames) {
    auto lines = std::make_shared<std::vector<Line>>();
    for (std::int64_t k = 1; k <= frames; ++k) {
        const auto group = frameGroup(data, gdcm::Tag(0x0028, 0x9145), k);
        gdcm::Attribute<0x0028, 0x1053> slope;
        gdcm::Attribute<0x0028, 0x1052> intercept;
        if (!group || !read(*group, slope) || !read(*group, intercept)) return nullptr;
        lines->push_back({slope.GetValue(), intercept.GetValue()});
    }
    return lines;
}

/// What a file of many frames says of its first frame, in groups of attributes, which GDCM reads from sorted frames
/// only.
void readFirstGroups(const gdcm::DataSet& data, Slice& slice) {
    gdcm::Attribute<0x0028, 0x0030> spacing;
    gdcm::Attribute<0x0018, 0x0050> thickness;
    gdcm::Attribute<0x0020, 0x0037> directions;
    if (const auto measures = frameGroup(data, gdcm::Tag(0x0028, 0x9110), 1)) {
        if (read(*measures, spacing)) slice.spacing = {spacing.GetValue(1), spacing.GetValue(0)};
        if (read(*measures, thickness)) slice.thickness = thickness.GetValue();
    }
    const auto orientation = frameGroup(data, gdcm::Tag(0x0020, 0x9116), 1);
    if (!orientation || !read(*orientation, directions)) return;
    for (int k = 0; k < 3; ++k) {
        slice.right[k] = directions.GetValue(static_cast<unsigned>(k));
        slice.down[k] = directions.GetValue(static_cast<unsigned>(k + 3));
    }
}

/// The slices of a file of many frames: where the frames themselves have no positions, they follow each other by
/// SpacingBetweenSlices (which nuclear medicine gives a sign), or else by what GDCM knows of the kind of picture, or by
/// their thickness.
std::vector<Slice> framesOf(Slice file, const std::string& path) {
    std::istringstream in(file.file.contents());
    gdcm::ImageReader reader;
    reader.SetStream(in);
    if (!reader.Read()) refuse(path, "its frames are damaged or incomplete");
    const gdcm::Image& image = reader.GetImage();
    const gdcm::DataSet& data = reader.GetFile().GetDataSet();
    const double* cosines = image.GetDirectionCosines();
    file.right = {cosines[0], cosines[1], cosines[2]};
    file.down = {cosines[3], cosines[4], cosines[5]};
    file.spacing = {image.GetSpacing(0), image.GetSpacing(1)};
    readFirstGroups(data, file);
    file.lines = frameLines(data, file.frames);
    const glm::dvec3 first(image.GetOrigin(0), image.GetOrigin(1), image.GetOrigin(2));
    double step = image.GetSpacing(2);
    gdcm::Attribute<0x0018, 0x0088> between;
    const auto measures = frameGroup(data, gdcm::Tag(0x0028, 0x9110), 1);
    if ((read(data, between) || (measures && read(*measures, between))) && between.GetValue() != 0)
        step = between.GetValue();
    else if (step <= 0 || step == 1)  // 1: GDCM does not know
        step = file.thickness > 0 ? file.thickness : 1;
    const std::vector<glm::dvec3> positions = framePositions(data, file.frames);
    std::vector<Slice> slices(static_cast<std::size_t>(file.frames), file);
    for (std::size_t k = 0; k < slices.size(); ++k) {
        slices[k].frame = static_cast<std::int64_t>(k);
        slices[k].position = positions.empty() ? first + file.normal() * (step * double(k)) : positions[k];
    }
    return slices;
}

/// The distances from slice to slice of a sorted stack.
struct Steps {
    std::vector<double> all;
    double least = 0, usual = 0, most = 0;
    bool uneven = false;
};

/// Refuses stacks with several slices at one place, and those that lack a slice here and there.
Steps stepsOf(const std::vector<Slice>& slices, const std::string& path) {
    // Relative to the usual step; and the part of the steps that may be gaps of a series with one distance.
    constexpr double kSame = 0.05, kGap = 1.5, kUneven = 0.2, kGapsAmong = 0.1;
    const glm::dvec3 axis = slices.front().normal();
    Steps steps;
    for (std::size_t i = 1; i < slices.size(); ++i)
        steps.all.push_back(slices[i].along(axis) - slices[i - 1].along(axis));
    std::vector<double> sorted = steps.all;
    std::sort(sorted.begin(), sorted.end());
    steps.least = sorted.front();
    steps.usual = sorted[(sorted.size() - 1) / 2];
    steps.most = sorted.back();
    const auto gaps = std::count_if(sorted.begin(), sorted.end(), [&](double s) { return s > kGap * steps.usual; });
    const bool isGap = double(gaps) <= std::max(1.0, kGapsAmong * double(sorted.size()));
    for (std::size_t i = 0; i < steps.all.size(); ++i) {
        const double step = steps.all[i];
        if (steps.usual <= 0 || step < kSame * steps.usual)
            refuse(path, fmt::format("'{}' and '{}' are at the same place; expected a series with one volume, not "
                                     "several phases or echoes",
                                     slices[i].name(), slices[i + 1].name()));
        if (step > kGap * steps.usual && isGap)
            refuse(path,
                   fmt::format("a slice is missing between '{}' and '{}': they are {:.4g} mm apart, others {:.4g}",
                               slices[i].name(), slices[i + 1].name(), step, steps.usual));
        steps.uneven = steps.uneven || std::abs(step - steps.usual) > kUneven * steps.usual;
    }
    return steps;
}

/// Puts slices at even distances, between which the values run straight, in place of the uneven ones that a stack has.
/// The distance is the least between two slices, so that nothing gets lost.
void makeEven(Scan& scan, const Steps& steps, const std::string& path) {
    constexpr double kFinest = 0.2;  // of the usual distance: or a single pair would make too many slices
    double length = 0;
    for (const double step : steps.all) length += step;
    Size size = scan.size;
    size[2] = std::lround(length / std::max(steps.least, kFinest * steps.usual)) + 1;
    std::vector<float> values(static_cast<std::size_t>(sampleCount(size, path)));
    const auto plane = static_cast<std::size_t>(size[0] * size[1]);
    const double even = length / double(size[2] - 1);
    std::size_t below = 0;
    double at = 0;  // that of slice `below`
    for (std::size_t z = 0; z < static_cast<std::size_t>(size[2]); ++z) {
        while (below + 1 < steps.all.size() && at + steps.all[below] <= even * double(z)) at += steps.all[below++];
        const auto part = static_cast<float>(std::clamp((even * double(z) - at) / steps.all[below], 0.0, 1.0));
        const float *low = &scan.values[below * plane], *high = low + plane;
        for (std::size_t i = 0; i < plane; ++i) values[z * plane + i] = low[i] + part * (high[i] - low[i]);
    }
    scan.notes.push_back(
        fmt::format("{}: its {} slices are {:.4g} to {:.4g} mm apart: resampled to {}, {:.4g} mm apart", path,
                    scan.size[2], steps.least, steps.most, size[2], even));
    scan.axes[2] *= double(scan.size[2] - 1) / double(size[2] - 1);
    scan.size = size;
    scan.values = std::move(values);
}

/// A sample as stored: `bits` of a word of `bytes`, little endian, from bit number `lowest` on.
double sampleAt(const char* at, int bytes, int bits, int lowest, bool isSigned) {
    std::uint32_t word = 0;
    for (int b = 0; b < bytes; ++b) word |= std::uint32_t(static_cast<unsigned char>(at[b])) << (8 * b);
    word >>= lowest;
    if (bits < 32) word &= (1U << bits) - 1;
    if (!isSigned) return word;
    const std::uint32_t sign = 1U << (bits - 1);
    return double(static_cast<std::int32_t>(word ^ sign)) - double(static_cast<std::int32_t>(sign));
}

/// The lowest bit of a sample within its word. What is compressed (except by RLE, which packs words) has none above.
int lowestBit(const gdcm::PixelFormat& format, const Slice& slice) {
    const gdcm::TransferSyntax::TSType type = gdcm::TransferSyntax::GetTSType(slice.syntax.c_str());
    if (gdcm::TransferSyntax(type).IsEncapsulated() && type != gdcm::TransferSyntax::RLELossless) return 0;
    const int lowest = slice.highBit + 1 - format.GetBitsStored();
    return lowest > 0 && slice.highBit < format.GetBitsAllocated() ? lowest : 0;
}

/// Adds the samples of a slice, or of all of its file's frames, by its slope and intercept: Hounsfield units for CT.
void addSamples(const Slice& slice, const std::string& path, Scan& scan) {
    const std::string& name = slice.file.name;
    std::istringstream in(slice.file.contents());
    gdcm::ImageReader reader;
    reader.SetStream(in);
    const auto unreadable = [&] {
        const gdcm::TransferSyntax syntax(gdcm::TransferSyntax::GetTSType(slice.syntax.c_str()));
        refuse(path, syntax.IsEncapsulated()
                         ? fmt::format("the samples of '{}' are compressed in a form that is not read (transfer syntax "
                                       "{}), or damaged; decompress them (gdcmconv --raw does)",
                                       name, slice.syntax)
                         : fmt::format("the samples of '{}' are damaged or incomplete", name));
    };
    if (!reader.Read()) unreadable();
    gdcm::Image& image = reader.GetImage();
    const gdcm::PixelFormat format = image.GetPixelFormat();
    const int bytes = format.GetBitsAllocated() / 8, bits = format.GetBitsStored();
    if (bytes < 1 || bytes > 4 || bits < 1 || bits > 8 * bytes || format.GetSamplesPerPixel() != 1)
        refuse(path, fmt::format("'{}' holds samples of {} bits; expected whole numbers of 8 to 32", name,
                                 format.GetBitsAllocated()));
    const gdcm::ByteValue* const stored = image.GetDataElement().GetByteValue();
    const std::size_t count = static_cast<std::size_t>(slice.columns * slice.rows * slice.frames);
    const std::size_t least = count * static_cast<std::size_t>(bytes);
    // GDCM makes up what a file lacks.
    if (image.GetBufferLength() < least || (stored != nullptr && stored->GetLength() < least)) unreadable();
    const int lowest = lowestBit(format, slice);
    if (lowest > 0) {  // or GDCM would clear bits from 0 on that it takes for unused
        gdcm::PixelFormat words = format;
        words.SetBitsStored(format.GetBitsAllocated());
        image.SetPixelFormat(words);
    }
    std::vector<char> buffer(image.GetBufferLength());
    if (!image.GetBuffer(buffer.data())) unreadable();
    const bool isSigned = format.GetPixelRepresentation() == 1;
    const Line whole{image.GetSlope(), image.GetIntercept()};
    const char* at = buffer.data();
    for (std::size_t frame = 0; frame < static_cast<std::size_t>(slice.frames); ++frame) {
        const Line line = slice.lines ? (*slice.lines)[frame] : whole;
        for (std::int64_t i = 0; i < slice.columns * slice.rows; ++i, at += bytes)
            scan.values.push_back(
                static_cast<float>(line.slope * sampleAt(at, bytes, bits, lowest, isSigned) + line.intercept));
    }
    scan.type = fmt::format("{}int{}", isSigned ? "" : "u", 8 * bytes);
}

/// The samples of sorted slices, which are files or the frames of one file.
void addAll(const std::vector<Slice>& slices, const std::string& path, Scan& scan) {
    scan.values.reserve(static_cast<std::size_t>(sampleCount(scan.size, path)));
    if (slices.front().frames == 1) {
        for (const Slice& slice : slices) addSamples(slice, path, scan);
        return;
    }
    addSamples(slices.front(), path, scan);
    const bool sorted =
        std::is_sorted(slices.begin(), slices.end(), [](const Slice& a, const Slice& b) { return a.frame < b.frame; });
    if (sorted) return;
    const std::vector<float> asStored = std::move(scan.values);
    scan.values.clear();
    const auto plane = static_cast<std::ptrdiff_t>(scan.size[0] * scan.size[1]);
    for (const Slice& slice : slices) {
        const auto begin = asStored.begin() + plane * static_cast<std::ptrdiff_t>(slice.frame);
        scan.values.insert(scan.values.end(), begin, begin + plane);
    }
}

}  // namespace

Scan readDicom(const std::string& path) {
    gdcm::Trace::DebugOff();
    gdcm::Trace::WarningOff();
    gdcm::Trace::ErrorOff();
    std::error_code ignored;
    const std::filesystem::path own(path);
    const bool isOneFile = isDicomFile(path) && !std::filesystem::is_directory(own, ignored);
    if (isOneFile) fileBytes(path);
    const std::string folder = isOneFile ? (own.has_parent_path() ? own.parent_path().string() : ".") : path;
    const bool isBundled = !std::filesystem::is_directory(own, ignored) && isFolder(path);
    if (isOneFile && !isBundled && !beginsAsDicom(SliceFile{"", path}.contents(kStart))) refuse(path, kNoDicom);
    const std::vector<SliceFile> files = filesIn(isBundled ? path : folder);
    std::vector<Slice> slices = seriesOf(files, isOneFile ? own.filename().string() : "", path);
    checkStack(slices, path);
    if (slices.front().frames > 1) slices = framesOf(slices.front(), path);
    const glm::dvec3 axis = slices.front().normal();
    std::sort(slices.begin(), slices.end(),
              [&](const Slice& a, const Slice& b) { return a.along(axis) < b.along(axis); });

    const Slice& first = slices.front();
    Scan scan;
    scan.size = {first.columns, first.rows, static_cast<std::int64_t>(slices.size())};
    scan.axes = {first.right * first.spacing.x, first.down * first.spacing.y,
                 axis * (first.thickness > 0 ? first.thickness : 1)};
    scan.origin = first.position;
    scan.space = "left-posterior-superior";  // DICOM's patient coordinates, millimetres
    if (slices.size() == 1) {
        addAll(slices, path, scan);
        return scan;
    }
    const Steps steps = stepsOf(slices, path);
    scan.axes[2] = (slices.back().position - first.position) / double(slices.size() - 1);  // with a gantry's tilt
    addAll(slices, path, scan);
    if (steps.uneven) makeEven(scan, steps, path);
    return scan;
}

bool isDicomFile(const std::string& path) {
    const std::string name = lowerCase(path);
    return name.ends_with(".dcm") || name.ends_with(".dicom");
}

}  // namespace scan
