// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/shade/shade_tile.h>

#include <algorithm>
#include <cmath>
#include <type_traits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "scrim/engine/shade/shade_tile.cpp"
#include <hwy/foreach_target.h>
#include <scrim/engine/shade/shade_sources-inl.h>
#include <scrim/engine/shade/shade_tile-inl.h>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

// Light that passes through the sheet to the samples and from there to the eye, for one channel;
// all rows belong to that channel.
struct Passage {
    const Real* extinction;
    const Real* tauIn;
    const Real* tauEye;
    Real pathScale;  // of a light's path through the sheet
    Real depth;      // factor on optical depths towards the light
};

// The radiance that one light adds per unit of intensity, scattering coefficient and phase function.
template <bool kShadowed, bool kSameSide>
HWY_ATTR void transmit(const Passage& p, const Incidence& in, const Real* pathEye, Real* out) {
    const DF d;
    [[maybe_unused]] const auto depth = constant(p.depth), scale = constant(p.depth * p.pathScale);
    forSamples([&](int k) HWY_ATTR {
        const auto te = load(p.tauEye, k);
        VF light = psi(te);
        if constexpr (kShadowed) {
            const auto tl = hn::Mul(load(p.extinction, k), hn::Mul(load(in.slant, k), scale));
            const auto entry = hn::Mul(depth, load(p.tauIn, k));
            if constexpr (kSameSide)
                light = hn::Mul(expMinus(entry), psi(hn::Add(te, tl)));
            else
                light = hn::Mul(expMinus(hn::Add(entry, hn::Min(te, tl))), psi(hn::Abs(hn::Sub(te, tl))));
        }
        hn::Store(hn::Mul(hn::Mul(light, load(in.irradiance, k)), load(pathEye, k)), d, out + k);
    });
}

// As `transmit`, where tau towards the light is known at both ends of the eye's segment. Where the field is linear, as
// it is close to a surface, tau towards any light is a linear function of tau towards the eye: both are the same
// integral of the transfer function, divided by the field's slopes along the two rays. So this is exact for a surface
// anywhere within the sheet, however opaque it is and however it leans.
HWY_ATTR void transmitBetween(const Real* tauIn, const Real* tauOut, const Real* tauEye, const Incidence& in,
                              const Real* pathEye, Real* out) {
    const DF d;
    forSamples([&](int k) HWY_ATTR {
        const auto entry = load(tauIn, k);
        const auto change = hn::Add(load(tauEye, k), hn::Sub(load(tauOut, k), entry));
        const auto nearest = hn::Max(hn::Add(entry, hn::Min(change, constant(0))), constant(0));
        const auto light = hn::Mul(expMinus(nearest), psi(hn::Abs(change)));
        hn::Store(hn::Mul(hn::Mul(light, load(in.irradiance, k)), load(pathEye, k)), d, out + k);
    });
}

// True if a channel of the extinction lets the light pass.
bool leavesLightAlone(const ShadeInput& input, const SheetLight& light) {
    return light.channels.size() < std::size_t(input.channels);
}

// The rest of one light at the samples, with `depth` as factor on extinction.
HWY_ATTR void transmitAll(const ShadeInput& input, std::size_t index, Real depth, Work& w) {
    const SheetLight& light = input.lights[index];
    const Real* const tauIn = input.tauAtEntry(index);
    const int channels = input.coloured ? 3 : 1;
    w.done.exponentials += static_cast<std::uint64_t>(channels * (light.shadowed ? 2 : 1) * kTileSize);
    if (input.tauOut && light.shadowed)
        return transmitBetween(tauIn, input.tauOut + index * kTileSize, w.tauEye.values[0], w.in, w.pathEye,
                               w.light.values[0]);
    const Rows& extinction = leavesLightAlone(input, light) ? w.casting : w.extinction;
    for (int c = 0; c < channels; ++c) {
        const Passage passage{input.coloured ? extinction.values[c] : input.extinction[0],
                              input.coloured ? w.tauIn.values[c] : tauIn, w.tauEye.values[c],
                              light.withinSheet ? input.thickness : Real(0), depth};
        Real* out = w.light.values[c];
        if (!light.shadowed)
            transmit<false, true>(passage, w.in, w.pathEye, out);
        else if (input.sameSide)
            transmit<true, true>(passage, w.in, w.pathEye, out);
        else
            transmit<true, false>(passage, w.in, w.pathEye, out);
    }
}

