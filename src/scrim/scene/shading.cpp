// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/scene.h>

#include <algorithm>
#include <cmath>

namespace scrim {
namespace {

double part(double value, const std::array<double, 2>& range) {
    return std::clamp((value - range[0]) / (range[1] - range[0]), 0.0, 1.0);
}

}  // namespace

double Remap::at(double value) const {
    double t = part(value, from);
    if (gamma != 1) t = std::pow(t, 1 / gamma);
    // Two powers that meet in the middle.
    if (contrast != 1) t = t < 0.5 ? 0.5 * std::pow(2 * t, contrast) : 1 - 0.5 * std::pow(2 - 2 * t, contrast);
    return to[0] + t * (to[1] - to[0]);
}

double DensityShading::at(double density, double maskValue, double noiseValue) const {
    double v = remap ? remap->at(density) : density;
    if (edge) {
        const double t = part(v, *edge);
        v *= t * t * (3 - 2 * t);
    }
    if (mask) v *= mask->remap.at(maskValue);
    if (noise && noiseMode == NoiseMode::multiply) v *= std::max(0.0, 1 + noise->amount * noiseValue);
    if (noise && noiseMode == NoiseMode::erode) v = std::max(0.0, v - noise->amount * 0.5 * (1 + noiseValue));
    return v;
}

}  // namespace scrim
