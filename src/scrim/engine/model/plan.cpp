// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/model/plan.h>

#include <algorithm>

namespace scrim {
namespace {

double rampAt(const Vec2& ramp, double position) {
    if (ramp.x == ramp.y) return 1;
    const double t = std::clamp((position - ramp.x) / (ramp.y - ramp.x), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

}  // namespace

std::vector<int> TransportPlan::lights() const {
    std::vector<int> all;
    for (const ScatterTarget& target : targets) all.insert(all.end(), target.lights.begin(), target.lights.end());
    return all;
}

bool CellLightPlan::has(std::size_t light) const {
    return std::find(lights.begin(), lights.end(), static_cast<int>(light)) != lights.end();
}

std::vector<int> Plan::lightsOnCells() const {
    std::vector<int> all = transport.lights();
    all.insert(all.end(), cellLights.lights.begin(), cellLights.lights.end());
    return all;
}

double EyePart::weight(double x, double y) const {
    if (whole) return 1;
    const auto falling = [](const Vec2& ramp, double position) {
        return ramp.x == ramp.y ? 1 : 1 - rampAt(ramp, position);
    };
    return rampAt(left, x) * falling(right, x) * rampAt(top, y) * falling(bottom, y);
}

Box2<int> NeededTiles::over(int from, int to) const {
    Box2<int> all;
    for (int n = std::max(from, 0); n < std::min(to, static_cast<int>(sheets.size())); ++n) all.include(sheets[n]);
    return all;
}

double NeededTiles::share(const Sheets& s) const {
    double tiles = 0;
    for (const Box2<int>& box : sheets)
        if (!box.empty()) tiles += double(box.width()) * box.height();
    return tiles / (double(s.tilesX()) * s.tilesY() * s.count);
}

}  // namespace scrim
