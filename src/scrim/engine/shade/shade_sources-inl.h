// SPDX-License-Identifier: Apache-2.0
// Internal, compiled once for each instruction set (Highway's method): what a tile's samples send to the eye apart from
// light that comes directly from lights: emission, ambient light, and multiply scattered light.
#if defined(SCRIM_SHADE_SOURCES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SCRIM_SHADE_SOURCES_INL_H_
#undef SCRIM_SHADE_SOURCES_INL_H_
#else
#define SCRIM_SHADE_SOURCES_INL_H_
#endif

#include <scrim/engine/shade/shade_tile-inl.h>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

// Rows for three colours. With grey extinction only the first row is used.
struct Rows {
    alignas(64) Real values[3][kTileSize];
};

struct Work {
    alignas(64) Real slantEye[kTileSize];
    alignas(64) Real pathEye[kTileSize];
    Rows extinction, tauIn;  // only with coloured extinction
    Rows casting;            // extinction in a light that some channels do not attenuate
    Rows tauEye, light, through;
    Rows beauty;
    Incidence in;
    ShadeWork done;
};

// The sum of the rows of these extinction channels, each multiplied by its tint.
HWY_ATTR void mix(const ShadeInput& input, const Real* const* rows, std::span<const int> channels, Rows& out) {
    const DF d;
    for (int c = 0; c < 3; ++c)
        forSamples([&](int k) HWY_ATTR {
            auto sum = constant(0);
            for (const int r : channels) sum = hn::MulAdd(load(rows[r], k), constant(input.tints[r][c]), sum);
            hn::Store(sum, d, out.values[c] + k);
        });
}

constexpr int kChannels[ExtinctionChannels::kMost] = {0, 1, 2, 3, 4, 5, 6, 7, 8};

std::span<const int> allChannels(const ShadeInput& input) {
    return {kChannels, std::size_t(input.channels)};
}

Real* outputRow(const ShadeInput& input, Work& w, int output, int channel) {
    if (output == 0) return w.beauty.values[channel];
    return input.outputs + ((output - 1) * 3 + channel) * kTileSize;
}

// The factor by which radiance per world unit leaves the sheet towards the eye: mean transmittance times path length.
HWY_ATTR void fillThrough(const ShadeInput& input, Work& w) {
    const DF d;
    const int channels = input.coloured ? 3 : 1;
    for (int c = 0; c < channels; ++c)
        forSamples([&](int k) HWY_ATTR {
            hn::Store(hn::Mul(load(w.pathEye, k), psi(load(w.tauEye.values[c], k))), d, w.through.values[c] + k);
        });
    w.done.exponentials += static_cast<std::uint64_t>(channels * kTileSize);
}

HWY_ATTR void addSource(const ShadeInput& input, const Real* coefficient, Real color, int channel, int output,
                        Work& w) {
    const DF d;
    if (color == 0) return;
    const Real* through = w.through.values[input.coloured ? channel : 0];
    Real* to = outputRow(input, w, output, channel);
    forSamples([&](int k) HWY_ATTR {
        const auto part = hn::Mul(load(coefficient, k), load(through, k));
        hn::Store(hn::MulAdd(part, constant(color), load(to, k)), d, to + k);
    });
}

// Adds the source also to the volume's own output, if there is one.
HWY_ATTR void addSource(const ShadeInput& input, const Real* coefficient, Real color, int channel, int output,
                        const std::optional<int>& own, Work& w) {
    addSource(input, coefficient, color, channel, output, w);
    if (own) addSource(input, coefficient, color, channel, *own, w);
}

// Adds light on cells, which differs from sample to sample.
HWY_ATTR void addScatteredBefore(const ShadeInput& input, const SheetScattered& scattered, int output, Work& w) {
    const DF d;
    const SheetMedium* medium = scattered.surface < 0 ? &input.media[std::size_t(scattered.medium)] : nullptr;
    const SheetSurface* surface = medium ? nullptr : &input.surfaces[std::size_t(scattered.surface)];
    for (int c = 0; c < 3; ++c) {
        const Real reflects = medium                               ? medium->albedo[c]
                              : scattered.as == ShownAs::scattered ? surface->albedo[c]
                                                                   : Real(1);
        const auto albedo = constant(reflects * scattered.share);
        const Real *through = w.through.values[input.coloured ? c : 0], *radiance = scattered.radiance[c],
                   *scatter = medium                              ? medium->scatter[c]
                              : scattered.as == ShownAs::mirrored ? surface->extinction
                                                                  : surface->emission[c];
        Real* to = outputRow(input, w, output, c);
        forSamples([&](int k) HWY_ATTR {
            const auto part = hn::Mul(hn::Mul(load(scatter, k), load(through, k)), load(radiance, k));
            hn::Store(hn::MulAdd(part, albedo, load(to, k)), d, to + k);
        });
    }
}

// Adds what all volumes make of uniform radiance from all directions; `radiance` has a value for
// each channel, and `share` gives the fraction for surfaces. `seen`: it is part of the beauty.
template <class SurfaceShare>
HWY_ATTR void addEnvironment(const ShadeInput& input, const Real* radiance, int output, bool seen,
                             const SurfaceShare& share, Work& w) {
    for (int c = 0; c < 3; ++c) {
        for (const SheetMedium& medium : input.media)
            if (medium.ambient || !seen)
                addSource(input, medium.scatter[c], radiance[c] * medium.albedo[c], c, output,
                          seen ? medium.output : std::nullopt, w);
        for (const SheetSurface& surface : input.surfaces)
            addSource(input, surface.emission[c], radiance[c] * share(surface), c, output,
                      seen ? surface.output : std::nullopt, w);
    }
}

// Adds all light that does not come directly from lights.
HWY_ATTR void addSources(const ShadeInput& input, Work& w) {
    const bool ambient = input.ambient[0] != 0 || input.ambient[1] != 0 || input.ambient[2] != 0;
    if (!ambient && input.emissions.empty() && input.scattered.empty() && input.opacities.empty() &&
        !input.layout.albedo)
        return;
    fillThrough(input, w);
    if (ambient) {
        addEnvironment(
            input, input.ambient, input.layout.ambient, true, [](const SheetSurface& s) { return s.ambient; }, w);
        w.done.ambients += kTileSize;
    }
    for (const SheetEmission& emission : input.emissions) {
        for (int c = 0; c < 3; ++c)
            addSource(input, emission.coefficient, emission.color[c], c, input.layout.emission, emission.output, w);
        w.done.emissions += kTileSize;
    }
    for (const SheetScattered& scattered : input.scattered) {
        addScatteredBefore(input, scattered, scattered.output, w);
        const std::optional<int>& own = scattered.surface < 0 ? input.media[std::size_t(scattered.medium)].output
                                                              : input.surfaces[std::size_t(scattered.surface)].output;
        if (own) addScatteredBefore(input, scattered, *own, w);
        if (scattered.again && input.layout.indirect) addScatteredBefore(input, scattered, *input.layout.indirect, w);
        w.done.scattered += kTileSize;
    }
    for (const SheetEmission& opacity : input.opacities)
        for (int c = 0; c < 3; ++c) addSource(input, opacity.coefficient, opacity.color[c], c, *opacity.output, w);
    constexpr Real kWhite[3] = {1, 1, 1};
    if (input.layout.albedo)
        addEnvironment(
            input, kWhite, *input.layout.albedo, false, [](const SheetSurface&) { return Real(1); }, w);
}

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
