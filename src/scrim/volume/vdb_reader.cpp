// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/vdb_module.h>

#include <scrim/base/error.h>
#include <scrim/volume/direct_fields.h>
#include <scrim/volume/grid_choice.h>
#include <scrim/volume/grid_combiner.h>
#include <scrim/volume/grid_editor.h>
#include <scrim/volume/nano_grid.h>
#include <scrim/volume/openvdb_field.h>
#include <scrim/volume/point_file.h>
#include <scrim/volume/point_grid.h>
#include <scrim/volume/point_set.h>
#include <scrim/volume/vdb_layout.h>
#include <scrim/volume/vdb_part.h>

#include <algorithm>
#include <istream>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <sstream>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <openvdb/io/Stream.h>

namespace scrim {

namespace {

/// A parsed file.
struct ParsedVdb : VdbFile::Content {
    std::string path;
    VdbLayout layout;
    std::uint64_t bytes = 0;
    std::vector<std::pair<std::string, std::string>> metadata;
    std::vector<GridOffer> offers;  ///< all grids of the file
    openvdb::GridPtrVec grids;      ///< one for each of `offers`; null where it was not read
    /// One for each of `offers`, why it was not read; or empty if there were no problems.
    std::vector<std::string> problems;
    std::map<GridRequest, SparseField> direct;  ///< fields that were read without a grid
    BlockMemory* memory = nullptr;              ///< for the values of fields; null: memory of this process
    PointLook look;                             ///< of points
    PointSet::Notes notes;                      ///< about points
    std::string attributes;                     ///< "; points 'spray' have v (vec3s), ...", for errors
    std::optional<PointCloud> unused;           ///< of a file of points, where it is to be described
    /// Where grids are put together: the names of all that there may be, and "; a.vdb holds 'smoke' (float)".
    std::vector<std::string> combined;
    std::string sources;