template <bool kTinted>
HWY_ATTR void scatterInto(const ShadeInput& input, const Lit& lit, const SheetMedium& medium, const Phase& phase,
                          Real part, Work& w) {
    if (input.coloured || medium.scatter[1] != medium.scatter[0])
        addScattered<kTinted, true>(lit, medium, phase, part);
    else
        addScattered<kTinted, false>(lit, medium, phase, part);
    if (!phase.isotropic()) w.done.phases += kTileSize;
}

bool lights(const SheetLight& light, const std::vector<bool>* lit) {
    return !lit || (*lit)[std::size_t(light.index)];
}

// Adds a volume's response to a light to the light's rows, and to further outputs.
template <class Add>
void addTo(const ShadeInput& input, const Lit& lit, std::initializer_list<std::optional<int>> outputs, Work& w,
           const Add& add) {
    add(lit);
    for (const std::optional<int>& output : outputs) {
        if (!output) continue;
        Lit own = lit;
        for (int c = 0; c < 3; ++c) own.to[c] = outputRow(input, w, *output, c);
        add(own);
    }
}

// The first octave is single scattering, which also applies to surfaces; only media have further ones.
template <bool kTinted>
HWY_ATTR void addToVolumes(const ShadeInput& input, std::size_t index, const Lit& lit, Work& w) {
    const SheetLight& light = input.lights[index];
    transmitAll(input, index, 1, w);
    for (const SheetMedium& medium : input.media)
        if (lights(light, medium.lit))
            addTo(input, lit, {medium.output}, w, [&](const Lit& to) {
                Lit wide = to;
                if (light.part > 0) wide.caps = medium.caps;
                scatterInto<kTinted>(input, wide, medium, medium.phase, 1, w);
            });
    for (const SheetSurface& surface : input.surfaces)
        if (lights(light, surface.lit))
            addTo(input, lit, {surface.output}, w, [&](const Lit& to) { addReflected<kTinted>(to, surface); });
    for (const SheetMedium& medium : input.media) {
        if (!lights(light, medium.lit)) continue;
        const Octaves& o = medium.octaves;
        for (int n = 1; n < o.count; ++n) {
            transmitAll(input, index, static_cast<Real>(std::pow(o.extinction, n)), w);
            const Phase phase = flattened(medium.phase, std::pow(o.phase, n));
            addTo(input, lit, {medium.output, input.layout.indirect}, w, [&](const Lit& to) {
                scatterInto<kTinted>(input, to, medium, phase, static_cast<Real>(std::pow(o.contribution, n)), w);
            });
            w.done.octaves += kTileSize;
        }
    }
}

HWY_ATTR void addLight(const ShadeInput& input, std::size_t index, Work& w) {
    const SheetLight& light = input.lights[index];
    if (light.slide.image) {
        w.done.slideLookups += kTileSize;
        if (!tintAlongPaths(input, light, w.in.tint)) return;  // outside of the slide's picture
    }
    if (const DistantOnSheet* sun = light.distant())
        meetDistant(*sun, w.in);
    else
        meetNear(input, light, w.in);
    if (input.unblocked) scale(input.unblocked + index * kTileSize, w.in.irradiance);
    w.done.lightLookups += kTileSize;

    if (input.coloured && light.shadowed) {
        const Real* rows[ExtinctionChannels::kMost];
        for (int r = 0; r < input.channels; ++r) rows[r] = input.tauAtEntry(index) + r * kTileSize;
        mix(input, rows, light.channels, w.tauIn);
        if (leavesLightAlone(input, light)) mix(input, input.extinction, light.channels, w.casting);
    }
    Lit lit{&input, &light, &w.in, w.slantEye, {}, {}};
    for (int c = 0; c < 3; ++c) {
        lit.amount[c] = w.light.values[input.coloured ? c : 0];
        lit.to[c] = outputRow(input, w, light.output, c);
    }
    if (light.slide.image)
        addToVolumes<true>(input, index, lit, w);
    else
        addToVolumes<false>(input, index, lit, w);
}

