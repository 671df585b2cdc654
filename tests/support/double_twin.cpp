// SPDX-License-Identifier: Apache-2.0
#include "support/double_twin.h"

#include <scrim/engine/composite/eye_rays.h>
#include <scrim/engine/splat/field_planes.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

// Values at whole positions, with a number of channels each.
template <std::size_t kChannels>
struct Raster {
    using Value = std::array<double, kChannels>;
    int width = 0, height = 0;
    std::vector<Value> values;

    Raster(int w, int h) : width(w), height(h), values(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {}
    Value& at(int x, int y) {
        return values[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
    }
    const Value& at(int x, int y) const { return const_cast<Raster*>(this)->at(x, y); }
    Value between(double x, double y) const {
        x = std::clamp(x, 0.0, width - 1.0);
        y = std::clamp(y, 0.0, height - 1.0);
        const int ix = std::min(static_cast<int>(x), width - 2), iy = std::min(static_cast<int>(y), height - 2);
        const double fx = x - ix, fy = y - iy;
        Value out;
        for (std::size_t c = 0; c < kChannels; ++c)
            out[c] = (1 - fy) * ((1 - fx) * at(ix, iy)[c] + fx * at(ix + 1, iy)[c]) +
                     fy * ((1 - fx) * at(ix, iy + 1)[c] + fx * at(ix + 1, iy + 1)[c]);
        return out;
    }
};
using Plane = Raster<1>;

// A coordinate in steps of the footprint table: whole places, the step within one, and what rounding left.
struct Quantised {
    int whole, step;
    double rest;
};

Quantised quantise(double at, int steps) {
    const double rounded = std::floor(at * steps + 0.5);
    const double whole = std::floor(rounded / steps);
    return {static_cast<int>(whole), static_cast<int>(rounded - whole * steps), at * steps - rounded};
}

// Stage 1: extinction of one volume, sheet by sheet.
void splat(const ViewVolume& volume, const Dials& dials, const Sheets& sheets, std::vector<Plane>& planes) {
    const Mat4 tsFromIs = sheets.tsFrom(volume.wsFromIs);
    const FootprintTable::Steps steps = footprintSteps(tsFromIs, dials.footprintSteps);
    const FootprintTable table(dials.kernel, tsFromIs, steps.texel, steps.sheet, FootprintTable::Lookup::sloped);
    const SparseField& field = *volume.field;
    for (std::size_t b = 0; b < field.blockCount(); ++b)
        for (int i = 0; i < kBlockVoxels; ++i) {
            const double value = field.block(b)[i] * volume.medium.densityScale;
            if (value == 0) continue;
            const Vec3 ts = transformPoint(tsFromIs, Vec3(field.blockOrigins[b] + Int3(i >> 6, i >> 3 & 7, i & 7)));
            const Quantised u = quantise(ts.x, steps.texel), v = quantise(ts.y, steps.texel),
                            n = quantise(ts.z, steps.sheet);
            const float* entry = table.weights() + table.offset(u.step, v.step, n.step);
            for (int slab = 0; slab < table.sheets(); ++slab) {
                const int sheet = n.whole + table.firstSheet() + slab;
                if (sheet < 0 || sheet >= sheets.count) continue;
                for (int row = 0; row < table.rows(); ++row)
                    for (int column = 0; column < table.columns(); ++column) {
                        const float* w = entry + slab * table.sheetStride() + row * table.rowStride() + column;
                        const int part = table.partStride();
                        planes[static_cast<std::size_t>(sheet)].at(u.whole + table.firstColumn() + column,
                                                                   v.whole + table.firstRow() + row)[0] +=
                            value * (w[0] + u.rest * w[part] + v.rest * w[2 * part] + n.rest * w[3 * part]);
                    }
            }
        }
}

// See splat/unblur.h.
void sharpen(Plane& plane) {
    const Plane before = plane;
    for (int y = 1; y + 1 < plane.height; ++y)
        for (int x = 1; x + 1 < plane.width; ++x) {
            const double here = before.at(x, y)[0];
            const double around =
                before.at(x - 1, y)[0] + before.at(x + 1, y)[0] + before.at(x, y - 1)[0] + before.at(x, y + 1)[0];
            plane.at(x, y)[0] = std::max(0.0, here - (around - 4 * here) / 12);
        }
}

// See ShadowBuffer::sharpen, for texels.
Plane sharpenedTau(const Plane& tau) {
    Plane out = tau;
    for (int y = 1; y + 1 < tau.height; ++y)
        for (int x = 1; x + 1 < tau.width; ++x) {
            const double here = tau.at(x, y)[0];
            const std::array<double, 4> around{tau.at(x - 1, y)[0], tau.at(x + 1, y)[0], tau.at(x, y - 1)[0],
                                               tau.at(x, y + 1)[0]};
            const auto [least, most] = std::minmax_element(around.begin(), around.end());
            const double sharp = here - (around[0] + around[1] + around[2] + around[3] - 4 * here) / 6;
            out.at(x, y)[0] = std::clamp(sharp, std::min(*least, here), std::max(*most, here));
        }
    return out;
}

double psi(double t) {
    return t == 0 ? 1 : -std::expm1(-t) / t;
}

// One group's sweep: what it adds to the picture.
class Sweep {
  public:
    Sweep(const ViewScene& scene, const GroupPlan& group)
        : m_scene(scene), m_group(group), m_sheets(group.sheets), m_eye(scene.camera, group.sheets) {
        const EyeSlopes& eye = m_eye.slopes();
        m_path = m_sheets.thickness * std::sqrt(1 + eye.a * eye.a + eye.b * eye.b);
        const std::vector<Plane> none(static_cast<std::size_t>(m_sheets.count), Plane(m_sheets.width, m_sheets.height));
        for (const ViewVolume& volume : scene.volumes) {
            m_volumes.push_back(none);
            splat(volume, scene.dials, m_sheets, m_volumes.back());
            for (Plane& plane : m_volumes.back()) sharpen(plane);
        }
        for (const LightPlan& light : group.lights) m_taus.emplace_back(light.view.width, light.view.height);
    }

    void addTo(std::vector<std::array<double, 4>>& picture) {
        std::vector<std::array<double, 4>> states(picture.size());
        for (int sheet = 0; sheet < m_sheets.count; ++sheet) {
            const Raster<4> shaded = shade(sheet);
            composite(shaded, sheet, states);
        }
        for (std::size_t i = 0; i < picture.size(); ++i) {
            for (std::size_t c = 0; c < 3; ++c) picture[i][c] += states[i][c];
            picture[i][3] -= m_group.primary * states[i][3];
        }
    }

  private:
    // Stages 3 and 4.
    Raster<4> shade(int sheet) {
        Plane total(m_sheets.width, m_sheets.height);
        for (const auto& volume : m_volumes)
            for (std::size_t i = 0; i < total.values.size(); ++i)
                total.values[i][0] += volume[static_cast<std::size_t>(sheet)].values[i][0];
        std::vector<Plane> entries;
        for (const Plane& tau : m_taus) entries.push_back(sharpenedTau(tau));
        for (std::size_t l = 0; l < m_taus.size(); ++l) attenuate(m_group.lights[l].view, sheet, total, m_taus[l]);

        Raster<4> out(m_sheets.width, m_sheets.height);
        for (int y = 0; y < total.height; ++y)
            for (int x = 0; x < total.width; ++x) {
                const double sigma = total.at(x, y)[0];
                if (sigma == 0) continue;
                auto& texel = out.at(x, y);
                for (std::size_t v = 0; v < m_volumes.size(); ++v) {
                    const double own = m_volumes[v][static_cast<std::size_t>(sheet)].at(x, y)[0];
                    const Rgb radiance = own * m_path * source(m_scene.volumes[v].medium, entries, sheet, x, y, sigma);
                    for (int c = 0; c < 3; ++c) texel[static_cast<std::size_t>(c)] += radiance[c];
                }
                texel[3] = std::expm1(-sigma * m_path);
            }
        return out;
    }

    static double slant(const LightView& view) {
        const double a = view.tsSource.x * view.slopeScale, b = view.tsSource.y * view.slopeScale;
        return std::sqrt(1 + a * a + b * b);
    }

    void attenuate(const LightView& view, int sheet, const Plane& total, Plane& tau) const {
        const LightView::Cells map = view.at(sheet);
        for (int y = 0; y < tau.height; ++y)
            for (int x = 0; x < tau.width; ++x)
                tau.at(x, y)[0] += m_sheets.thickness * slant(view) *
                                   total.between(map.offsetU + x * map.scale, map.offsetV + y * map.scale)[0];
    }

    // Per unit of the volume's own extinction and length.
    Rgb source(const Medium& medium, const std::vector<Plane>& entries, int sheet, int x, int y, double sigma) const {
        const double te = sigma * m_path;
        Rgb sum = m_group.primary * psi(te) * m_scene.ambient * medium.albedo;
        for (std::size_t l = 0; l < entries.size(); ++l) {
            const LightPlan& plan = m_group.lights[l];
            const Light& light = m_scene.lights[static_cast<std::size_t>(plan.light)];
            const LightView::Cells map = plan.view.at(sheet);
            const double entry = entries[l].between((x - map.offsetU) / map.scale, (y - map.offsetV) / map.scale)[0];
            const double tl = sigma * m_sheets.thickness * slant(plan.view);
            const double arrives = !plan.shadowed     ? psi(te)
                                   : m_group.sameSide ? std::exp(-entry) * psi(te + tl)
                                                      : std::exp(-entry - std::min(te, tl)) * psi(std::abs(te - tl));
            const double phase = phaseValue(medium.phase, -glm::dot(light.wsDirection, viewingAxis(m_scene.camera)));
            sum += plan.share * arrives * phase * light.intensity * medium.albedo;
        }
        return sum;
    }

    // Stage 5.
    void composite(const Raster<4>& shaded, int sheet, std::vector<std::array<double, 4>>& states) const {
        const int width = m_scene.region.width();
        for (std::size_t i = 0; i < states.size(); ++i) {
            const int x = static_cast<int>(i) % width, y = static_cast<int>(i) / width;
            const EyeView::Ray ray = m_eye.ray(x + 0.5, y + 0.5, sheet + 0.5);
            const auto texel = shaded.between(ray.u, ray.v);
            auto& state = states[i];
            const double front = 1 + state[3], back = 1 + texel[3];
            for (std::size_t c = 0; c < 4; ++c)
                state[c] = m_group.sameSide ? state[c] + front * texel[c] : texel[c] + back * state[c];
        }
    }

    const ViewScene& m_scene;
    const GroupPlan& m_group;
    const Sheets& m_sheets;
    EyeView m_eye;
    double m_path;                              // of the eye's rays through a sheet, world units
    std::vector<std::vector<Plane>> m_volumes;  // extinction of each volume on each sheet
    std::vector<Plane> m_taus;                  // each light's shadow buffer
};

}  // namespace

std::vector<std::array<double, 4>> renderInDouble(const ViewScene& scene, const Plan& plan) {
    std::vector<std::array<double, 4>> picture(static_cast<std::size_t>(scene.region.width()) *
                                               static_cast<std::size_t>(scene.region.height()));
    for (const GroupPlan& group : plan.groups) Sweep(scene, group).addTo(picture);
    return picture;
}

}  // namespace scrim::test
