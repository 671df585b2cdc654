// SPDX-License-Identifier: Apache-2.0
#include <scrim/verify/pilot_picture.h>

#include <algorithm>
#include <cmath>

namespace scrim {

ViewScene pilotView(ViewScene view, int edge) {
    const Int2 whole = view.camera.resolution;
    const double scale = std::min(1.0, double(edge) / std::max(whole.x, whole.y));
    const auto scaled = [&](int pixels) { return std::max(static_cast<int>(std::lround(scale * pixels)), 1); };
    view.camera.resolution = {scaled(whole.x), scaled(whole.y)};
    view.region = view.picture = PixelWindow{0, 0, view.camera.resolution.x, view.camera.resolution.y};
    view.dials.lightError = 0.1;
    view.dials.antialias = 1;
    view.layers.clear();
    view.deep.reset();
    for (ViewVolume& volume : view.volumes) {
        if (volume.medium.scattering == Scattering::full) volume.medium.scattering = Scattering::single;
        if (!volume.classified || !volume.classified->scatters) continue;
        Classified look = *volume.classified;
        look.scatters = false;
        volume.classified = std::make_shared<const Classified>(std::move(look));
    }
    return view;
}

Verification differenceOf(const Image& coarse, const Image& fine) {
    PixelSample all;
    all.candidates = fine.rgba.size() / 4;
    for (std::size_t i = 0; i < fine.rgba.size(); i += 4) {
        VerifiedPixel& pixel = all.pixels.emplace_back();
        std::copy_n(&coarse.rgba[i], 4, pixel.rendered.begin());
        std::copy_n(&fine.rgba[i], 4, pixel.reference.begin());
    }
    return summarise(all);
}

}  // namespace scrim