    VdbFileInfo info() const override;
    GridInfo infoOfPoints(const openvdb::GridBase* grid) const;
    std::vector<std::string> usableGrids() const override;
    SparseField field(const GridRequest& request, const MessageSink& messages) const override;
    SparseField lastField(const GridRequest& request, const MessageSink& messages) override;
    std::string asFile() const override;
    void edit(const GridEditor& editor, const MessageSink& messages);
};

constexpr std::size_t kMessageLimit = 1000;  ///< bytes of an error that lists grids
/// A node of OpenVDB's trees takes some 35 times its smallest compressed size in memory. Files below this limit need
/// less than 1 GiB, and a failed allocation is their fault, not the machine's.
constexpr std::size_t kSmallFile = std::size_t{16} << 20;
constexpr std::size_t kMetadataLimit = 200;  ///< bytes of a metadata value worth keeping

[[noreturn]] void fail(const std::string& path, const std::string& reason) {
    throw Error(ErrorKind::input, shortened(path + ": " + reason, kMessageLimit));
}

/// The file is sound, but contains something unknown to this version of OpenVDB.
class UnknownType : public Error {
    using Error::Error;
};

void checkTypes(const std::string& path, const std::vector<GridOffer>& offers, const std::vector<std::size_t>& places) {
    for (const std::size_t i : places)
        if (!openvdb::GridBase::isRegistered(offers[i].type))
            throw UnknownType(ErrorKind::input,
                              shortened(fmt::format("{}: grid '{}' has the type '{}', which OpenVDB {} cannot read",
                                                    path, shortened(offers[i].name, 80), shortened(offers[i].type, 80),
                                                    openvdb::getLibraryVersionString()),
                                        kMessageLimit));
}

/// Turns OpenVDB's error into ours. Its message about points whose attributes have a third-party
/// codec ends with the codec's name.
[[noreturn]] void failToParse(const std::string& path, const std::string& damaged, const std::string& what) {
    constexpr std::string_view kUnregistered = "Cannot create attribute of unregistered type ";
    const std::size_t at = what.find(kUnregistered);
    if (at == std::string::npos) fail(path, damaged + shortened(what, 200));
    throw UnknownType(
        ErrorKind::input,
        shortened(fmt::format("{}: its points have an attribute of the type and codec '{}', which OpenVDB "
                              "{} does not know; its other grids can be used",
                              path, shortened(what.substr(at + kUnregistered.size()), 80),
                              openvdb::getLibraryVersionString()),
                  kMessageLimit));
}

/// Has OpenVDB parse `bytes` and returns the grids; everything it can throw becomes an Error.
openvdb::GridPtrVec parse(ParsedVdb& content, VdbStream& bytes) {
    const std::string damaged = content.layout.isNewer
                                    ? fmt::format("file version {} is newer than what OpenVDB {} knows, or damaged: ",
                                                  content.layout.fileVersion, openvdb::getLibraryVersionString())
                                    : "truncated or damaged: ";
    openvdb::GridPtrVec grids;
    try {
        std::istream stream(&bytes);
        stream.exceptions(std::ios_base::badbit | std::ios_base::failbit | std::ios_base::eofbit);
        openvdb::io::Stream reader(stream, /*delayLoad=*/false);
        if (const std::uint64_t left = bytes.size() - bytes.position(); left > 0)
            fail(content.path, fmt::format("{}{} bytes are left after the last grid", damaged, left));
        grids = *reader.getGrids();
        const openvdb::MetaMap::Ptr metadata = reader.getMetadata();
        for (auto entry = metadata->beginMeta(); entry != metadata->endMeta(); ++entry)
            content.metadata.emplace_back(shortened(entry->first, kMetadataLimit),
                                          shortened(entry->second->str(), kMetadataLimit));
    } catch (const Error&) {
        throw;
    } catch (const std::ios_base::failure&) {
        fail(content.path, damaged + "its data ends too early");
    } catch (const std::bad_alloc&) {
        if (bytes.size() < kSmallFile) fail(content.path, damaged + kClaimsMemory);
        throw Error(ErrorKind::memory, shortened(content.path + ": not enough memory to read it", kMessageLimit));
    } catch (const std::exception& error) {
        failToParse(content.path, damaged, error.what());
    }
    for (const openvdb::GridBase::Ptr& grid : grids)
        if (!grid || !grid->baseTreePtr()) fail(content.path, damaged + "a grid has no tree");
    return grids;
}

/// The version of the file, or the last one that OpenVDB knows.
std::uint32_t readableVersion(const VdbLayout& layout) {
    return layout.isNewer ? std::uint32_t{openvdb::OPENVDB_FILE_VERSION} : layout.fileVersion;
}

/// Reads each grid separately, where one of them is of a kind unknown to OpenVDB.
void readSingly(const VdbBytes& file, ParsedVdb& content) {
    const std::size_t count = content.offers.size();
    content.grids.assign(count, nullptr);
    content.problems.assign(count, "");
    for (std::size_t i = 0; i < count; ++i) try {
            VdbStream bytes(file, readableVersion(content.layout), content.layout, {i});
            checkTypes(file.path(), content.offers, {i});
            content.metadata.clear();
            const openvdb::GridPtrVec grids = parse(content, bytes);
            if (grids.size() == 1) content.grids[i] = grids[0];
        } catch (const UnknownType& error) {
            content.problems[i] = std::string(error.what()).substr(file.path().size() + 2);
        }
}

/// All that `requests` and `others` may mean.
std::set<GridRequest> wantedOf(const std::vector<GridRequest>* requests, const std::vector<std::string>& others) {
    std::set<GridRequest> wanted;
    if (requests) wanted.insert(requests->begin(), requests->end());
    for (const std::string& name : others)
        for (const int component : {GridRequest::kScalar, 0}) wanted.insert({name, component});
    return wanted;
}

/// Lists the attributes of points for errors.
void addAttributes(ParsedVdb& content, const std::string& points, const std::string& attributes) {
    content.attributes +=
        fmt::format("; points '{}' have {}", shortened(points, 80), attributes.empty() ? "no attributes" : attributes);
}

/// The points of a grid. Errors get the path.
PointCloud pointsIn(const ParsedVdb& content, const openvdb::GridBase& grid, const std::set<GridRequest>& wanted) {
    try {
        return pointsOf(grid, [&](const std::string& name) { return mayMean(wanted, name); });
    } catch (const Error& error) {
        fail(content.path, error.what());
    }
}

/// Makes fields, or grids where no memory for fields is given, of the points that `wanted` means.
void usePoints(const VdbBytes& file, ParsedVdb& content, const std::set<GridRequest>& wanted) {
    PointSet points;
    const bool lists = wantsLists(wanted);
    if (!content.layout.points.empty()) {
        PointCloud cloud = readPointFile(file);
        addAttributes(content, cloud.name, attributesOf(cloud));
        points.add(0, std::move(cloud), content.look, content.path, lists, content.notes);
    }
    for (std::size_t i = 0; i < content.grids.size(); ++i) {
        if (!content.grids[i] || !isPointGrid(*content.grids[i])) continue;
        const openvdb::GridBase::Ptr grid = std::move(content.grids[i]);
        addAttributes(content, grid->getName(), attributesOf(*grid));
        points.add(i, pointsIn(content, *grid, wanted), content.look, content.path, lists, content.notes);
    }
    if (points.empty()) return;
    if (content.memory != nullptr) {
        content.direct.merge(points.fields(content.offers, wanted, *content.memory));
        return;
    }
    for (PointSet::Made& made : points.grids(content.offers, wanted)) {
        const std::size_t place = made.place.value_or(content.grids.size());
        if (!made.place) {
            content.grids.emplace_back();
            content.offers.emplace_back();
        }
        content.grids[place] = std::move(made.grid);
        content.offers[place] = offerOf(*content.grids[place]);
    }
}

/// The same of a NanoVDB file.
void readNano(const VdbBytes& file, ParsedVdb& content, const std::optional<std::vector<std::size_t>>& places) {
    openvdb::initialize();
    const std::vector<VdbLayout::Grid>& all = content.layout.grids;
    content.grids.resize(all.size());
    if (places) {
        for (const std::size_t i : *places) content.grids[i] = readNanoGrid(file, all[i]);
        return;
    }
    content.problems.resize(all.size());
    for (std::size_t i = 0; i < all.size(); ++i)
        if (content.offers[i].isScalar() || content.offers[i].isVector())
            content.grids[i] = readNanoGrid(file, all[i]);
        else
            content.problems[i] = fmt::format("it has the type '{}', which is not read", all[i].type);
}

/// Reads fields of `places` without their grids where that is possible, and removes those from `places`.
void readDirectly(const VdbBytes& file, ParsedVdb& content, const std::vector<GridRequest>& requests,
                  std::vector<std::size_t>& places, BlockMemory& memory) {
    content.direct = directFields(file, content.layout, content.offers, requests, memory);
    for (const auto& [request, field] : content.direct) std::erase(places, chooseGrid(content.offers, request)->grid);
}

/// Reads the grids that the content of a file needs for `requests` and the grids called `others`, or all grids.
void readGrids(const VdbBytes& file, ParsedVdb& content, const std::vector<GridRequest>* requests,
               const std::vector<std::string>& others) {
    const std::string& path = file.path();
    std::optional<std::vector<std::size_t>> places;
    if (requests) places = neededGrids(content.layout, *requests, others);
    if (content.layout.isNano) return readNano(file, content, places);
    openvdb::initialize();
    if (!content.layout.points.empty()) return content.grids.resize(content.offers.size());
    if (places && content.memory != nullptr) readDirectly(file, content, *requests, *places, *content.memory);
    if (places && places->empty() && !content.direct.empty()) return content.grids.resize(content.offers.size());
    const std::uint32_t version = readableVersion(content.layout);
    VdbStream bytes = places ? VdbStream(file, version, content.layout, *places) : VdbStream(file, version);
    if (!places) {
        places.emplace(content.offers.size());
        std::iota(places->begin(), places->end(), std::size_t{0});
    }
    openvdb::GridPtrVec grids;
    try {
        checkTypes(path, content.offers, *places);
        grids = parse(content, bytes);
    } catch (const UnknownType&) {
        // A caller without requests wants to know about all grids, including unknown ones.
        if (requests || !content.layout.hasOffsets) throw;
        return readSingly(file, content);
    }
    if (!content.layout.hasOffsets) {
        for (const openvdb::GridBase::Ptr& grid : grids) content.offers.push_back(offerOf(*grid));
        content.grids = grids;
        return;
    }
    if (grids.size() != places->size())
        fail(path, fmt::format("truncated or damaged: it holds {} grids, expected {}", grids.size(), places->size()));
    content.grids.resize(content.offers.size());
    for (std::size_t i = 0; i < grids.size(); ++i) {
        const std::size_t place = (*places)[i];
        // Users of a grid rely on the type by which it was chosen, and the file may have changed since.
        if (grids[i]->type() != content.offers[place].type)
            fail(path, "truncated or damaged: it changed while it was read");
        content.grids[place] = grids[i];
    }
}

/// How a file is read.
struct ReadHow {
    std::vector<std::string> others = {};  ///< grids that are needed beside those that requests mean
    BlockMemory* memory = nullptr;         ///< null: fields are made of grids, in this process; must outlive the result
    PointLook look = {};
    bool points = true;  ///< points become grids, even where there are no requests
};

/// Opens the file for `requests`, or for all grids.
std::unique_ptr<ParsedVdb> read(const VdbBytes& file, const std::vector<GridRequest>* requests,
                                const ReadHow& how = {}) {
    auto content = std::make_unique<ParsedVdb>();
    content->path = file.path();
    content->bytes = file.size();
    content->layout = checkVdbLayout(file);
    content->offers = offersOf(content->layout);
    content->memory = how.memory;
    content->look = how.look;
    readGrids(file, *content, requests, how.others);
    if (!how.points) {
        if (!content->layout.points.empty()) content->unused = readPointFile(file);
        return content;
    }
    std::set<GridRequest> wanted = wantedOf(requests, how.others);
    for (const GridOffer& offer : content->offers)
        if (!requests && offer.isPoints()) wanted.insert({offer.name});
    usePoints(file, *content, wanted);
    return content;
}

/// The name of a part's grid, or of an attribute of points.
std::string partName(const std::vector<GridOffer>& offers, const CombinedGrid& grid, const CombinedGrid::Part& part,
                     const std::string& path) {
    const std::string& name = part.grid.empty() ? grid.name : part.grid;
    const bool points = std::any_of(offers.begin(), offers.end(), [](const auto& offer) { return offer.isPoints(); });
    if (points && !chooseNamed(offers, name) && !(part.grid.empty() && offers.size() == 1)) return name;
    return callName(offers, choosePart(offers, grid, part, path));
}

/// The grids that `wanted` mean, put together from several files as `editor` says.
std::unique_ptr<ParsedVdb> readCombined(const VdbFiles& files, const std::vector<std::string>& wanted,
                                        const GridEditor& editor, const MessageSink& messages) {
    const GridEdit& edit = editor.edit();
    std::vector<const CombinedGrid*> grids;
    for (const std::string& name : wanted)
        for (const CombinedGrid* const grid : gridsCalled(edit, name))
            if (std::find(grids.begin(), grids.end(), grid) == grids.end()) grids.push_back(grid);
    auto content = std::make_unique<ParsedVdb>();
    std::vector<std::unique_ptr<ParsedVdb>> parsed;
    for (std::size_t f = 0; f < files.size(); ++f) {
        const std::string& path = files[f]->path();
        const std::vector<GridOffer> offers = offersOf(checkVdbLayout(*files[f]));
        std::vector<std::string> names;
        for (const CombinedGrid* const grid : grids)
            for (const CombinedGrid::Part& part : grid->parts)
                if (part.file == f && !offers.empty()) names.push_back(partName(offers, *grid, part, path));
        const std::vector<GridRequest> none;
        parsed.push_back(read(*files[f], &none, {names, nullptr, edit.points}));
        content->notes.insert(content->notes.end(), parsed[f]->notes.begin(), parsed[f]->notes.end());
        content->path += (f == 0 ? "" : ", ") + path;
        content->bytes += files[f]->size();
        content->sources += fmt::format("; {} holds {}", shortened(path), listOf(parsed[f]->offers));
        if (f == 0 || parsed[f]->layout.isNewer) content->layout = parsed[f]->layout;
    }
    for (const CombinedGrid& grid : edit.grids) content->combined.push_back(grid.name);
    content->layout.grids.clear();
    for (const CombinedGrid* const grid : grids) {
        std::vector<openvdb::GridBase::Ptr> parts;
        for (const CombinedGrid::Part& part : grid->parts) {
            const ParsedVdb& file = *parsed[part.file];
            parts.push_back(file.grids[choosePart(file.offers, *grid, part, file.path)]);
        }
        content->grids.push_back(combine(edit, *grid, std::move(parts), messages));
        content->offers.push_back(offerOf(*content->grids.back()));
    }
    return content;
}

/// The description of a grid that was not read, from its descriptor.
GridInfo describeUnread(const VdbLayout::Grid& grid, const GridOffer& offer, const std::string& problem) {
    GridInfo info;
    info.name = grid.name;
    info.valueType = offer.valueType();
    info.gridClass = grid.gridClass;
    info.codec = grid.codec;
    info.problem = problem;
    return info;
}

GridInfo ParsedVdb::infoOfPoints(const openvdb::GridBase* grid) const {
    GridInfo info;
    if (grid != nullptr) {
        info = describeGrid(*grid);
        info.attributes = attributesOf(*grid);
        describePoints(pointsIn(*this, *grid, {}), info);
        return info;
    }
    info.name = offers.front().name;
    info.valueType = offers.front().valueType();
    info.gridClass = "unknown";
    info.attributes = attributesOf(*unused);
    describePoints(*unused, info);
    return info;
}

VdbFileInfo ParsedVdb::info() const {
    VdbFileInfo out;
    out.path = path;
    out.pointFormat = layout.points;
    if (unused) out.grids.push_back(infoOfPoints(nullptr));
    out.fileVersion = layout.fileVersion;
    out.libraryMajor = layout.libraryMajor;
    out.libraryMinor = layout.libraryMinor;
    out.isNano = layout.isNano;
    out.fileBytes = bytes;
    out.metadata = metadata;
    const std::vector<VdbLayout::Grid>& described = layout.grids;
    for (std::size_t i = 0; i < grids.size(); ++i) {
        if (!grids[i]) {
            if (!problems.empty() && !problems[i].empty())
                out.grids.push_back(describeUnread(described[i], offers[i], problems[i]));
            continue;
        }
        out.grids.push_back(isPointGrid(*grids[i]) ? infoOfPoints(grids[i].get()) : describeGrid(*grids[i]));
        // Without offsets in the file there is only what the writer stored in each grid's metadata, if anything.
        if (i < described.size()) out.grids.back().codec = described[i].codec;
    }
    return out;
}

std::vector<std::string> ParsedVdb::usableGrids() const {
    return scalarNames(offers);
}

void ParsedVdb::edit(const GridEditor& editor, const MessageSink& messages) {
    EditedGrids all{std::move(grids)};
    editor.apply(all, path, messages);
    grids = std::move(all.grids);
    offers.resize(grids.size());
    for (std::size_t i = 0; i < grids.size(); ++i)
        if (grids[i]) offers[i] = offerOf(*grids[i]);
}

std::string ParsedVdb::asFile() const {
    openvdb::GridCPtrVec all;
    for (const auto& grid : grids)
        if (grid) all.push_back(grid);
    std::ostringstream out;
    openvdb::io::Stream(out).write(all);
    return out.str();
}

SparseField ParsedVdb::lastField(const GridRequest& request, const MessageSink& messages) {
    const auto choice = chooseGrid(offers, request);
    if (choice && grids[choice->grid] && request.part == GridPart::whole && choice->component == GridRequest::kScalar) {
        grids[choice->grid] = inFloats(std::move(grids[choice->grid]));
        levelSetIntoFog(*grids[choice->grid], path, messages);
    }
    return field(request, messages);
}

SparseField ParsedVdb::field(const GridRequest& request, const MessageSink& messages) const {
    for (const auto& [severity, text] : notes) notify(messages, severity, text);
    if (const auto found = direct.find(request); found != direct.end()) {
        reportCleaning(found->second, path, messages);
        return found->second;
    }
    if (isList(request.part)) {
        SparseField none;
        none.name = request.grid;
        return none;
    }
    const auto choice = chooseGrid(offers, request);
    const auto refuse = [&](const std::string& reason) {
        throw GridError(shortened(path + ": " + reason, kMessageLimit), request);
    };
    if (!choice && !combined.empty() && !request.grid.empty() && !chooseNamed(offers, request.grid))
        refuse(fmt::format("no grid '{}' among those of 'grids': '{}'{}", shortened(request.grid, 80),
                           fmt::join(combined, "', '"), sources));
    if (!choice) refuse(whyNoGrid(offers, request) + attributes);
    const openvdb::GridBase::Ptr& grid = grids[choice->grid];
    BlockMemory here;
    BlockMemory& kept = memory != nullptr ? *memory : here;
    if (offers[choice->grid].isPoints() && (grid || unused)) {
        PointSet points;
        PointSet::Notes own;
        points.add(choice->grid, grid ? pointsIn(*this, *grid, {request}) : *unused, look, path, isList(request.part),
                   own);
        for (const auto& [severity, text] : own) notify(messages, severity, text);
        return points.fields(offers, {request}, kept).at(request);
    }
    if (!grid) refuse(fmt::format("grid '{}' was not requested when the file was opened", shortened(request.grid, 80)));
    if (layout.isNewer)
        notify(messages, Severity::warning,
               fmt::format("{}: file version {} is newer than OpenVDB {} knows; it may have been read wrongly", path,
                           layout.fileVersion, openvdb::getLibraryVersionString()));
    try {
        if (request.part != GridPart::whole)
            return velocityFromGrid(grid, choice->component, request.part == GridPart::negative, path, messages, kept);
        // A scalar may be a component of a vec3 grid.
        return request.component == GridRequest::kScalar && choice->component == GridRequest::kScalar
                   ? fieldFromGrid(grid, path, messages, kept)
                   : colourFromGrid(grid, choice->component, path, messages, kept);
    } catch (const Error& error) {
        if (error.kind() == ErrorKind::input) throw GridError(error.what(), request);
        throw;
    }
}

/// Runs `task`; lack of memory becomes an error about `path`.
template <typename Task>
std::unique_ptr<ParsedVdb> withinMemory(const std::string& path, const Task& task) {
    try {
        return task();
    } catch (const std::bad_alloc&) {
        throw Error(ErrorKind::memory, shortened(path + ": not enough memory to read this file", kMessageLimit));
    }
}

}  // namespace

/// As `read`; a file that is too large becomes the reason of the error.
std::unique_ptr<VdbFile::Content> readVdbContent(const VdbBytes& file, const std::vector<GridRequest>* requests,
                                                 BlockMemory* memory, const PointLook& look) {
    return withinMemory(file.path(), [&] { return read(file, requests, {{}, memory, look, requests != nullptr}); });
}

std::unique_ptr<VdbFile::Content> readEditedVdbContent(const VdbFiles& files, const std::vector<GridRequest>* requests,
                                                       const GridEditor& editor, const MessageSink& messages) {
    return withinMemory(files.front()->path(), [&] {
        const GridEdit& edit = editor.edit();
        const std::vector<std::string> used = editor.usedGrids();
        std::vector<GridRequest> all = requests ? *requests : std::vector<GridRequest>();
        all.push_back({edit.density});
        if (std::find(used.begin(), used.end(), edit.density) != used.end()) all.push_back({});
        std::unique_ptr<ParsedVdb> content;
        if (edit.grids.empty()) {
            content = read(*files.front(), requests ? &all : nullptr, {used, nullptr, edit.points});
        } else {
            std::vector<std::string> wanted = used;
            for (const GridRequest& request : all) wanted.push_back(request.grid);
            for (const CombinedGrid& grid : edit.grids)
                if (!requests) wanted.push_back(grid.name);
            content = readCombined(files, wanted, editor, messages);
        }
        content->edit(editor, messages);
        return content;
    });
}

std::unique_ptr<VdbFile::Content> editedContent(const std::vector<SparseField>& fields, const std::string& name,
                                                const GridEditor& editor, const MessageSink& messages) {
    return withinMemory(name, [&] {
        auto content = std::make_unique<ParsedVdb>();
        content->path = name;
        for (const SparseField& field : fields) {
            content->grids.push_back(gridFrom(field));
            content->offers.push_back(offerOf(*content->grids.back()));
        }
        content->edit(editor, messages);
        return content;
    });
}

std::shared_ptr<const GridEditor> makeGridEditor(const GridEdit& edit, const AxModule* ax) {
    return std::make_shared<const GridEditor>(edit, ax);
}

}  // namespace scrim
