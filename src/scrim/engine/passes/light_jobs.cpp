// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/passes/light_jobs.h>

#include <scrim/engine/cells/cell_media.h>
#include <scrim/engine/lamps/lamp.h>
#include <scrim/engine/model/served_lights.h>
#include <scrim/engine/model/sub_lights.h>

#include <algorithm>
#include <map>
#include <set>
#include <span>
#include <tuple>
#include <utility>

namespace scrim {
namespace {

// Lights share a field unless layers, or the volumes and solids that cast shadows in them, tell
// them apart. Lamps share one with each other, and have small ones of their own.
std::vector<std::vector<int>> groupsOf(const LevelScene& level, const std::vector<int>& lights) {
    const ViewScene& scene = level.all;
    std::vector<int> lamps, others;
    for (const int light : lights)
        (isLampOnCells(level.own, scene.lights[std::size_t(light)]) ? lamps : others).push_back(light);
    std::vector<std::vector<int>> groups;
    std::map<std::tuple<int, std::vector<bool>, bool>, std::vector<int>> alike;
    for (const int light : others)
        alike[{wants(scene, Layer::light) ? lightOfLayer(scene, light) : 0, castersIn(scene, std::size_t(light)),
               isBlocked(scene, std::size_t(light))}]
            .push_back(light);
    for (const auto& [key, some] : alike) groups.push_back(some);
    const bool together = lampsShareCells(level.own);
    if (together && !lamps.empty()) groups.push_back(lamps);
    for (std::size_t i = 0; !together && i < lamps.size(); ++i) groups.push_back({lamps[i]});
    return groups;
}

// Makes the jobs of one group of lights.
class Jobs {
  public:
    Jobs(const LevelScene& level, const std::vector<int>& group, const OctaveCells& octaves,
         std::shared_ptr<const CellGrid> grid, bool grey)
        : m_scene(level.own),
          m_all(level.all),
          m_group(group),
          m_octaves(octaves),
          m_grid(std::move(grid)),
          m_grey(grey),
          m_lamps(isLampOnCells(m_scene, m_scene.lights[std::size_t(group.front())])) {}

    // Their fields become those of `direct` or, beyond the first octave, of `again`, which may be the same.
    std::vector<LightJob> make(CellLight& direct, CellLight& again) const {
        std::vector<LightJob> jobs;
        // Volumes that scatter fully are apart, since others bring some lights to them.
        const std::vector<ServedLight> served = servedLights(m_scene, m_group);
        for (const bool full : {false, true})
            for (const std::vector<int>& volumes : alikeVolumes(m_scene, [full](const ViewVolume& volume) {
                     return !volume.field->empty() && !volume.holdout && !volume.classified &&
                            scattersFully(volume) == full;
                 })) {
                std::vector<int> lit;
                for (const int i : m_group)
                    if (served[std::size_t(i)].volumes[std::size_t(volumes.front())] == Server::cells) lit.push_back(i);
                if (lit.empty()) continue;
                const bool apart = &direct != &again;
                const std::vector<Octave> all = octavesOf(m_scene.volumes[std::size_t(volumes.front())].medium);
                std::vector<Octave> first, further;
                for (std::size_t n = 0; n < all.size(); ++n)
                    if (m_octaves.have(all[n])) (apart && n > 0 ? further : first).push_back(all[n]);
                add(lit, first, volumes, direct, jobs);
                add(lit, further, volumes, again, jobs);
            }
        return jobs;
    }

    // The job of a classified volume: what it reflects becomes that of two lights.
    void addSurface(std::size_t v, const std::shared_ptr<const CellGrid>& cells, CellLight& diffuse,
                    CellLight& mirrored, std::vector<LightJob>& jobs) const {
        const std::vector<ServedLight> served = servedLights(m_scene, m_group);
        std::vector<int> lit;
        for (const int i : m_group)
            if (served[std::size_t(i)].volumes[v] == Server::cells) lit.push_back(i);
        if (lit.empty()) return;
        Sources sources = coloured(heldBack(sourcesForSurfaces(m_scene, lit), lit));
        if (sources.lights.empty()) return;
        const auto kept = [&](CellLight& light) {
            const auto field = std::make_shared<CellField>(cells, static_cast<int>(sources.colours), sources.tint);
            light.ofVolume[v] = std::make_shared<const VolumeLight>(VolumeLight{field});
            return field;
        };
        LightJob job{lit.front(), sources, {}, kept(diffuse)};
        job.surface = static_cast<int>(v);
        if (m_scene.volumes[v].classified->specular > 0) job.mirrored = kept(mirrored);
        jobs.push_back(std::move(job));
    }