HWY_ATTR void enterSheet(const ShadeInput& input, Work& w) {
    const DF d;
    const int channels = input.coloured ? 3 : 1;
    if (input.coloured) mix(input, input.extinction, allChannels(input), w.extinction);
    forSamples([&](int k) HWY_ATTR {
        const auto a = load(input.samples->eyeA, k), b = load(input.samples->eyeB, k);
        const auto slant = hn::Sqrt(hn::MulAdd(a, a, hn::MulAdd(b, b, constant(1))));
        hn::Store(slant, d, w.slantEye + k);
        hn::Store(hn::Mul(slant, constant(input.thickness)), d, w.pathEye + k);
    });
    for (int c = 0; c < channels; ++c) {
        const Real* extinction = input.coloured ? w.extinction.values[c] : input.extinction[0];
        forSamples([&](int k) HWY_ATTR {
            hn::Store(hn::Mul(load(w.pathEye, k), load(extinction, k)), d, w.tauEye.values[c] + k);
        });
    }
    for (auto& channel : w.beauty.values) forSamples([&](int k) HWY_ATTR { hn::Store(constant(0), d, channel + k); });
    std::fill(input.outputs, input.outputs + (input.layout.outputs - 1) * 3 * kTileSize, Real(0));
    w.done.samples = kTileSize;
}

// The usual case: grey extinction and only the beauty.
HWY_ATTR void writeBeauty(Work& w, Real* out) {
    const DF d;
    forSamples([&](int k) HWY_ATTR {
        hn::StoreInterleaved4(load(w.beauty.values[0], k), load(w.beauty.values[1], k), load(w.beauty.values[2], k),
                              hn::Neg(oneMinusExp(load(w.tauEye.values[0], k))), d, out + 4 * k);
    });
}

// The visible fraction of the samples' opacities; volumes are mixed evenly within a sheet.
HWY_ATTR void fillSeen(const ShadeInput& input, const Rows& opacity, Work& w) {
    const DF d;
    Rows& seen = w.tauIn;  // no longer needed
    if (input.seen[0] && input.coloured) mix(input, input.seen, allChannels(input), seen);
    for (int c = 0; c < 3; ++c) {
        const Real* hides = opacity.values[input.coloured ? c : 0];
        Real* to = outputRow(input, w, *input.layout.seen, c);
        if (!input.seen[0]) {
            std::copy_n(hides, kTileSize, to);
            continue;
        }
        const Real* shown = input.coloured ? seen.values[c] : input.seen[0];
        const Real* all = input.coloured ? w.extinction.values[c] : input.extinction[0];
        forSamples([&](int k) HWY_ATTR {
            const auto some = hn::Gt(load(all, k), constant(0));
            const auto share = hn::Min(hn::Div(load(shown, k), load(all, k)), constant(1));
            hn::Store(hn::IfThenElseZero(some, hn::Mul(load(hides, k), share)), d, to + k);
        });
    }
}

// Depth of the samples times the visible opacity.
HWY_ATTR void fillDepth(const ShadeInput& input, const Rows& opacity, Work& w) {
    const DF d;
    const SampleTile& s = *input.samples;
    for (int c = 0; c < 3; ++c) {
        const Real* hides =
            input.layout.seen ? outputRow(input, w, *input.layout.seen, c) : opacity.values[input.coloured ? c : 0];
        Real* to = outputRow(input, w, *input.layout.depth, c);
        forSamples([&](int k) HWY_ATTR {
            const auto depth = hn::MulAdd(load(s.u, k), constant(s.depthU),
                                          hn::MulAdd(load(s.v, k), constant(s.depthV), constant(s.depth)));
            hn::Store(hn::Mul(depth, load(hides, k)), d, to + k);
        });
    }
}

