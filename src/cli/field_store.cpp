// SPDX-License-Identifier: Apache-2.0
#include "field_store.h"

#include "interrupt.h"

#include <scrim/base/error.h>
#include <scrim/volume/source.h>

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace scrim::cli {
namespace {

std::vector<std::string> keyOf(const SceneVolume& volume, const VolumeFile& file) {
    if (volume.source.empty()) return {"file", file.path, volume.densityGrid};
    std::vector<std::string> key{"source", volume.source, volume.densityGrid};
    for (const auto& [name, value] : volume.parameters) {
        key.push_back(name);
        key.push_back(value);
    }
    return key;
}

/// The grid of a source that `volume` asks for: the named one, else "density", else the first.
SparseField pick(std::vector<SparseField> fields, const SceneVolume& volume) {
    std::vector<std::string> names;
    for (const SparseField& field : fields) names.push_back(field.name);
    auto found = std::find(names.begin(), names.end(), volume.densityGrid.empty() ? "density" : volume.densityGrid);
    if (found == names.end() && volume.densityGrid.empty()) found = names.begin();
    if (found == names.end())
        throw Error(ErrorKind::input, fmt::format("{}: source '{}' makes no grid '{}'; there is {}", volume.where,
                                                  volume.source, volume.densityGrid, choices(names)));
    return std::move(fields[static_cast<std::size_t>(found - names.begin())]);
}

}  // namespace

void FieldStore::loadMissing(const std::string& path, const std::vector<std::string>& grids) {
    std::vector<SparseField> fields = loadFields(path, grids, m_limits, m_messages);
    for (std::size_t i = 0; i < grids.size(); ++i)
        m_fields[{"file", path, grids[i]}] = std::make_shared<SparseField>(std::move(fields[i]));
}

void FieldStore::makeMissing(const SceneVolume& volume) {
    std::vector<SparseField> fields;
    try {
        fields = generate(volume.source, volume.parameters, m_messages, [](double) { return interruptSignal() == 0; });
    } catch (const Error& error) {
        throw Error(error.kind(), fmt::format("{}: {}", volume.where, error.what()));
    }
    m_fields[keyOf(volume, {})] = std::make_shared<SparseField>(pick(std::move(fields), volume));
}

Fields FieldStore::fieldsOf(const Scene& scene, const std::vector<VolumeFile>& files) {
    std::set<Key> used;
    for (std::size_t i = 0; i < scene.volumes.size(); ++i)
        if (!scene.volumes[i].source.empty() || files[i].state == FileState::present)
            used.insert(keyOf(scene.volumes[i], files[i]));
    // First let go, then load: two frames' fields together may be more than there is memory for.
    std::erase_if(m_fields, [&](const auto& entry) { return !used.contains(entry.first); });

    std::map<std::string, std::vector<std::string>> grids;  // of each file, to be read in one go
    for (const Key& key : used)
        if (key[0] == "file" && !m_fields.contains(key)) grids[key[1]].push_back(key[2]);
    for (const auto& [path, names] : grids) loadMissing(path, names);

    Fields fields;
    for (std::size_t i = 0; i < scene.volumes.size(); ++i) {
        const SceneVolume& volume = scene.volumes[i];
        const Key key = keyOf(volume, files[i]);
        if (!volume.source.empty() && !m_fields.contains(key)) makeMissing(volume);
        fields.push_back({used.contains(key) ? m_fields.at(key) : nullptr, {}, {}});
    }
    return fields;
}

std::shared_ptr<const SparseField> FieldStore::fieldOf(const std::string& path, const std::string& grid) {
    const Key key{"file", path, grid};
    if (!m_fields.contains(key)) loadMissing(path, {grid});
    return m_fields.at(key);
}

std::vector<VolumeFile> findFiles(const Scene& scene) {
    std::vector<VolumeFile> files;
    for (const SceneVolume& volume : scene.volumes)
        files.push_back(volume.source.empty() ? findVolumeFile(volume) : VolumeFile{});
    return files;
}

std::size_t bytesOf(const Fields& fields) {
    std::size_t bytes = 0;
    std::set<std::shared_ptr<const SparseField>> all;
    for (const VolumeFields& of : fields) {
        all.insert(of.density);
        all.insert(of.albedo.begin(), of.albedo.end());
        all.insert(of.emission.begin(), of.emission.end());
    }
    for (const auto& field : all)
        if (field)
            bytes += field->blockCount() * (kBlockVoxels * sizeof(float) + sizeof(Int3)) +
                     field->tiles.size() * sizeof(ConstantTile);
    return bytes;
}

}  // namespace scrim::cli
