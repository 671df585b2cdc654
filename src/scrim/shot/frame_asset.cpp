// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/frame_asset.h>

#include <scrim/base/error.h>
#include <scrim/base/letter_case.h>
#include <scrim/scene/field_rays.h>
#include <scrim/scene/framing.h>
#include <scrim/shot/framed_scan.h>
#include <scrim/volume/grid_choice.h>
#include <scrim/volume/point_file.h>
#include <scrim/shot/scan_info.h>
#include <scrim/volume/vdb_bytes.h>
#include <scrim/volume/vdb_layout.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <vector>

namespace scrim {
namespace {

using FieldPtr = std::shared_ptr<const SparseField>;

std::vector<std::string> allFiles(const FramePath& path, const std::string& name) {
    if (!path.hasFrame()) return {path.at(0)};
    std::vector<std::string> files;
    for (const int frame : existingFrames(path)) files.push_back(path.at(frame));
    if (files.empty()) throw Error(ErrorKind::input, fmt::format("{}: the sequence has no files", name));
    return files;
}

/// The first, middle and last file of a sequence. They show how far it reaches and do not depend on
/// the frames that a task of a farm renders.
std::vector<std::string> filesToFrame(const std::vector<std::string>& all) {
    std::vector<std::string> files;
    for (const std::string& file : {all.front(), all[all.size() / 2], all.back()})
        if (files.empty() || files.back() != file) files.push_back(file);
    return files;
}

double sizeOf(const SparseField& field) {
    if (field.empty()) return 0;
    const Vec3 size = transformed(field.wsFromIs, field.isBounds()).size();
    return size.x * size.x + size.y * size.y + size.z * size.z;
}

/// What a file's header says without reading the grids; empty where the file is of an old version
/// or was written to a pipe.
VdbLayout headOf(const std::string& file) {
    try {
        return checkVdbLayout(VdbBytes(file));
    } catch (const Error&) {
        return {};
    }
}

/// The scalar grid that glows, if one has a usual name for it.
std::optional<std::size_t> fireAmong(const std::vector<GridOffer>& offers) {
    constexpr std::array kNames{"temperature", "heat", "flame", "flames", "fire", "burn"};
    for (const char* const name : kNames)
        for (std::size_t i = 0; i < offers.size(); ++i)
            if (offers[i].isScalar() && lowerCase(offers[i].name) == name) return i;
    return {};
}

bool has(const VdbLayout& layout, const std::string& name) {
    return std::any_of(layout.grids.begin(), layout.grids.end(), [&](const auto& grid) { return grid.name == name; });
}

/// The grids of the file that are shown, and those that are not.
struct GridUse {
    std::optional<std::size_t> density;
    std::string fire, albedo;         ///< "": none
    std::vector<std::string> unused;  ///< names, without repetitions
};

GridUse gridUse(const std::vector<GridOffer>& offers, const std::vector<std::string>& files) {
    // A grid that is missing in some files would stop a sequence, so only grids of all files are used.
    std::vector<VdbLayout> heads;
    const auto everywhere = [&](const std::string& name) {
        if (heads.empty()) std::transform(files.begin(), files.end(), std::back_inserter(heads), headOf);
        return std::all_of(heads.begin(), heads.end(), [&](const VdbLayout& head) { return has(head, name); });
    };
    GridUse use;
    if (const auto choice = chooseGrid(offers, {})) use.density = choice->grid;
    if (const auto fire = fireAmong(offers); fire && everywhere(offers[*fire].name)) use.fire = offers[*fire].name;
    for (const GridOffer& offer : offers)
        if (offer.isVector() && offer.name == "Cd" && everywhere(offer.name)) use.albedo = offer.name;
    for (std::size_t i = 0; i < offers.size(); ++i) {
        const std::string& name = offers[i].name;
        const bool used = i == use.density || (!name.empty() && (name == use.fire || name == use.albedo));
        if (!used && std::find(use.unused.begin(), use.unused.end(), name) == use.unused.end())
            use.unused.push_back(name.empty() ? "a grid without a name" : name);
    }
    return use;
}

/// The density of the largest of the files, and that file's path.
std::pair<FieldPtr, std::string> largestOf(FieldStore& store, const std::vector<std::string>& files) {
    std::pair<FieldPtr, std::string> largest;
    for (const std::string& file : files) {
        const FieldPtr field = store.fieldOf(file, {});
        if (!largest.first || sizeOf(*field) > sizeOf(*largest.first)) largest = {field, file};
    }
    return largest;
}

/// The fire's field in the file where it is hottest; `field` keeps it alive.
std::optional<FramedFire> fireOf(FieldStore& store, const std::vector<std::string>& files, const std::string& grid,
                                 FieldPtr& field) {
    for (const std::string& file : files) {
        const FieldPtr one = store.fieldOf(file, {grid});
        if (!one->empty() && (!field || one->maxValue > field->maxValue)) field = one;
    }
    if (!field) return {};
    return FramedFire{grid, field.get(), field->maxValue};
}

/// True for caches of Blender's fluids (Mantaflow), which do not name their creator, by the grids
/// that all of them have.
bool isFluidCache(const VdbLayout& head) {
    return has(head, "density") && has(head, "shadow") && has(head, "velocity");
}

void sayUp(const std::string& path, const std::string& why, const std::string& up, const char* other,
           const MessageSink& messages) {
    notify(messages, Severity::info,
           fmt::format("{}: {} is taken as the up axis{}; --up {} changes this", shortened(path), up, why, other));
}

/// "-x" and so on, for a unit vector along an axis.
std::string nameOfAxis(const Vec3& ws) {
    const int axis = ws.x != 0 ? 0 : ws.y != 0 ? 1 : 2;
    return fmt::format("{}{}", ws[axis] < 0 ? "-" : "", "xyz"[axis]);
}

/// True if the files have flames, but none in any of them: their temperatures then are those of warm smoke.
bool isBurntOut(FieldStore& store, const std::vector<std::string>& files) {
    return std::all_of(files.begin(), files.end(), [&](const std::string& file) {
        return has(headOf(file), "flame") && store.fieldOf(file, {"flame"})->empty();
    });
}

/// The centre of mass of a field.
Vec3 wsCentre(const SparseField& field) {
    Vec3 is(0);
    double sum = 0;
    const auto add = [&](double value, const Vec3& at) {
        is += value * at;
        sum += value;
    };
    for (std::size_t i = 0; i < field.blockCount(); ++i) {
        double block = 0;
        for (int k = 0; k < kBlockVoxels; ++k) block += field.block(i)[k];
        add(block, Vec3(field.blockOrigins[i]) + 0.5 * (kBlockEdge - 1));
    }
    for (const ConstantTile& tile : field.tiles)
        add(double(tile.value) * std::pow(double(tile.edge), 3), Vec3(tile.origin) + 0.5 * (tile.edge - 1));
    return transformPoint(field.wsFromIs, sum > 0 ? is / sum : is);
}

/// True if smoke rises from its fire along z rather than along y.
bool rises(const SparseField& smoke, const SparseField& fire) {
    constexpr double kPart = 0.03;  // fraction of the size below which a rise may be chance
    const Vec3 rise = wsCentre(smoke) - wsCentre(fire);
    return rise.z > kPart * std::sqrt(sizeOf(smoke)) && rise.z > 2 * std::abs(rise.y);
}

/// Simulations leave tiny values where there is no smoke. Beside smoke they are set aside. Alone
/// they are still shown, since only the artist knows; so are huge values.
void sayResidue(const std::string& path, const SparseField& density, const MessageSink& messages) {
    constexpr float kLittle = 1e-6f, kMuch = 1e6f;  // caches hold smoke of 0.01 to 100, also in kg / m^3
    constexpr double kWorthSaying = 0.1;            // fraction of the voxels
    if (density.empty()) return;
    const std::string grid = fmt::format("{}: grid '{}'", shortened(path), shortened(density.name, 80));
    if (density.maxValue < kLittle)
        notify(messages, Severity::warning,
               fmt::format("{} has no value above {:.2g}, which may be only the residue of a simulation; density.scale "
                           "was chosen to make it visible",
                           grid, density.maxValue));
    if (density.maxValue > kMuch)
        notify(messages, Severity::warning,
               fmt::format("{} has values up to {:.2g}, which is more than densities usually have; density.scale was "
                           "chosen so that light passes through them",
                           grid, density.maxValue));
    if (const Negligible negligible = negligibleIn(density); negligible.part > kWorthSaying)
        notify(messages, Severity::info,
               fmt::format("{} has {:.0f} % of its voxels below {:.2g}, which show nothing beside the others; the "
                           "camera and density.scale were chosen without them",
                           grid, 100 * negligible.part, negligible.below));
}

std::string framedVolume(FieldStore& store, const std::string& path, const std::string& pattern,
                         const AssetOptions& options, const MessageSink& messages) {
    const std::vector<std::string> all = allFiles({"", pattern}, path), files = filesToFrame(all);
    const auto [field, file] = largestOf(store, files);
    const VdbLayout head = headOf(file);
    const GridUse use = gridUse(offersOf(head), all);
    if (!use.unused.empty())
        notify(messages, Severity::info,
               shortened(fmt::format("{} also holds {} (not used)", shortened(path), fmt::join(use.unused, ", "))));

    FramedAsset asset;
    asset.file = pattern;
    asset.name = volumeNameOf(pattern);
    asset.field = field.get();
    asset.albedoGrid = use.albedo;
    sayResidue(path, *field, messages);
    FieldPtr fire;
    if (!use.fire.empty() && isBurntOut(store, files))
        notify(messages, Severity::info,
               fmt::format("{}: nothing burns, since its grid 'flame' is empty; grid '{}' is not used", shortened(path),
                           shortened(use.fire, 80)));
    else if (!use.fire.empty())
        asset.fire = fireOf(store, files, use.fire, fire);
    Vec3 wsUp(0, 1, 0);
    if (options.wsUp) {
        wsUp = *options.wsUp;
    } else if (head.creator.find("Blender") != std::string::npos || isFluidCache(head)) {
        wsUp = {0, 0, 1};
        sayUp(path, ", as in Blender, which wrote it", "z", "y", messages);
    } else if (asset.fire && rises(*field, *fire)) {
        wsUp = {0, 0, 1};
        sayUp(path, ", where its smoke goes from its fire", "z", "y", messages);
    } else {
        sayUp(path, "", "y", "z", messages);
    }
    asset.wsFromUpright = wsFromUpright(wsUp);
    return framingScene(asset, options.resolution);
}

std::string framedScan(FieldStore& store, const std::string& path, const std::string& pattern,
                       const AssetOptions& options, const MessageSink& messages) {
    const std::vector<std::string> files = allFiles({"", pattern}, path);
    const std::string file = files[files.size() / 2];
    const ScanInfo info = store.scanInfo(file);
    const ScanLook look = scanLook(info, options.window);
    SourceParameters parameters = look.parameters;
    parameters.insert(parameters.begin(), {"file", file});
    const FieldPtr field = store.sourceField("scan", parameters);
    FramedAsset asset;
    asset.file = pattern;
    asset.name = volumeNameOf(pattern);
    asset.field = field.get();
    asset.volumeText = scanVolumeText(asset.name, pattern, look);
    const Upright up =
        options.wsUp ? Upright{wsFromUpright(*options.wsUp), UpFrom::file} : uprightOf(info, *field, look.solid);
    asset.wsFromUpright = up.wsFromUpright;
    if (up.from == UpFrom::slices) sayUp(path, "", "z", "y", messages);
    if (up.from == UpFrom::weight)
        sayUp(path, ", away from its heavy end", nameOfAxis(up.wsFromUpright[1]), "z", messages);
    return framingScene(asset, options.resolution);
}

}  // namespace

bool isAssetFile(const std::string& path) {
    const std::string name = lowerCase(path);
    return name.ends_with(".vdb") || name.ends_with(".nvdb") || isPointFile(path) || isScanFile(path);
}

std::string volumeNameOf(const std::string& pattern) {
    std::filesystem::path path(pattern);
    path = (path.has_filename() ? path : path.parent_path()).filename();
    if (lowerCase(path.string()).ends_with(".nii.gz")) path = path.stem();
    std::string name = withoutFrame(path.stem().string());
    for (char& c : name)
        if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '-') c = '_';
    name.erase(name.find_last_not_of("_-") + 1);
    return name.empty() ? "volume" : name;
}

