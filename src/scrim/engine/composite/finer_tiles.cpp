// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/composite/finer_tiles.h>

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>

namespace scrim {

// The range of dU/dN and dV/dN of all rays of a level's lights.
struct FinerTiles::Slopes {
    double leastU = 0, mostU = 0, leastV = 0, mostV = 0;

    explicit Slopes(const std::vector<PlannedLight>& lights) {
        for (const PlannedLight& light : lights) {
            const LightView& view = light.view;
            const Vec2 first = view.distant ? Vec2(view.tsSource) : view.first;
            const Vec2 last = view.distant ? first : first + view.cell * Vec2(view.width, view.height);
            leastU = std::min(leastU, first.x);
            leastV = std::min(leastV, first.y);
            mostU = std::max(mostU, last.x);
            mostV = std::max(mostV, last.y);
        }
    }
};

FinerTiles::FinerTiles(const ViewScene& scene, const GroupPlan& level, const std::vector<bool>& finer,
                       const EyeView& eye, const PixelTiles& tiles)
    : m_sheets(std::size_t(level.sheets.count)) {
    const Slopes slopes(level.lights);
    for (std::size_t v = 0; v < scene.volumes.size(); ++v) {
        if (!finer[v]) continue;
        const ViewVolume& volume = scene.volumes[v];
        for (const ViewField& field : fieldsOf(volume)) {
            const double reach = kernelRadius(field.kernel.value_or(volume.kernel.value_or(scene.dials.kernel)));
            const Mat4 tsFromIs = level.sheets.tsFrom(field.wsFromIs);
            const auto add = [&](const Int3& origin, int edge) {
                Bounds is;
                is.include(Vec3(origin) - reach);
                is.include(Vec3(origin) + double(edge - 1) + reach);
                include(transformed(tsFromIs, is), slopes, level, eye, tiles);
            };
            for (const Int3& origin : field.field->blockOrigins) add(origin, kBlockEdge);
            for (const ConstantTile& tile : field.field->tiles) add(tile.origin, tile.edge);
        }
    }
}

// Within a sheet, light reaches points upstream of a box before it is shadowed there, so they count, too.
void FinerTiles::include(const Bounds& ts, const Slopes& slopes, const GroupPlan& level, const EyeView& eye,
                         const PixelTiles& tiles) {
    constexpr double kMargin = 0.25;  // texels; finer ones are smaller
    const int first = std::max(static_cast<int>(std::floor(ts.lower.z)), level.needed.first);
    const int last = std::min(static_cast<int>(std::floor(ts.upper.z)), level.needed.last - 1);
    for (int n = first; n <= last; ++n) {
        const double way = std::min(ts.upper.z - n, 1.0);
        const Box2<double> box{ts.lower.x - way * slopes.mostU - kMargin, ts.lower.y - way * slopes.mostV - kMargin,
                               ts.upper.x - way * slopes.leastU + kMargin, ts.upper.y - way * slopes.leastV + kMargin};
        std::vector<std::uint8_t>& sheet = m_sheets[std::size_t(n)];
        if (sheet.empty()) sheet.resize(std::size_t(tiles.count()));
        const auto near = eye.seenBy(box, n), far = eye.seenBy(box, n + 1);
        Box2<int> seen = tiles.all();
        if (near && far) {
            Box2<double> both = *near;
            both.include(far->x0, far->y0);
            both.include(far->x1, far->y1);
            seen = tiles.tilesIn(both);
        }
        for (int ty = seen.y0; ty < seen.y1; ++ty)
            std::fill_n(sheet.begin() + std::ptrdiff_t(ty) * tiles.tilesX() + seen.x0, std::max(seen.x1 - seen.x0, 0),
                        std::uint8_t{1});
    }
}

}  // namespace scrim
