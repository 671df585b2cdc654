// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/solve/scattered_light.h>

#include <scrim/engine/solve/domain_light.h>
#include <scrim/engine/solve/scatter_domains.h>

#include <algorithm>
#include <map>
#include <memory>

namespace scrim {
namespace {

class ScatteredLight {
  public:
    ScatteredLight(const ViewScene& scene, const TransportPlan& plan, KeptLight kept, Simd simd,
                   const std::function<void()>& checkpoint);

    std::vector<CellLight> lights() const;
    const std::array<std::shared_ptr<CellField>, 3>& flux() const { return m_domains.front().flux(); }

    const Solved& solved() const { return m_solved; }
    // Peak memory.
    std::size_t bytes() const { return m_bytes; }

  private:
    // Those of a domain's cells, and of cells twice as large.
    using Borders = std::array<DomainBorder, 2>;
    Borders bordersOf(std::size_t d, const DomainMedia& cells, const CellMedia& around) const;
    void solve(std::size_t d, const DomainMedia& cells, const DomainLight::Settings& settings);

    const ViewScene& m_scene;
    const TransportPlan& m_plan;
    const std::vector<ScatterClass> m_classes;
    std::vector<DomainLight> m_domains;
    std::vector<Borders> m_borders;  // of each domain but the first, once the one around it is solved for
    Solved m_solved;
    std::size_t m_bytes = 0;
};

ScatteredLight::ScatteredLight(const ViewScene& scene, const TransportPlan& plan, KeptLight kept, Simd simd,
                               const std::function<void()>& checkpoint)
    : m_scene(scene),
      m_plan(plan),
      m_classes(scatterClasses(scene, solvedOrdinates(plan.ordinates))),
      m_borders(plan.domains.size()) {
    const DomainMedia cells(scene, plan.domains, m_classes, simd);
    for (std::size_t d = 0; d < plan.domains.size(); ++d)
        solve(d, cells, {scene, plan, m_classes, kept, simd, checkpoint});
    m_borders.clear();
}

ScatteredLight::Borders ScatteredLight::bordersOf(std::size_t d, const DomainMedia& cells,
                                                  const CellMedia& around) const {
    auto own = std::make_shared<Around>();
    own->media = cells.around(d, around);
    const std::vector<ScatterClass> last = scatterClasses(m_scene, m_plan.ordinates);
    if (!std::ranges::equal(m_classes, last, {}, &ScatterClass::straight, &ScatterClass::straight))
        own->split = splitAgain(own->media, m_classes, last);
    if (const int parent = m_plan.domains[d].parent; parent > 0)
        own->further = m_borders[std::size_t(parent)][0].around;
    return {DomainBorder{cells.gridOf(d), own}, DomainBorder{cells.gridOf(d, 2), own}};
}

void ScatteredLight::solve(std::size_t d, const DomainMedia& cells, const DomainLight::Settings& settings) {
    const CellMedia media = cells.of(d);
    std::vector<DomainBorder*> inner;
    const bool extrapolates = media.grid.cells() > 0 && !m_plan.coarse && media.grid.sides() == 0;
    for (std::size_t i = d + 1; i < m_plan.domains.size(); ++i) {
        if (m_plan.domains[i].parent != static_cast<int>(d)) continue;
        m_borders[i] = bordersOf(i, cells, media);
        inner.push_back(m_borders[i].data());
        if (extrapolates) inner.push_back(m_borders[i].data() + 1);
    }
    DomainLight& light = m_domains.emplace_back(settings, media, d == 0 ? nullptr : m_borders[d].data(), inner);
    std::size_t fields = 0, borders = 0, peak = light.peak();
    for (const DomainLight& known : m_domains) fields += known.bytes();
    for (const Borders& both : m_borders)
        for (const DomainBorder& border : both) borders += border.bytes();
    if (extrapolates) {
        // The solver is gone when that of larger cells comes.
        DomainLight::Settings mean = settings;
        if (mean.kept == KeptLight::meanAndFlux) mean.kept = KeptLight::mean;
        const DomainLight twice(mean, cells.of(d, 2), d == 0 ? nullptr : m_borders[d].data() + 1, {});
        peak = std::max(peak, twice.bytes() + twice.peak());
        m_solved += twice.solved();
        light.improveBy(twice, scattersInSurfaces(m_scene));
    }
    m_solved += light.solved();
    m_bytes = std::max(m_bytes, fields + borders + peak);
    if (!m_plan.coarse) light.separate();
    light.limitFlux();
    m_borders[d] = {};
}

std::vector<CellLight> ScatteredLight::lights() const {
    // The domain and the class of each volume.
    std::vector<std::size_t> domain(m_scene.volumes.size(), 0), cls(domain.size(), m_classes.size());
    for (std::size_t v = 0; v < domain.size(); ++v)
        for (std::size_t d = 0; d < m_plan.domains.size(); ++d)
            if (m_plan.domains[d].volumes[v]) domain[v] = d;
    for (std::size_t k = 0; k < m_classes.size(); ++k)
        for (const int volume : m_classes[k].volumes) cls[std::size_t(volume)] = k;
    std::vector<CellLight> all;
    for (std::size_t t = 0; t < m_plan.targets.size(); ++t) {
        const auto add = [&](bool again, const auto& fieldsOf) {
            CellLight& light = all.emplace_back(CellLight{m_plan.targets[t].output, again, {}});
            std::map<std::pair<std::size_t, std::size_t>, std::shared_ptr<const VolumeLight>> known;
            for (std::size_t v = 0; v < domain.size(); ++v) {
                light.ofVolume.push_back(nullptr);
                if (cls[v] == m_classes.size()) continue;
                auto& own = known[{domain[v], cls[v]}];
                if (!own)
                    own = std::make_shared<const VolumeLight>(
                        VolumeLight{fieldsOf(m_domains[domain[v]])[t * m_classes.size() + cls[v]]});
                light.ofVolume.back() = own;
            }
        };
        add(true, [](const DomainLight& light) { return light.fields(); });
        if (!m_classes.empty() && m_domains.front().unscattered()[t * m_classes.size()])
            add(false, [](const DomainLight& light) { return light.unscattered(); });
    }
    return all;
}

}  // namespace

bool scattersInSurfaces(const ViewScene& scene) {
    constexpr double kDense = 1;
    return std::ranges::any_of(scene.volumes, [&](const ViewVolume& v) {
        return v.classified && scattersFully(v) && std::ranges::any_of(v.classified->transfer, [&](const auto& point) {
                   return point.extinction * v.classified->densityScale * voxelUnit(scene) > kDense;
               });
    });
}

std::size_t solvesOf(const ViewScene& scene, const TransportPlan& plan) {
    std::size_t solves = 0;
    for (const ScatterTarget& target : plan.targets) solves += partsOf(scene, plan, target).size();
    return solves;
}

std::vector<CellLight> scatteredLight(const ViewScene& scene, const TransportPlan& plan, Simd simd,
                                      const std::function<void()>& checkpoint, Solved& solved, std::size_t& bytes) {
    const ScatteredLight light(scene, plan, KeptLight::towardsEye, simd, checkpoint);
    solved += light.solved();
    bytes += light.bytes();
    return light.lights();
}

std::pair<std::vector<CellLight>, std::array<std::shared_ptr<CellField>, 3>> scatteredMoments(
    const ViewScene& scene, const TransportPlan& plan, bool flux, Simd simd, const std::function<void()>& checkpoint,
    Solved& solved) {
    const ScatteredLight light(scene, plan, flux ? KeptLight::meanAndFlux : KeptLight::mean, simd, checkpoint);
    solved += light.solved();
    return {light.lights(), light.flux()};
}

}  // namespace scrim