  private:
    // Volumes of any level hold them back.
    Sources heldBack(Sources sources, const std::vector<int>& lights) const {
        sources.attenuated = isHeldBack(m_all, std::size_t(lights.front()));
        return sources;
    }
    // With a value for each colour where extinction has one.
    Sources coloured(Sources sources) const {
        if (!m_grey) sources.colours = 3;
        if (sources.colours == 3) sources.tint = Rgb(1);
        return sources;
    }
    // Adds the jobs of some octaves, whose light becomes that of these volumes.
    void add(const std::vector<int>& lit, const std::vector<Octave>& octaves, const std::vector<int>& volumes,
             CellLight& light, std::vector<LightJob>& jobs) const {
        if (octaves.empty()) return;
        VolumeLight shown;
        if (m_lamps)
            addLamps(lit, octaves, shown, jobs);
        else
            addOthers(lit, octaves, shown, jobs);
        if (!shown.field && shown.lamps.empty()) return;
        const auto kept = std::make_shared<const VolumeLight>(std::move(shown));
        for (const int v : volumes) light.ofVolume[std::size_t(v)] = kept;
    }
    void addOthers(const std::vector<int>& lit, const std::vector<Octave>& octaves, VolumeLight& shown,
                   std::vector<LightJob>& jobs) const {
        const Sources sources = coloured(heldBack(sourcesOf(m_scene, lit), lit));
        if (sources.lights.empty()) return;
        const auto field = std::make_shared<CellField>(m_grid, static_cast<int>(sources.colours), sources.tint);
        shown.field = field;
        const std::size_t first = jobs.size();
        for (const Octave& octave : octaves) {
            LightJob& job = jobs.emplace_back(LightJob{lit.front(), sources, octave, field});
            job.wide = widePhases(m_scene, sources, octave.phase);
        }
        const std::span<LightJob> own(jobs.data() + first, octaves.size());
        const std::vector<std::shared_ptr<AreaField>> areas = areasOf(own);
        for (LightJob& job : own) job.areas = areas;
        for (const auto& area : areas)
            if (area) shown.areas.push_back(area);
    }
    // For each light of the jobs, which are those of octaves of the same sources, a field of what
    // is close to it, if AreaShine serves it, and sub-lights are elements of it.
    std::vector<std::shared_ptr<AreaField>> areasOf(std::span<const LightJob> jobs) const {
        const Sources& sources = jobs.front().sources;
        std::vector<std::shared_ptr<AreaField>> areas(sources.ofScene.size());
        const Vec3 corner = cornerOfVoxels(m_scene, m_grid->edge());
        const double sheet = m_scene.dials.sheetThickness * voxelUnit(m_scene);
        for (std::size_t owner = 0; owner < areas.size(); ++owner) {
            const Light& light = m_scene.lights[std::size_t(sources.ofScene[owner])];
            const auto [first, end] = std::ranges::equal_range(sources.owners, static_cast<int>(owner));
            if (!AreaShine::serves(light) || first == end) continue;
            const std::span elements(sources.lights.begin() + (first - sources.owners.begin()),
                                     std::size_t(end - first));
            if (!elements.front().element()) continue;
            AreaView view{{}, m_scene.camera, sheet};
            for (const LightJob& job : jobs) view.octaves.push_back(job.octave);
            auto area =
                std::make_shared<AreaField>(light, view, elements, *m_grid, corner, sources.colours, sources.tint);
            if (area->any()) areas[owner] = std::move(area);
        }
        return areas;
    }
    // Lamps have fields of their own; if they share cells, these are small, and a field of all keeps the rest.
    void addLamps(const std::vector<int>& lit, const std::vector<Octave>& octaves, VolumeLight& shown,
                  std::vector<LightJob>& jobs) const {
        const bool together = lampsShareCells(m_scene);
        std::shared_ptr<CellField> far;
        if (together) {
            bool coloured = !m_grey;
            const Rgb tint = m_scene.lights[std::size_t(lit.front())].intensity;
            for (const int i : lit) coloured = coloured || !sameColour(tint, m_scene.lights[std::size_t(i)].intensity);
            far = std::make_shared<CellField>(m_grid, coloured ? 3 : 1, coloured ? Rgb(1) : tint / largest(tint));
        }
        shown.field = far;
        for (const int i : lit) {
            const Light& light = m_scene.lights[std::size_t(i)];
            const Sources sources = heldBack(sourcesOf(m_scene, {i}), {i});
            const auto cells = together ? cellsNear(light, *m_grid, cornerOfVoxels(m_scene, m_grid->edge())) : m_grid;
            const LampView view{light, octaves, m_scene.camera, sources.attenuated, together};
            const auto lamp = std::make_shared<LampField>(view, cells, m_grey ? 1 : 3);
            shown.lamps.push_back(lamp);
            // What the cells keep is a transmittance; the field knows what octaves make of it.
            for (std::size_t k = 0; k < lamp->knots().size(); ++k) {
                LightJob& job = jobs.emplace_back(LightJob{i, sources, {{}, lamp->knots()[k].extinction}, far, lamp});
                job.knot = k;
            }
        }
    }

