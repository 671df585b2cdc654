// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/field_store.h>

#include <scrim/base/error.h>
#include <scrim/shot/point_balls.h>
#include <scrim/shot/point_lists.h>
#include <scrim/shot/view_motion.h>
#include <scrim/volume/grid_choice.h>
#include <scrim/guard/load_fields.h>
#include <scrim/volume/vdb_bounds.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <set>
#include <utility>

namespace scrim {
namespace {

/// True if anything is computed from a volume's density, or if nothing at all is computed from the
/// volume: then the density is read all the same, so that it is checked.
bool usesDensity(const SceneVolume& volume) {
    return volume.densityScale != 0 || volume.classified || volume.emission.empty();
}

/// True if anything in the scene may move while the shutter is open.
bool isBlurred(const Scene& scene) {
    return scene.shutter && (scene.movesWithin || std::any_of(scene.volumes.begin(), scene.volumes.end(),
                                                              [](const auto& v) { return v.velocity.has_value(); }));
}

/// "s.toml:2:8: ", the start of a message. Volumes that were made in code have no place.
std::string placeText(const std::string& where) {
    return where.empty() ? "" : where + ": ";
}

/// The index into `fields` of the requested grid. `maker` is the name of the source or volume in messages.
std::size_t chooseGridOf(const std::vector<std::shared_ptr<const SparseField>>& fields, const GridRequest& request,
                         const std::string& where, const std::string& maker) {
    if (request.part != GridPart::whole)
        throw Error(ErrorKind::input, fmt::format("{}{} no velocities: only files do", placeText(where), maker));
    std::vector<GridOffer> offers;
    std::vector<std::string> names;
    for (const auto& field : fields) {
        offers.push_back({field->name});
        names.push_back(field->name);
    }
    if (const auto choice = chooseGrid(offers, request)) return choice->grid;
    const std::string parts =
        request.component == GridRequest::kScalar ? "" : fmt::format(" (nor '{0}.r', '{0}.g', '{0}.b')", request.grid);
    throw Error(ErrorKind::input, fmt::format("{}{} no grid '{}'{}; there is {}", placeText(where), maker, request.grid,
                                              parts, choices(names)));
}

/// What is done to the grids of the volume, with the files that were found; null: nothing.
std::shared_ptr<const GridEdit> editOf(const SceneVolume& volume, const VolumeFile& file) {
    if (!volume.edit || !volume.edit->changesGrids()) return nullptr;
    // Faces cut fields and points later. Leaving out voxels beforehand only saves time, and would take away the points.
    const bool keepsAll = volume.edit->clip && canSeeBalls(volume) && holdsPoints(file.path);
    if (volume.edit->files == file.all && !keepsAll) return volume.edit;
    GridEdit edit = *volume.edit;
    if (keepsAll) edit.clip.reset();
    edit.files = file.all;
    if (edit.files.empty()) edit.grids.clear();  // the volume's grids were set
    if (keepsAll && !edit.changesGrids()) return nullptr;
    return std::make_shared<const GridEdit>(std::move(edit));
}

/// True if grids of the volume are carried by their velocity from one file to another.
bool isCarried(const SceneVolume& volume, const VolumeFile& file) {
    return file.next && volume.frameMap.between == BetweenFiles::advect && volume.velocity;
}

/// How many of `files` may be read side by side within `memory` bytes (0: no limit), and how each of them is read.
std::pair<std::size_t, LoadOptions> readersWithin(std::size_t memory, std::size_t files, LoadOptions options) {
    if (memory == 0 || files == 0) return {files, std::move(options)};
    // A reader may take its limit twice: for what its library makes of the file, and for what it hands over.
    const std::size_t readers = std::min(files, memory / (2 * LoadOptions::kLeastMemory));
    if (readers == 0) return {0, std::move(options)};
    const std::size_t share = memory / (2 * readers);
    options.memory = options.memory == 0 ? share : std::min(options.memory, share);
    return {readers, std::move(options)};
}

/// Runs `task`. An error about the grid of one of `uses` gets the place where the scene names it.
template <typename Use, typename Task>
void withPlaces(const std::vector<Use>& uses, const Task& task) {
    try {
        task();
    } catch (const GridError& error) {
        for (const Use& use : uses)
            if (use.request == error.request() && !use.where.empty())
                throw Error(error.kind(), fmt::format("{}: {}", use.where, error.what()));
        throw;
    }
}

}  // namespace

void FieldStore::listen(LoadOptions options, MessageSink messages, Checkpoint checkpoint) {
    m_options = std::move(options);
    m_messages = std::move(messages);
    m_checkpoint = std::move(checkpoint);
}

void FieldStore::setGrids(const std::string& volume, std::vector<SparseField> grids) {
    Grids& own = m_grids[volume];
    own.clear();
    for (SparseField& grid : grids) own.push_back(std::make_shared<SparseField>(std::move(grid)));
    std::erase_if(m_fields, [&](const auto& entry) {
        const auto* const code = std::get_if<FromCode>(&entry.first.first);
        return code != nullptr && code->volume == volume;
    });
}

bool FieldStore::isFile(const SceneVolume& volume) const {
    return volume.source.empty() && !hasGrids(volume.name);
}

std::vector<VolumeFile> FieldStore::filesOf(const Scene& scene) const {
    std::vector<VolumeFile> files;
    for (const SceneVolume& volume : scene.volumes)
        files.push_back(isFile(volume) ? findVolumeFile(volume) : VolumeFile{});
    return files;
}

FieldStore::Origin FieldStore::originOf(const SceneVolume& volume, const VolumeFile& file) const {
    const auto own = editOf(volume, file);
    const std::string edit = own ? toText(*own) : "";
    if (hasGrids(volume.name)) return FromCode{volume.name, edit};
    if (volume.source.empty()) return FromFile{file.path, edit};
    return FromSource{volume.source, volume.parameters, edit};
}

std::vector<FieldStore::Use> FieldStore::usesOf(const SceneVolume& volume, const VolumeFile& file, bool blurred) {
    std::vector<Use> uses;
    const std::shared_ptr<const GridEdit> edit = editOf(volume, file);
    const auto add = [&](const GridRequest& request, const std::string& where) {
        Use& use = uses.emplace_back();
        use.volume = &volume;
        use.edit = edit;
        use.request = request;
        use.where = where;
    };
    if (usesDensity(volume)) {
        add({volume.densityGrid}, volume.densityWhere);
        for (int c = 0; volume.albedoGrid && c < 3; ++c) add(albedoRequest(volume, c), volume.albedoGrid->where);
    }
    if (usesDensity(volume) && volume.shading.mask) add({volume.shading.mask->grid}, volume.shading.mask->where);
    for (const Emission& emission : volume.emission) {
        add({emission.grid}, emission.where);
        if (emission.mask) add({emission.mask->grid}, emission.mask->where);
    }
    for (int axis = 0; blurred && volume.velocity && axis < 3; ++axis)
        for (const GridRequest& request : velocityRequests(*volume.velocity, axis))
            add(request, volume.velocity->where);
    return uses;
}

/// True if the points of a volume's file may be seen by themselves, as far as the file's header tells. A tolerance is
/// checked by brute force, which marches through voxels: then only a volume that asks for it is.
bool FieldStore::listsPoints(const Scene& scene, const SceneVolume& volume, const VolumeFile& file) const {
    const bool asks = volume.edit && volume.edit->points.sharp;
    return isFile(volume) && !file.next && scene.dials.splat == SplatMode::shared && (asks || scene.tolerance == 0) &&
           canSeeBalls(volume) && holdsPoints(file.path);
}

/// The fields that were read ahead, if they are exactly these and no error occurred. An error is
/// not reported here: the file is read again at its regular time, and reports it then.
std::optional<std::vector<SparseField>> FieldStore::readBefore(const std::string& path,
                                                               const std::vector<GridRequest>& requests,
                                                               const GridEdit* edit) {
    const std::optional<GridEdit> edited = edit == nullptr ? std::nullopt : std::optional(*edit);
    const auto found = std::find_if(m_ahead.begin(), m_ahead.end(), [&](const GuardedFields& fields) {
        return fields.path() == path && fields.requests() == requests && fields.edit() == edited && fields.isCurrent();
    });
    if (found == m_ahead.end()) return {};
    GuardedFields ahead = std::move(*found);
    m_ahead.erase(found);
    bool stopped = false;
    const auto checkpoint = [&] {
        stopped = true;
        if (m_checkpoint) m_checkpoint();
        stopped = false;
    };
    try {
        return ahead.take(m_messages, checkpoint);
    } catch (const Error&) {
        if (stopped) throw;
        return {};
    }
}

std::vector<SparseField> FieldStore::fieldsOf(const std::string& path, const std::vector<GridRequest>& requests,
                                              const GridEdit* edit) {
    if (auto fields = readBefore(path, requests, edit)) return std::move(*fields);
    return loadFields(path, requests, m_options, m_messages, m_checkpoint, edit);
}

void FieldStore::load(const FromFile& file, const std::vector<Use>& missing) {
    std::vector<GridRequest> requests;
    for (const Use& use : missing) requests.push_back(use.request);
    withPlaces(missing, [&] {
        std::vector<SparseField> fields = fieldsOf(file.path, requests, missing.front().edit.get());
        for (std::size_t i = 0; i < requests.size(); ++i)
            m_fields[{file, requests[i]}] = std::make_shared<SparseField>(std::move(fields[i]));
    });
}

/// Edits the grids of a source, or those that were set.
void FieldStore::makeEdited(const Origin& origin, const std::vector<Use>& missing, const Grids& grids) {
    std::vector<SparseField> fields;
    for (const auto& grid : grids) fields.push_back(*grid);  // copies share their voxels
    std::vector<GridRequest> requests;
    for (const Use& use : missing) requests.push_back(use.request);
    const auto* const code = std::get_if<FromCode>(&origin);
    const std::string name = code != nullptr ? fmt::format("volume '{}'", code->volume)
                                             : fmt::format("source '{}'", std::get<FromSource>(origin).source);
    withPlaces(missing, [&] {
        std::vector<SparseField> edited =
            editedFields(fields, name, requests, *missing.front().edit, m_options, m_messages, m_checkpoint);
        for (std::size_t i = 0; i < requests.size(); ++i)
            m_fields[{origin, requests[i]}] = std::make_shared<SparseField>(std::move(edited[i]));
    });
}

FieldStore::Grids FieldStore::generated(const SceneVolume& volume) const {
    Grids grids;
    try {
        for (SparseField& field : sourceFields(volume.source, volume.parameters, m_options, m_messages, m_checkpoint))
            grids.push_back(std::make_shared<SparseField>(std::move(field)));
    } catch (const Error& error) {
        if (error.kind() == ErrorKind::interrupted) throw;
        throw Error(error.kind(), placeText(volume.where) + error.what());
    }
    return grids;
}

void FieldStore::make(const Origin& origin, const std::vector<Use>& missing) {
    const SceneVolume& volume = *missing.front().volume;
    const bool wasSet = std::holds_alternative<FromCode>(origin);
    const Grids grids = wasSet ? m_grids.at(volume.name) : generated(volume);
    const std::string maker =
        wasSet ? fmt::format("volume '{}' has", volume.name) : fmt::format("source '{}' makes", volume.source);
    if (missing.front().edit) return makeEdited(origin, missing, grids);
    for (const Use& use : missing) {
        const std::string& where = use.where.empty() ? use.volume->where : use.where;
        m_fields[{origin, use.request}] = grids[chooseGridOf(grids, use.request, where, maker)];
    }
}

/// For each volume why the picture has no use for it, as far as the headers of files tell its place.
std::vector<std::string> FieldStore::culledOf(const Scene& scene, const std::vector<VolumeFile>& files) const {
    std::vector<std::optional<std::vector<Vec3>>> corners(scene.volumes.size());
    // Moving volumes are culled moment by moment instead.
    if (isBlurred(scene) || scene.lens) return std::vector<std::string>(scene.volumes.size());
    for (std::size_t i = 0; i < scene.volumes.size(); ++i) {
        const SceneVolume& volume = scene.volumes[i];
        // Each of these may change bounds.
        if (!isFile(volume) || volume.edit || volume.displacement || files[i].next) continue;
        if (files[i].state != FileState::present) {
            corners[i].emplace();
            continue;
        }
        std::vector<GridRequest> requests;
        for (const Use& use : usesOf(volume, files[i], false)) requests.push_back(use.request);
        const std::optional<Bounds> bounds = vdbBounds(files[i].path, requests);
        if (!bounds || bounds->empty()) continue;  // empty fields are reported after they have been read
        corners[i].emplace();
        for (const Vec3& corner : bounds->corners()) corners[i]->push_back(transformPoint(volume.wsFromAsset, corner));
    }
    return culledVolumes(scene, corners);
}

std::vector<bool> FieldStore::shownOf(const Scene& scene, const std::vector<VolumeFile>& files,
                                      const std::vector<std::string>& culled, VolumesOf volumesOf) const {
    std::vector<bool> shown;
    for (std::size_t i = 0; i < scene.volumes.size(); ++i)
        shown.push_back((culled[i].empty() || volumesOf == VolumesOf::scene) &&
                        (!isFile(scene.volumes[i]) || files[i].state == FileState::present));
    return shown;
}

FieldStore::Uses FieldStore::usesOf(const Scene& scene, const std::vector<VolumeFile>& files,
                                    const std::vector<bool>& shown) const {
    Uses uses;
    std::set<Key> used;
    const bool blurred = isBlurred(scene) || wantsMotion(scene);
    for (std::size_t i = 0; i < scene.volumes.size(); ++i) {
        if (!shown[i]) continue;
        const SceneVolume& volume = scene.volumes[i];
        for (const VolumeFile* file = &files[i]; file != nullptr; file = file->next.get()) {
            const Origin origin = originOf(volume, *file);
            std::vector<Use> all = usesOf(volume, *file, blurred || isCarried(volume, files[i]));
            if (listsPoints(scene, volume, files[i]))
                for (GridRequest& request : pointRequests(volume, blurred))
                    all.push_back({&volume, editOf(volume, *file), std::move(request), ""});
            for (Use& use : all)
                if (used.insert({origin, use.request}).second) uses[origin].push_back(std::move(use));
        }
    }
    return uses;
}

void FieldStore::dropKnown(Uses& uses) const {
    for (auto& [origin, missing] : uses)
        std::erase_if(missing, [&](const Use& use) { return m_fields.contains({origin, use.request}); });
    std::erase_if(uses, [](const auto& entry) { return entry.second.empty(); });
}

void FieldStore::readAhead(const Scene& scene, const std::vector<VolumeFile>& files, VolumesOf volumesOf,
                           std::size_t memory) {
    if (m_options.volumes != VolumeLoading::guarded) return;
    Uses uses = usesOf(scene, files, shownOf(scene, files, culledOf(scene, files), volumesOf));
    dropKnown(uses);
    m_ahead.clear();
    std::erase_if(uses, [](const auto& entry) { return !std::holds_alternative<FromFile>(entry.first); });
    const auto [readers, each] = readersWithin(memory, uses.size(), m_options);
    for (const auto& [origin, missing] : uses)
        if (m_ahead.size() < readers) begin(std::get<FromFile>(origin), missing, each);
}

/// Starts a child that reads a file.
void FieldStore::begin(const FromFile& file, const std::vector<Use>& missing, const LoadOptions& options) {
    std::vector<GridRequest> requests;
    for (const Use& use : missing) requests.push_back(use.request);
    m_ahead.emplace_back(file.path, requests, options, missing.front().edit.get());
}

/// Loads the files of a frame, several of them side by side: small ones keep few threads busy.
void FieldStore::loadFiles(const Uses& uses) {
    constexpr std::size_t kMostReaders = 8;  // each has all threads, and is waited for in turn
    std::vector<std::pair<const FromFile*, const std::vector<Use>*>> files;
    for (const auto& [origin, missing] : uses)
        if (const auto* const file = std::get_if<FromFile>(&origin)) files.emplace_back(file, &missing);
    const auto [readers, each] = readersWithin(m_options.memory, std::min(files.size(), kMostReaders), m_options);
    const bool together = m_options.volumes == VolumeLoading::guarded && readers > 1;
    const auto isRead = [&](const std::string& path) {
        return std::any_of(m_ahead.begin(), m_ahead.end(), [&](const auto& fields) { return fields.path() == path; });
    };
    for (std::size_t i = 0, begun = 0; i < files.size(); ++i) {
        for (; together && begun < std::min(files.size(), i + readers); ++begun) try {
                const auto& [file, missing] = files[begun];
                if (!isRead(file->path)) begin(*file, *missing, each);
            } catch (const Error&) {
                // It occurs again, and is reported, when it is this file's turn.
            }
        load(*files[i].first, *files[i].second);
    }
}

std::size_t FieldStore::memoryAhead() const {
    return std::accumulate(m_ahead.begin(), m_ahead.end(), std::size_t{0},
                           [](std::size_t sum, const GuardedFields& fields) { return sum + 2 * fields.memory(); });
}

class FieldStore::GridsOf {
  public:
    GridsOf(FieldStore& store, const SceneVolume& volume, const VolumeFile& file, double fps)
        : m_store(store), m_volume(volume), m_origin(store.originOf(volume, file)) {
        if (!file.next) return;
        m_next = store.originOf(volume, *file.next);
        BetweenMoment moment;
        moment.part = file.beyond;
        if (isCarried(volume, file)) {
            moment.time = volume.velocity->perFrame(fps);
            for (int axis = 0; axis < 3; ++axis)
                for (const GridRequest& request : velocityRequests(*volume.velocity, axis)) {
                    moment.velocity[0].push_back(loaded(m_origin, request));
                    moment.velocity[1].push_back(loaded(m_next, request));
                }
        }
        m_between.emplace(std::move(moment));
    }

