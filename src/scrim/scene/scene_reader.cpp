// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/scene_reader.h>

#include <scrim/base/error.h>
#include <scrim/scene/check_scene.h>
#include <scrim/scene/read_sections.h>
#include <scrim/scene/quality.h>
#include <scrim/scene/toml_writer.h>
#include <scrim/scene/volume_file.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <sstream>
#include <system_error>

namespace scrim {
namespace {

/// The largest file that is read. Scenes are written by people, or by exporters that key a few dozen values.
constexpr std::size_t kLargestFile = std::size_t{16} << 20;

/// The largest frame. It keeps a frame plus an offset within an int.
constexpr double kLargestFrame = 1e9;

/// Turns a list [[output]] into the table that is its first item, with the others as its further files.
void joinOutputs(toml::table& root) {
    const OutputKeys& k = keysOf<OutputKeys>();
    toml::array* const list = root[keysOf<SceneKeys>().output.name].as_array();
    if (list == nullptr || list->empty() || !list->is_array_of_tables()) return;
    toml::table first = std::move(*list->front().as_table());
    list->erase(list->begin());
    if (toml::array* const own = first[k.files.name].as_array()) {
        for (toml::node& more : *list) own->push_back(std::move(*more.as_table()));
    } else if (!list->empty()) {
        first.insert(k.files.name, std::move(*list));  // does nothing where that key is no list, which is refused later
    }
    root.insert_or_assign(keysOf<SceneKeys>().output.name, std::move(first));
}

toml::table parsed(const SceneText& text, const std::vector<std::string>& overrides) {
    toml::table root = parseToml(text.text, text.file);
    joinOutputs(root);
    for (const std::string& assignment : overrides) applyOverride(root, assignment);
    return root;
}

/// Looks a variable up in `variables`, then in the environment.
VariableLookup lookupIn(std::vector<std::pair<std::string, std::string>> variables) {
    return [variables = std::move(variables)](const std::string& name) -> std::optional<std::string> {
        for (const auto& [key, value] : variables)
            if (key == name) return value;
        const char* const value = std::getenv(name.c_str());
        return value == nullptr ? std::nullopt : std::optional<std::string>(value);
    };
}

/// Reads all [[key]] tables with `read(table, default name)` and checks that their names differ.
template <typename Item, typename Read>
std::vector<Item> readNamed(TomlTable& root, const Key& key, const Read& read) {
    std::vector<Item> items;
    std::map<std::string, std::size_t> numbers;  // 1 + the index of the item of each name
    for (const TomlTable& table : root.tables(key)) {
        Item item = read(table, fmt::format("{}{}", key.name, items.size() + 1));
        const auto [known, isNew] = numbers.emplace(item.name, items.size() + 1);
        if (!isNew)
            table.fail(fmt::format("[[{}]] number {} is called '{}', and so is number {}; expected different names",
                                   key.name, items.size() + 1, item.name, known->second));
        items.push_back(std::move(item));
    }
    return items;
}

/// The longest path of a key that is recorded. Keys of real scenes are shorter; a volume with an
/// enormous name would have it repeated for each of its keys.
constexpr std::size_t kLongestPath = 1000;

/// Records the place of each key in `table` and in its inner tables, under the paths of SceneLines.
/// Tables in lists go by their names, as in overrides.
void addLines(const toml::table& table, const std::string& prefix, std::map<std::string, std::string>& lines) {
    for (const auto& [key, node] : table) {
        const std::string path = prefix + std::string(key.str());
        if (path.size() > kLongestPath) continue;
        lines.emplace(path, whereOf(node.source()));
        if (const toml::table* inner = node.as_table()) addLines(*inner, path + ".", lines);
        const toml::array* list = node.as_array();
        for (std::size_t i = 0; list != nullptr && i < list->size(); ++i) {
            const toml::table* item = (*list)[i].as_table();
            if (item == nullptr) continue;
            const std::string itemPath = path + "." +
                                         (*item)[keysOf<VolumeKeys>().name.name].value<std::string>().value_or(
                                             fmt::format("{}{}", key.str(), i + 1));
            if (itemPath.size() > kLongestPath) continue;
            lines.emplace(itemPath, whereOf(item->source()));
            addLines(*item, itemPath + ".", lines);
        }
    }
}

std::map<std::string, std::string> linesOf(const toml::table& tree) {
    std::map<std::string, std::string> lines;
    addLines(tree, "", lines);
    return lines;
}

/// True if any value in `node` is keyed.
bool hasKeys(const toml::node& node) {
    if (const toml::array* list = node.as_array())
        return std::any_of(list->begin(), list->end(), [](const toml::node& item) { return hasKeys(item); });
    const toml::table* table = node.as_table();
    return table != nullptr &&
           ((*table)[keysOf<KeyedKeys>().keys.name].is_array() ||
            std::any_of(table->begin(), table->end(), [](const auto& entry) { return hasKeys(entry.second); }));
}

/// True if a keyed value changes between two frames. `keys`: a list of [frame, value], which was checked before.
bool changesBetween(const toml::array& keys, double begin, double end) {
    const auto pairAt = [&](std::size_t i) {
        const toml::array* pair = keys[i].as_array();
        return pair != nullptr && pair->size() == 2 ? pair : nullptr;
    };
    const auto equal = [](const toml::node& a, const toml::node& b) {
        toml::array one, other;
        one.push_back(a);
        other.push_back(b);
        return one == other;
    };
    for (std::size_t i = 1; i < keys.size(); ++i) {
        const toml::array *a = pairAt(i - 1), *b = pairAt(i);
        if (a == nullptr || b == nullptr) return false;  // the value is not keyed: it is the parameter of a source
        const double from = (*a)[0].value<double>().value_or(0), to = (*b)[0].value<double>().value_or(0);
        if (from < end && to > begin && !equal((*a)[1], (*b)[1])) return true;
    }
    return false;
}

/// True if any keyed value in `node` changes between two frames.
bool movesBetween(const toml::node& node, double begin, double end) {
    const auto moves = [&](const toml::node& inner) { return movesBetween(inner, begin, end); };
    if (const toml::array* list = node.as_array()) return std::any_of(list->begin(), list->end(), moves);
    const toml::table* table = node.as_table();
    if (table == nullptr) return false;
    return std::any_of(table->begin(), table->end(), [&](const auto& entry) {
        // The choice of a volume's file, and what is done to its grids, depend on the frame only,
        // not on the moment within it.
        const VolumeKeys& volume = keysOf<VolumeKeys>();
        const auto is = [&](const Key& key) { return entry.first.str() == key.name && entry.second.is_table(); };
        if (is(volume.frame) || is(volume.parameters) || is(volume.displacement) || is(keysOf<DensityKeys>().noise))
            return false;
        const bool isKeys = entry.first.str() == keysOf<KeyedKeys>().keys.name && entry.second.is_array();
        return isKeys ? changesBetween(*entry.second.as_array(), begin, end) : moves(entry.second);
    });
}

/// Leaves out grids that nothing shows: what held-out volumes emit and by which colours they scatter is of use only
/// where it lights volumes in which light scatters more than once, or meshes that are seen.
void leaveOutUnseen(Scene& scene) {
    if (std::ranges::any_of(scene.volumes, &SceneVolume::scattersFully) ||
        std::ranges::any_of(scene.meshes, [](const SceneMesh& m) { return m.color.has_value(); }))
        return;
    for (SceneVolume& volume : scene.volumes) {
        if (!volume.holdout) continue;
        volume.albedoGrid.reset();
        volume.emission.clear();
    }
}

/// Lets the points of volumes with a velocity be known wherever they pass while the shutter is
/// open, or between two files.
void sweepPoints(Scene& scene) {
    for (SceneVolume& volume : scene.volumes) {
        if (!volume.velocity || volume.file.empty()) continue;
        const double step = volume.velocity->perFrame(scene.output.fps);
        const bool carried = volume.frameMap.between == BetweenFiles::advect;
        std::vector<double> times{0};
        const auto include = [&](double t) {
            const double time = step * filesWithin(volume, {}, scene.frame, t);
            times.push_back(time);
            // What files there are is not known yet: the sequence may be on its way back.
            if (volume.frameMap.between != BetweenFiles::nearest && volume.outside == OutsidePolicy::pingPong)
                times.push_back(-time);
        };
        if (scene.shutter) {
            const auto [open, close] = *scene.shutter;
            include(open);
            include(close);
            for (const auto& [key, number] : volume.frameMap.keys.keys)
                if (key - scene.frame > open && key - scene.frame < close) include(key - scene.frame);
        }
        if (carried) times.insert(times.end(), {-step, step});
        GridEdit edit = volume.edit ? *volume.edit : GridEdit();
        edit.points.open = *std::min_element(times.begin(), times.end());
        edit.points.close = *std::max_element(times.begin(), times.end());
        edit.density = volume.densityGrid;
        if (edit.points.open < edit.points.close) volume.edit = std::make_shared<const GridEdit>(std::move(edit));
    }
}

/// Adds the shadow layer where a solid catches shadows, since the shadows are shown in that layer.
void addShadowLayer(Scene& scene) {
    const std::vector<Layer> layers = scene.output.allLayers();
    const bool caught = std::any_of(scene.meshes.begin(), scene.meshes.end(), [](const auto& m) { return m.catches; });
    if (caught && std::find(layers.begin(), layers.end(), Layer::shadow) == layers.end())
        scene.output.layers.push_back(Layer::shadow);
}

/// Adds the layer of what is seen besides volumes, so that it can be taken out of the picture again.
void addBackdropLayer(Scene& scene) {
    const std::vector<Layer> layers = scene.output.allLayers();
    const bool seen = std::ranges::any_of(scene.lights, &Light::visible) ||
                      std::ranges::any_of(scene.meshes, [](const SceneMesh& m) { return m.color.has_value(); });
    if (!seen) return;
    if (!scene.output.holdout.file.empty())
        throw Error(
            ErrorKind::input,
            fmt::format(
                "{}: a picture that hides the volumes has a backdrop of its own; expected no light with {} and no "
                "mesh with {} beside {} of [output]",
                scene.output.holdout.where, keysOf<LightKeys>().visible, keysOf<MeshKeys>().color,
                keysOf<OutputKeys>().holdout));
    if (std::find(layers.begin(), layers.end(), Layer::backdrop) == layers.end())
        scene.output.layers.push_back(Layer::backdrop);
}

}  // namespace

SceneText loadSceneText(const std::string& path) {
    std::error_code error;
    const auto status = std::filesystem::status(path, error);
    if (!std::filesystem::exists(status))
        throw Error(ErrorKind::input, fmt::format("{}: there is no such scene file", path));
    // Reading a pipe would hang, and a folder reads as empty.
    if (!std::filesystem::is_regular_file(status))
        throw Error(ErrorKind::input, fmt::format("{}: not a regular file; expected a scene (TOML)", path));
    std::ifstream file(path, std::ios::binary);
    if (!file) throw Error(ErrorKind::input, fmt::format("{}: the scene file cannot be read", path));
    SceneText text{path, std::filesystem::path(path).parent_path().string(), ""};
    // Most scenes are small, and touching memory for the largest one takes longer than reading them.
    constexpr std::size_t kStep = std::size_t{64} << 10;
    while (file && text.text.size() <= kLargestFile) {
        const std::size_t size = text.text.size();
        text.text.resize(size + kStep);
        file.read(text.text.data() + size, kStep);
        text.text.resize(size + static_cast<std::size_t>(file.gcount()));
    }
    if (file.bad()) throw Error(ErrorKind::input, fmt::format("{}: the scene file cannot be read", path));
    if (text.text.size() > kLargestFile)
        throw Error(ErrorKind::input, fmt::format("{}: the scene file is larger than 16 MB", path));
    return text;
}

Scene readScene(const SceneText& text, double frame, const std::vector<std::string>& overrides,
                const ColourConfig& colour, double within) {
    if (!(std::abs(frame) <= kLargestFrame))
        throw Error(ErrorKind::input, fmt::format("{}: frame {} is beyond {}", text.file, frame, kLargestFrame));
    const toml::table tree = parsed(text, overrides);
    const SceneKeys& k = keysOf<SceneKeys>();
    TomlTable root(tree, "the scene's top level");
    const auto section = [&](const Key& key) -> std::optional<TomlTable> {
        const auto value = root.find(key);
        return value ? std::optional<TomlTable>(value->table(fmt::format("[{}]", key.name))) : std::nullopt;
    };

    ReadContext context{frame + within, frame, colour, text.folder, lookupIn({})};
    context.gridsFromCode = text.gridsFromCode;
    context.deepFromCode = text.deepFromCode;
    if (const auto variables = section(k.variables)) context.variables = lookupIn(readVariables(*variables));
    if (auto output = section(k.output)) context.fps = output->number(keysOf<OutputKeys>().fps);
    context.version = root.integer(k.sceneVersion);

    Scene scene;
    scene.file = text.file;
    scene.frame = frame;
    root.require(k.camera, "a table [camera]");
    readCamera(*section(k.camera), context, scene);
    const std::string atLeastOne = "at least one [[volume]]";
    root.require(k.volume, atLeastOne);
    scene.meshes = readNamed<SceneMesh>(
        root, k.mesh, [&](const TomlTable& table, const std::string& name) { return readMesh(table, name, context); });
    for (const SceneMesh& mesh : scene.meshes) context.meshes.push_back(mesh.name);
    scene.lights = readNamed<Light>(root, k.light, [&](const TomlTable& table, const std::string& name) {
        return readLight(table, name, context);
    });
    for (const Light& light : scene.lights) context.lights.push_back(light.name);
    scene.volumes = readNamed<SceneVolume>(root, k.volume, [&](const TomlTable& table, const std::string& name) {
        return readVolume(table, name, context);
    });
    if (scene.volumes.empty()) root.require(k.volume).failExpecting(atLeastOne);
    if (const auto ambient = section(k.ambient)) scene.ambient = readAmbient(*ambient, context);
    scene.dials = *presetDials(scene.quality);
    scene.keepsPromise = true;
    if (const auto table = section(k.render)) readRender(*table, context, scene);
    scene.moves = scene.moves || hasKeys(tree);
    scene.movesOn = hasKeys(tree);
    for (const SceneMesh& mesh : scene.meshes) scene.moves = scene.moves || mesh.sequence.hasFrame();
    const auto output = section(k.output);
    scene.output = output ? readOutput(*output, context) : defaultOutput(context);
    root.finish();
    addShadowLayer(scene);
    addBackdropLayer(scene);
    leaveOutUnseen(scene);
    sweepPoints(scene);
    scene.warnings = *context.warnings;
    scene.lines = std::make_shared<const SceneLines>(linesOf(tree));
    if (const auto& shutter = scene.shutter)
        scene.movesWithin = movesBetween(tree, frame + shutter->open, frame + shutter->close);
    checkScene(scene);
    return scene;
}

Camera readCameraText(const std::string& text, const std::string& name, const ColourConfig& colour) {
    const toml::table tree = parseToml(text, name);
    const CameraKeys& k = keysOf<CameraKeys>();
    // A camera text may not refer to a picture in turn. It needs no colours, so any config will do.
    if (tree.contains(k.exr.name)) throw Error(ErrorKind::input, fmt::format("{}: {} is not known here", name, k.exr));
    Scene scene;
    readCamera(TomlTable(tree, "[camera]", &k), ReadContext{1, 1, colour, "", lookupIn({})}, scene);
    return scene.camera;
}

std::string sceneAsToml(const SceneText& text, const std::vector<std::string>& overrides) {
    const toml::table root = parsed(text, overrides);
    if (overrides.empty()) return text.text;
    return tomlText(root);
}

}  // namespace scrim
