// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/scan_info.h>

#include <scrim/base/error.h>
#include <scrim/base/letter_case.h>
#include <scrim/volume/point_file.h>
#include <scrim/guard/load_fields.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include <fnmatch.h>

namespace scrim {
namespace {

// Prefix of the name of the grid whose bounds are those of the lattice.
constexpr std::string_view kSamples = "samples of ";

std::vector<double> countsOf(const SparseField& histogram) {
    std::vector<double> counts;
    for (std::size_t i = 0; i < histogram.blockCount(); ++i)
        for (int x = 0; x < kBlockEdge; ++x) {
            const double count = histogram.block(i)[blockOffset(x, 0, 0)];
            const auto bin = static_cast<std::size_t>(std::max(histogram.blockOrigins[i].x + x, 0));
            if (count <= 0) continue;
            if (bin >= counts.size()) counts.resize(bin + 1);
            counts[bin] = count;
        }
    return counts;
}

/// The two thresholds between three classes that maximise the variance between classes: the bins at which the second
/// and the third class begin, half-way where two classes are separated by empty bins.
std::array<std::size_t, 2> otsu(const std::vector<double>& counts) {
    const std::size_t n = counts.size();
    std::vector<double> weight(n + 1), moment(n + 1);
    for (std::size_t i = 0; i < n; ++i) {
        weight[i + 1] = weight[i] + counts[i];
        moment[i + 1] = moment[i] + counts[i] * double(i);
    }
    const auto spread = [&](std::size_t from, std::size_t to) {
        const double w = weight[to] - weight[from], m = moment[to] - moment[from];
        return w > 0 ? m * m / w : 0;
    };
    // Range of the best thresholds: all of them are equally good where bins are empty.
    std::array<std::size_t, 2> first{n / 3, 2 * n / 3}, last = first;
    double most = -1;
    for (std::size_t a = 1; a + 1 < n; ++a)
        for (std::size_t b = a + 1; b < n; ++b)
            if (const double s = spread(0, a) + spread(a, b) + spread(b, n); s >= most) {
                last = {a, b};
                if (s > most) first = last;
                most = s;
            }
    return {(first[0] + last[0]) / 2, (first[1] + last[1]) / 2};
}

/// The histogram in fewer bins, so that all pairs of thresholds can be tested.
std::vector<double> coarser(const std::vector<double>& counts, std::size_t bins) {
    if (counts.size() <= bins) return counts;
    std::vector<double> out(bins);
    for (std::size_t i = 0; i < counts.size(); ++i) out[i * bins / counts.size()] += counts[i];
    return out;
}

/// The bytes of a file, of all files in a folder, or of those whose names match a pattern.
std::uint64_t bytesOf(const std::string& path) {
    std::error_code error;
    std::uint64_t sum = 0;
    if (const auto bytes = std::filesystem::file_size(path, error); !error) return bytes;
    const std::filesystem::path own(path);
    const bool isFolder = std::filesystem::is_directory(own, error);
    const std::filesystem::path folder = isFolder ? own : own.has_parent_path() ? own.parent_path() : ".";
    const std::string pattern = isFolder ? "*" : own.filename().string();
    for (std::filesystem::directory_iterator at(folder, error), end; !error && at != end; at.increment(error))
        if (::fnmatch(pattern.c_str(), at->path().filename().c_str(), 0) != 0)
            continue;
        else if (const auto bytes = at->file_size(error); !error)
            sum += bytes;
        else
            error.clear();
    return sum;
}

}  // namespace

bool isScanFile(const std::string& path) {
    const std::string name = lowerCase(path);
    constexpr std::array kEndings{".nrrd", ".nhdr", ".nii",  ".nii.gz", ".hdr",   ".mha", ".mhd", ".npy",
                                  ".mrc",  ".vti",  ".ccp4", ".dcm",    ".dicom", ".tif", ".tiff"};
    std::error_code ignored;
    if (isPointFile(path)) return false;
    return std::any_of(kEndings.begin(), kEndings.end(), [&](const char* ending) { return name.ends_with(ending); }) ||
           (!name.ends_with(".vdb") && !name.ends_with(".nvdb") && std::filesystem::is_directory(path, ignored));
}

ScanInfo loadScanInfo(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint) {
    ScanInfo info;
    info.path = path;
    info.fileBytes = bytesOf(path);
    const std::vector<SparseField> fields =
        sourceFields("scan", {{"file", path}, {"describe", "true"}}, options, {}, checkpoint);
    if (fields.size() != 2 || fields[0].empty() || fields[1].empty() || !fields[1].name.starts_with(kSamples))
        throw Error(ErrorKind::input, fmt::format("{}: damaged: none of its samples is finite", path));
    const SparseField &histogram = fields[0], &ends = fields[1];
    info.counts = countsOf(histogram);
    info.binWidth = histogram.wsFromIs[0][0];
    info.minValue = histogram.wsFromIs[3][0];
    info.maxValue = info.valueOf(info.counts.size() - 1);
    info.sampleType = ends.name.substr(kSamples.size());
    if (const std::size_t comma = info.sampleType.find(", "); comma != std::string::npos) {
        info.space = info.sampleType.substr(comma + 2);
        info.sampleType.resize(comma);
    }
    if (const std::size_t in = info.sampleType.find(" in "); in != std::string::npos) {
        info.unit = info.sampleType.substr(in + 4);
        info.sampleType.resize(in);
        info.isSpaced = info.unit != "unknown steps";
        if (!info.isSpaced) info.unit.clear();
    }
    info.wsFromIs = ends.wsFromIs;
    // The grid has values only at both ends of the lattice; the last of them is at the lattice's end.
    for (std::size_t i = 0; i < ends.blockCount(); ++i)
        for (int x = 0; x < kBlockEdge; ++x)
            for (int y = 0; y < kBlockEdge; ++y)
                for (int z = 0; z < kBlockEdge; ++z)
                    if (ends.block(i)[blockOffset(x, y, z)] > 0)
                        info.size = glm::max(info.size, ends.blockOrigins[i] + Int3(x, y, z) + 1);
    return info;
}

ScanMaterials materialsOf(const ScanInfo& info) {
    constexpr double kAir = -500, kTissue = 50, kBone = 300;  // Hounsfield units
    constexpr std::size_t kBins = 512;
    if (info.minValue < kAir && info.maxValue > kBone) return {kTissue, kBone, true};
    const std::vector<double> counts = coarser(info.counts, kBins);
    const double width = double(info.counts.size()) / double(counts.size()) * info.binWidth;
    const auto [soft, solid] = otsu(counts);
    // Half a bin lower lies between the values of two classes.
    const auto between = [&](std::size_t bin) { return info.minValue + (double(bin) - 0.5) * width; };
    return {between(soft), between(solid), false};
}

std::string histogramText(const ScanInfo& info, int columns, int rows) {
    constexpr std::array<const char*, 9> kBars{" ", "▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
    std::vector<double> counts(static_cast<std::size_t>(columns));
    for (std::size_t i = 0; i < info.counts.size(); ++i)
        counts[i * counts.size() / std::max(info.counts.size(), counts.size())] += info.counts[i];
    if (info.counts.size() < counts.size())  // one bin for each column is enough
        for (std::size_t i = counts.size(); i-- > 0;) counts[i] = info.counts[i * info.counts.size() / counts.size()];
    const double most = std::log1p(*std::max_element(counts.begin(), counts.end()));
    std::string text;
    for (int row = rows - 1; row >= 0; --row) {
        for (const double count : counts) {
            const double eighths = 8 * (rows * std::log1p(count) / most - row);
            text += kBars[static_cast<std::size_t>(std::clamp(std::lround(eighths), 0L, 8L))];
        }
        if (row > 0) text += '\n';
    }
    return text;
}

std::string toJson(const ScanInfo& info) {
    using nlohmann::json;
    json matrix = json::array();
    for (int row = 0; row < 4; ++row)
        matrix.push_back({info.wsFromIs[0][row], info.wsFromIs[1][row], info.wsFromIs[2][row], info.wsFromIs[3][row]});
    const ScanMaterials materials = materialsOf(info);
    const json all = {{"path", info.path},
                      {"file_bytes", info.fileBytes},
                      {"sample_type", info.sampleType},
                      {"space", info.space},
                      {"unit", info.unit},
                      {"spaced", info.isSpaced},
                      {"size", {info.size.x, info.size.y, info.size.z}},
                      {"world_from_index", matrix},
                      {"min_value", info.minValue},
                      {"max_value", info.maxValue},
                      {"histogram", {{"first", info.minValue}, {"width", info.binWidth}, {"counts", info.counts}}},
                      {"soft", materials.soft},
                      {"solid", materials.solid},
                      {"hounsfield", materials.hounsfield}};
    return all.dump(-1, ' ', /*ensure_ascii=*/false, json::error_handler_t::replace);
}

}  // namespace scrim