    const ViewScene &m_scene, &m_all;
    const std::vector<int>& m_group;
    const OctaveCells& m_octaves;
    std::shared_ptr<const CellGrid> m_grid;
    bool m_grey, m_lamps;
};

}  // namespace

std::vector<OctaveCells> octaveCells(const LevelScene& level, const std::vector<int>& lights, double edge) {
    // Eight octaves on Disney's cloud: with cells twice as large for all but the first, what they show of a sky, a soft
    // box and a sphere differs by 0.1, 0.2 and 0.4 %, in a third of the time. With cells four times as large from the
    // third on, by 0.15, 0.4 and 0.6 %. Smoke of 16 voxels, whose features are as small as its voxels, lost 1 %.
    const bool edges = hasSurfaces(level.all) ||
                       std::ranges::any_of(lights, [&](int light) { return isBlocked(level.all, std::size_t(light)); });
    if (edges || kLargerCells * edge > level.features) return {OctaveCells{}};
    std::vector<OctaveCells> sizes;
    for (const OctaveCells& size :
         {OctaveCells{.above = 1.0 / kLargerCells}, OctaveCells{kLargerCells, -1, 1.0 / kLargerCells}}) {
        const auto has = [&](const ViewVolume& volume) {
            return std::ranges::any_of(octavesOf(volume.medium), [&](const Octave& o) { return size.have(o); });
        };
        if (std::ranges::any_of(level.own.volumes, has)) sizes.push_back(size);
    }
    return sizes;
}

std::vector<LightJob> lightJobs(const LevelScene& level, const std::vector<int>& lights, const OctaveCells& octaves,
                                const std::shared_ptr<const CellGrid>& grid, const LitSurfaces& surfaces, bool grey,
                                std::vector<CellLight>& all) {
    const ViewScene& scene = level.all;
    std::vector<LightJob> jobs;
    std::map<int, std::shared_ptr<CellField>> open;  // by lamp
    const auto keep = [&](CellLight&& light) {
        if (std::ranges::any_of(light.ofVolume, [](const auto& own) { return own != nullptr; }))
            all.push_back(std::move(light));
    };
    for (const std::vector<int>& group : groupsOf(level, lights)) {
        CellLight direct;
        if (wants(scene, Layer::light)) direct.output = Output{Layer::light, lightOfLayer(scene, group.front())};
        direct.ofVolume.resize(scene.volumes.size());
        CellLight again = direct, diffuse = direct, mirrored = direct;
        again.again = true;
        diffuse.as = ShownAs::diffuse;
        mirrored.as = ShownAs::mirrored;
        const bool apart = wants(scene, Layer::indirect);
        const Jobs make(level, group, octaves, grid, grey);
        for (LightJob& job : make.make(direct, apart ? again : direct)) {
            if (job.lamp && isBlocked(scene, std::size_t(job.first))) {
                std::shared_ptr<CellField>& own = open[job.first];
                if (!own) own = std::make_shared<CellField>(grid, 1);
                job.open = own;
            }
            jobs.push_back(std::move(job));
        }
        for (std::size_t v = 0; octaves.larger == 1 && v < scene.volumes.size(); ++v)
            if (surfaces.grid(v)) make.addSurface(v, surfaces.grid(v), diffuse, mirrored, jobs);
        for (CellLight* light : {&direct, &again, &diffuse, &mirrored}) keep(std::move(*light));
    }
    return jobs;
}

std::size_t bytesOf(const std::vector<LightJob>& jobs) {
    std::set<const CellField*> fields;
    std::set<const AreaField*> areas;  // octaves share them
    std::size_t bytes = 0;
    for (const LightJob& job : jobs) {
        for (const CellField* field : {job.field.get(), job.open.get(), job.mirrored.get()})
            if (field && fields.insert(field).second) bytes += field->bytes();
        if (job.lamp && job.knot == 0) bytes += job.lamp->bytes();
        for (const auto& area : job.areas)
            if (area && areas.insert(area.get()).second) bytes += area->bytes();
    }
    return bytes;
}

}  // namespace scrim