    FieldPointer at(const GridRequest& request) {
        const FieldPointer first = loaded(m_origin, request);
        return m_between ? m_store.m_between.at(*m_between, first, loaded(m_next, request)) : first;
    }
    FieldPointer displacedAt(const GridRequest& request) { return m_store.m_shader.displaced(m_volume, at(request)); }
    /// The fields that were loaded, where others are made from them.
    std::vector<FieldPointer> sources() const {
        return m_between ? std::vector<FieldPointer>(m_loaded.begin(), m_loaded.end()) : std::vector<FieldPointer>();
    }

  private:
    const FieldPointer& loaded(const Origin& origin, const GridRequest& request) {
        return *m_loaded.insert(m_store.m_fields.at({origin, request})).first;
    }

    FieldStore& m_store;
    const SceneVolume& m_volume;
    Origin m_origin, m_next;
    std::set<FieldPointer> m_loaded;
    std::optional<BetweenFields> m_between;
};

/// Adds the density with its detail, and the albedo.
void FieldStore::addDensity(const Scene& scene, const SceneVolume& volume, GridsOf& grids, VolumeFields& fields) {
    const auto& mask = volume.shading.mask;
    const FieldPointer grid = grids.at({volume.densityGrid}), displaced = m_shader.displaced(volume, grid);
    const FieldPointer masks = mask ? grids.displacedAt({mask->grid}) : nullptr;
    fields.density = m_shader.density(volume, displaced, masks);
    if (auto detail = detailOf(scene, volume, grid)) {
        detail->displaced = displaced;
        detail->shaded = fields.density;
        detail->mask = masks;
        const DetailedDensity made = m_detail.of(std::move(*detail));
        fields.density = made.coarse;
        fields.finer = made.finer;
    }
    for (int c = 0; volume.albedoGrid && c < 3; ++c) fields.albedo[c] = grids.displacedAt(albedoRequest(volume, c));
}

VolumeFields FieldStore::fieldsOf(const Scene& scene, const SceneVolume& volume, const VolumeFile& file, bool blurred) {
    VolumeFields fields;
    GridsOf grids(*this, volume, file, scene.output.fps);
    if (usesDensity(volume)) addDensity(scene, volume, grids, fields);
    for (const Emission& emission : volume.emission) {
        fields.emission.push_back(grids.displacedAt({emission.grid}));
        fields.emissionMasks.push_back(emission.mask ? grids.displacedAt({emission.mask->grid}) : nullptr);
    }
    for (int axis = 0; blurred && volume.velocity && axis < 3; ++axis)
        for (const GridRequest& request : velocityRequests(*volume.velocity, axis))
            fields.velocity.push_back(grids.at(request));
    fields.sources = grids.sources();
    if (!listsPoints(scene, volume, file)) return fields;
    const Origin origin = originOf(volume, file);
    fields.points = pointFields(volume, blurred, m_shader, [&](const GridRequest& request) {
        return m_fields.at({origin, request});
    });
    return fields;
}

/// Throws where files on both sides of a moment, which are in memory at once, take more than the memory limit.
void FieldStore::checkRoom(const Scene& scene, const std::vector<VolumeFile>& files) const {
    std::size_t bytes = 0;
    for (const auto& [key, field] : m_fields) bytes += field->bytes();
    const auto between = [](const VolumeFile& file) { return file.next != nullptr; };
    if (m_options.memory == 0 || bytes <= m_options.memory || std::none_of(files.begin(), files.end(), between)) return;
    throw Error(
        ErrorKind::memory,
        fmt::format("the files on both sides of frame {:g} take {}, more than the memory limit of {} (--memory)",
                    scene.frame, bytesText(bytes), bytesText(m_options.memory)));
}

/// The files on both sides of a moment stay for the next frame, which mostly lies between them, too. Where all of that
/// takes more than half of the memory limit, they are read once more instead.
void FieldStore::dropSources(Fields& all) {
    if (m_options.memory == 0 || 2 * bytesOf(all) <= m_options.memory) return;
    std::set<FieldPointer> dropped;
    for (VolumeFields& fields : all) {
        dropped.insert(fields.sources.begin(), fields.sources.end());
        fields.sources.clear();
    }
    std::erase_if(m_fields, [&](const auto& entry) { return dropped.contains(entry.second); });
    m_between.keepOnly(loadedFields());
}

std::set<FieldPointer> FieldStore::loadedFields() const {
    std::set<FieldPointer> all;
    for (const auto& [key, field] : m_fields) all.insert(field);
    return all;
}

Fields FieldStore::fieldsOf(const Scene& scene, const std::vector<VolumeFile>& files, VolumesOf volumesOf) {
    const std::vector<std::string> culled = culledOf(scene, files);
    const std::vector<bool> shown = shownOf(scene, files, culled, volumesOf);
    Uses uses = usesOf(scene, files, shown);
    // Fields are released before new ones are loaded, since the fields of two frames together may exceed memory.
    std::set<Key> used;
    for (const auto& [origin, all] : uses)
        for (const Use& use : all) used.insert({origin, use.request});
    std::erase_if(m_fields, [&](const auto& entry) { return !used.contains(entry.first); });
    m_between.keepOnly(loadedFields());
    dropKnown(uses);
    loadFiles(uses);
    for (const auto& [origin, missing] : uses)
        if (!std::holds_alternative<FromFile>(origin)) make(origin, missing);
    m_ahead.clear();
    checkRoom(scene, files);

    Fields all;
    const bool blurred = isBlurred(scene) || wantsMotion(scene);
    for (std::size_t i = 0; i < scene.volumes.size(); ++i) {
        const SceneVolume& volume = scene.volumes[i];
        VolumeFields& fields = all.emplace_back();
        if (shown[i]) fields = fieldsOf(scene, volume, files[i], blurred);
        fields.emission.resize(volume.emission.size());
        if (isFile(volume) && files[i].state == FileState::present) fields.culled = culled[i];
    }
    m_shader.forgetUnused();
    m_detail.forgetUnused();
    m_between.forgetUnused();
    dropSources(all);
    return all;
}

std::shared_ptr<const SparseField> FieldStore::fieldOf(const std::string& path, const GridRequest& request) {
    const FromFile file{path, ""};
    if (!m_fields.contains({file, request})) load(file, {{nullptr, nullptr, request, ""}});
    return m_fields.at({file, request});
}

std::shared_ptr<const SparseField> FieldStore::sourceField(const std::string& source,
                                                           const SourceParameters& parameters) {
    SceneVolume volume;
    volume.source = source;
    volume.parameters = parameters;
    const Origin origin = originOf(volume, {});
    if (!m_fields.contains({origin, {}})) make(origin, std::vector<Use>(1, Use{&volume, nullptr, GridRequest{}, ""}));
    return m_fields.at({origin, {}});
}

ScanInfo FieldStore::scanInfo(const std::string& path) const {
    return loadScanInfo(path, m_options, m_checkpoint);
}

std::size_t bytesOf(const Fields& fields) {
    std::size_t bytes = 0;
    std::set<std::shared_ptr<const SparseField>> all;
    for (const VolumeFields& of : fields) {
        all.insert(of.density);
        all.insert(of.finer);
        all.insert(of.albedo.begin(), of.albedo.end());
        all.insert(of.emission.begin(), of.emission.end());
        all.insert(of.emissionMasks.begin(), of.emissionMasks.end());
        all.insert(of.velocity.begin(), of.velocity.end());
        all.insert(of.sources.begin(), of.sources.end());
        if (!of.points) continue;
        for (const FieldPointer& list : of.points->all()) all.insert(list);
    }
    for (const auto& field : all)
        if (field) bytes += field->bytes();
    return bytes;
}

}  // namespace scrim