// Motion of the samples times their opacities.
HWY_ATTR void fillMotion(const ShadeInput& input, const Rows& opacity, Work& w) {
    const DF d;
    for (int c = 0; c < 2; ++c) {
        const Real* hides = opacity.values[input.coloured ? c : 0];
        Real* to = outputRow(input, w, *input.layout.motion, c);
        forSamples([&](int k) HWY_ATTR { hn::Store(hn::Mul(load(input.motion[c], k), load(hides, k)), d, to + k); });
    }
}

// Adds the beauty's parts to the beauty.
HWY_ATTR void addUp(const ShadeInput& input, Work& w) {
    const DF d;
    for (int p = 1; p < input.layout.beautyParts; ++p)
        for (int c = 0; c < 3; ++c) {
            const Real* from = outputRow(input, w, p, c);
            Real* to = w.beauty.values[c];
            forSamples([&](int k) HWY_ATTR { hn::Store(hn::Add(load(to, k), load(from, k)), d, to + k); });
        }
}

HWY_ATTR void writeOutputs(const ShadeInput& input, Work& w, Real* out) {
    const DF d;
    const OutputLayout& layout = input.layout;
    Rows& opacity = w.light;  // no longer needed
    for (int c = 0; c < (input.coloured ? 3 : 1); ++c)
        forSamples([&](int k)
                       HWY_ATTR { hn::Store(oneMinusExp(load(w.tauEye.values[c], k)), d, opacity.values[c] + k); });
    if (layout.beauty) addUp(input, w);
    if (layout.seen) fillSeen(input, opacity, w);
    if (layout.depth) fillDepth(input, opacity, w);
    if (layout.motion) fillMotion(input, opacity, w);
    const int stride = layout.floats();
    for (int p = layout.beauty ? 0 : 1; p < layout.outputs; ++p) {
        Real* quad = out + 4 * layout.quadOf(p);
        const Real* const rows[3] = {outputRow(input, w, p, 0), outputRow(input, w, p, 1), outputRow(input, w, p, 2)};
        for (int k = 0; k < kTileSize; ++k, quad += stride) {
            for (int c = 0; c < 3; ++c) quad[c] = rows[c][k];
            quad[3] = input.coloured ? 0 : -opacity.values[0][k];
        }
    }
    if (!layout.coloured) return;
    Real* quad = out + 4 * layout.outputQuads();
    for (int k = 0; k < kTileSize; ++k, quad += stride) {
        const Real alpha[3] = {opacity.values[0][k], opacity.values[1][k], opacity.values[2][k]};
        for (int c = 0; c < 3; ++c) quad[c] = -alpha[c];
        quad[3] = -std::min({alpha[0], alpha[1], alpha[2]});
    }
}

HWY_ATTR ShadeWork shadeTileOnTarget(const ShadeInput& input, Real* out) {
    Work w;
    enterSheet(input, w);
    for (std::size_t i = 0; i < input.lights.size(); ++i) addLight(input, i, w);
    addSources(input, w);
    if (input.layout.beautyAlone())
        writeBeauty(w, out);
    else
        writeOutputs(input, w, out);
    w.done.exponentials += static_cast<std::uint64_t>((input.coloured ? 3 : 1) * kTileSize);
    return w.done;
}

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scrim {

HWY_EXPORT(shadeTileOnTarget);

SheetSurface surfaceOf(const Classified& look) {
    SheetSurface surface{};
    // What is around is part of the light that has scattered before.
    surface.ambient = static_cast<Real>(look.scatters ? 0 : look.ambient);
    surface.diffuse = static_cast<Real>(look.diffuse);
    surface.specular = static_cast<Real>(look.specular);
    surface.exponent = static_cast<Real>(look.exponent);
    surface.twoSided = look.twoSided;
    for (int c = 0; c < 3; ++c) surface.albedo[c] = static_cast<Real>(look.albedo[c]);
    return surface;
}

ShadeWork shadeTile(const ShadeInput& input, Real* out) {
    return SCRIM_ON_TARGET(input.simd, shadeTileOnTarget)(input, out);
}

}  // namespace scrim
#endif