std::string unframedText(const std::string& pattern, const AssetOptions& options) {
    const SparseField nothing;
    FramedAsset asset;
    asset.file = pattern;
    asset.name = volumeNameOf(pattern);
    asset.field = &nothing;
    if (!isScanFile(pattern)) {
        // Overrides may already refer to the names in the text, before its numbers are known.
        const FramePath path{"", pattern};
        const std::vector<int> frames = existingFrames(path);
        const std::string file = path.at(frames.empty() ? 0 : frames[frames.size() / 2]);
        const GridUse use = gridUse(offersOf(headOf(file)), {file});
        asset.albedoGrid = use.albedo;
        if (!use.fire.empty()) asset.fire = FramedFire{use.fire, &nothing, 1};
    } else {
        ScanInfo info;
        info.counts = {1, 1, 1};
        info.maxValue = 2;
        asset.volumeText = scanVolumeText(asset.name, pattern, scanLook(info));
    }
    return framingScene(asset, options.resolution);
}

std::string framedText(FieldStore& store, const std::string& path, const std::string& pattern,
                       const AssetOptions& options, const MessageSink& messages) {
    return isScanFile(pattern) ? framedScan(store, path, pattern, options, messages)
                               : framedVolume(store, path, pattern, options, messages);
}

}  // namespace scrim
