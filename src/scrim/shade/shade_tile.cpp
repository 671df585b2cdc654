// SPDX-License-Identifier: Apache-2.0
#include <scrim/shade/shade_tile.h>

#include <type_traits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "scrim/shade/shade_tile.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include <hwy/contrib/math/math-inl.h>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using DF = hn::CappedTag<float, kTileEdge>;
using VF = hn::Vec<DF>;

HWY_ATTR HWY_INLINE VF constant(float value) {
    return hn::Set(DF(), value);
}
HWY_ATTR HWY_INLINE VF load(const float* from, int k) {
    return hn::Load(DF(), from + k);
}

// Calls body(k) for each vector of samples.
template <class Body>
HWY_ATTR HWY_INLINE void forSamples(const Body& body) {
    for (int k = 0; k < kTileSize; k += static_cast<int>(hn::Lanes(DF()))) body(k);
}

// 1 - e^-t for t >= 0, to rounding also where t is small. Past 80 it is 1: the library's exponential is only
// good down to where floats become denormal.
HWY_ATTR HWY_INLINE VF oneMinusExp(VF t) {
    return hn::Neg(hn::Expm1(DF(), hn::Neg(hn::Min(t, constant(80.0f)))));
}

// e^-t for t >= 0, 0 past the smallest normal float.
HWY_ATTR HWY_INLINE VF expMinus(VF t) {
    const DF d;
    return hn::IfThenElseZero(hn::Lt(t, constant(87.0f)), hn::Exp(d, hn::Neg(hn::Min(t, constant(87.0f)))));
}

// (1 - e^-t) / t, see sheet_integral.h. 1e-20 stands for 0: there the quotient's rounding is still exact.
HWY_ATTR HWY_INLINE VF psi(VF t) {
    const auto safe = hn::Max(t, constant(1e-20f));
    return hn::Div(oneMinusExp(safe), safe);
}

// How one light meets the samples of a tile.
struct Incidence {
    alignas(64) float a[kTileSize];  // slopes of its rays
    alignas(64) float b[kTileSize];
    alignas(64) float slant[kTileSize];       // 1 / cos of its angle to w
    alignas(64) float irradiance[kTileSize];  // before attenuation, relative to intensity
    alignas(64) float tint[3 * kTileSize];    // by the light's slide, if it has one
};

HWY_ATTR void meetDistant(const SheetLight& light, Incidence& in) {
    const DF d;
    const auto a = constant(light.slopeA), b = constant(light.slopeB);
    const auto slant = hn::Sqrt(hn::MulAdd(a, a, hn::MulAdd(b, b, constant(1))));
    forSamples([&](int k) HWY_ATTR {
        hn::Store(a, d, in.a + k);
        hn::Store(b, d, in.b + k);
        hn::Store(slant, d, in.slant + k);
        hn::Store(constant(1), d, in.irradiance + k);
    });
}

// Near a light 1/r^2 changes within a sheet: its mean over the eye's segment is taken at the two points of Gauss'
// quadrature. Below the light's radius it stays what it is there.
HWY_ATTR HWY_INLINE VF meanDecay(const ShadeInput& input, const SheetLight& light, VF a, VF b, VF slant2, int k) {
    const auto z = constant(light.distanceW), gauss = constant(0.288675135f * input.thickness);
    const auto ea = load(input.samples->eyeA, k), eb = load(input.samples->eyeB, k);
    // |z (a, b, 1) +- g (ea, eb, 1)|^2
    const auto cross = hn::Mul(hn::Mul(z, gauss), hn::MulAdd(a, ea, hn::MulAdd(b, eb, constant(1))));
    const auto eye2 = hn::Mul(hn::Mul(gauss, gauss), hn::MulAdd(ea, ea, hn::MulAdd(eb, eb, constant(1))));
    const auto middle = hn::MulAdd(hn::Mul(z, z), slant2, eye2);
    const auto least = constant(light.radius2);
    const auto far = hn::Max(hn::MulAdd(constant(2), cross, middle), least);
    const auto near = hn::Max(hn::NegMulAdd(constant(2), cross, middle), least);
    return hn::Mul(constant(0.5f), hn::Add(hn::Div(constant(1), far), hn::Div(constant(1), near)));
}

HWY_ATTR void meetPoint(const ShadeInput& input, const SheetLight& light, Incidence& in) {
    const DF d;
    const auto scale = constant(input.texel / light.distanceW);
    forSamples([&](int k) HWY_ATTR {
        const auto a = hn::Mul(hn::Sub(load(input.samples->u, k), constant(light.texelU)), scale);
        const auto b = hn::Mul(hn::Sub(load(input.samples->v, k), constant(light.texelV)), scale);
        const auto slant2 = hn::MulAdd(a, a, hn::MulAdd(b, b, constant(1)));
        hn::Store(a, d, in.a + k);
        hn::Store(b, d, in.b + k);
        hn::Store(hn::Sqrt(slant2), d, in.slant + k);
        hn::Store(light.decay ? meanDecay(input, light, a, b, slant2, k) : constant(1), d, in.irradiance + k);
    });
}

// A spot's cone: smooth between the cosines of its outer and inner angle.
HWY_ATTR void limitToCone(const SheetLight& light, Incidence& in) {
    const DF d;
    const auto outer = constant(light.cosOuter);
    const auto inverse = constant(1 / (light.cosInner - light.cosOuter));
    forSamples([&](int k) HWY_ATTR {
        const auto along = hn::MulAdd(load(in.a, k), constant(light.axisU),
                                      hn::MulAdd(load(in.b, k), constant(light.axisV), constant(light.axisW)));
        const auto cosine = hn::Div(along, load(in.slant, k));
        auto t = hn::Mul(hn::Sub(cosine, outer), inverse);
        t = hn::Min(hn::Max(t, constant(0)), constant(1));
        const auto smooth = hn::Mul(hn::Mul(t, t), hn::NegMulAdd(constant(2), t, constant(3)));
        hn::Store(hn::Mul(load(in.irradiance, k), smooth), d, in.irradiance + k);
    });
}

// This part's share of a light that is cut into overlapping windows; the shares of a direction sum to 1.
HWY_ATTR void limitToWindow(const SheetLight& light, Incidence& in) {
    const DF d;
    const auto edge = constant(light.windowCos);
    forSamples([&](int k) HWY_ATTR {
        auto own = constant(0), sum = constant(0);
        for (std::size_t i = 0; i < light.windows->size(); ++i) {
            const Vec3& axis = (*light.windows)[i];
            const auto along = hn::MulAdd(
                load(in.a, k), constant(static_cast<float>(axis.x)),
                hn::MulAdd(load(in.b, k), constant(static_cast<float>(axis.y)), constant(static_cast<float>(axis.z))));
            auto t = hn::Max(hn::Sub(hn::Div(along, load(in.slant, k)), edge), constant(0));
            t = hn::Mul(t, t);
            sum = hn::Add(sum, t);
            if (static_cast<int>(i) == light.window) own = t;
        }
        const auto share = hn::Div(own, hn::Max(sum, constant(1e-20f)));
        hn::Store(hn::Mul(load(in.irradiance, k), share), d, in.irradiance + k);
    });
}

// Radiance that one light adds per unit of intensity, scattering coefficient and phase function.
template <bool kShadowed, bool kSameSide>
HWY_ATTR void transmit(const ShadeInput& input, const Incidence& in, [[maybe_unused]] float pathScale,
                       const float* tauIn, const float* tauEye, const float* pathEye, float* out) {
    const DF d;
    forSamples([&](int k) HWY_ATTR {
        const auto te = load(tauEye, k);
        VF light = psi(te);
        if constexpr (kShadowed) {
            const auto tl = hn::Mul(load(input.extinction, k), hn::Mul(load(in.slant, k), constant(pathScale)));
            const auto entry = load(tauIn, k);
            if constexpr (kSameSide)
                light = hn::Mul(expMinus(entry), psi(hn::Add(te, tl)));
            else
                light = hn::Mul(expMinus(hn::Add(entry, hn::Min(te, tl))), psi(hn::AbsDiff(te, tl)));
        }
        hn::Store(hn::Mul(hn::Mul(light, load(in.irradiance, k)), load(pathEye, k)), d, out + k);
    });
}

// Henyey-Greenstein for light that leaves towards the eye, against the direction of the eye's ray.
HWY_ATTR HWY_INLINE VF henyeyGreenstein(const ShadeInput& input, const Incidence& in, const float* slantEye, float g,
                                        int k) {
    const auto dot = hn::MulAdd(load(in.a, k), load(input.samples->eyeA, k),
                                hn::MulAdd(load(in.b, k), load(input.samples->eyeB, k), constant(1)));
    auto cosine = hn::Div(dot, hn::Mul(load(in.slant, k), load(slantEye, k)));
    if (input.sameSide) cosine = hn::Neg(cosine);
    const auto x = hn::NegMulAdd(constant(2 * g), cosine, constant(1 + g * g));
    return hn::Div(constant((1 - g * g) * 0.0795774715f), hn::Mul(x, hn::Sqrt(x)));
}

constexpr float kInverseFourPi = 0.0795774715f;

struct Work {
    alignas(64) float slantEye[kTileSize];
    alignas(64) float pathEye[kTileSize];
    alignas(64) float tauEye[kTileSize];
    alignas(64) float light[kTileSize];
    alignas(64) float rgb[3][kTileSize];
    Incidence in;
};

// `kTinted`: the light has a slide (ZC02 eq. 9: its intensity is a vector that varies from place to place).
template <bool kTinted>
HWY_ATTR void addScattered(const ShadeInput& input, const SheetLight& light, const SheetMedium& medium, Work& w) {
    const DF d;
    const auto r = constant(light.intensity[0] * medium.albedo[0]);
    const auto g = constant(light.intensity[1] * medium.albedo[1]);
    const auto b = constant(light.intensity[2] * medium.albedo[2]);
    const auto add = [&](int k, VF phase) HWY_ATTR {
        const auto amount = hn::Mul(hn::Mul(load(medium.extinction, k), load(w.light, k)), phase);
        const auto tinted = [&](int c) HWY_ATTR {
            return kTinted ? hn::Mul(amount, load(w.in.tint + c * kTileSize, k)) : amount;
        };
        hn::Store(hn::MulAdd(tinted(0), r, load(w.rgb[0], k)), d, w.rgb[0] + k);
        hn::Store(hn::MulAdd(tinted(1), g, load(w.rgb[1], k)), d, w.rgb[1] + k);
        hn::Store(hn::MulAdd(tinted(2), b, load(w.rgb[2], k)), d, w.rgb[2] + k);
    };
    if (medium.g == 0)
        forSamples([&](int k) HWY_ATTR { add(k, constant(kInverseFourPi)); });
    else
        forSamples([&](int k) HWY_ATTR { add(k, henyeyGreenstein(input, w.in, w.slantEye, medium.g, k)); });
}

// x^exponent for x in [0, 1]; 0 at 0.
HWY_ATTR HWY_INLINE VF power(VF x, float exponent) {
    const DF d;
    const auto safe = hn::Max(x, constant(1e-30f));
    return hn::IfThenElseZero(hn::Gt(x, constant(1e-30f)),
                              expMinus(hn::Mul(hn::Neg(hn::Log(d, safe)), constant(exponent))));
}

// What a classified volume reflects after Phong (ZC02 eq. 6, 8 and 9, and phong() in classified.h). A white diffuse
// surface that faces the light reflects k_d E / pi.
template <bool kTinted>
HWY_ATTR void addReflected(const ShadeInput& input, const SheetLight& light, const SheetSurface& surface, Work& w) {
    const DF d;
    constexpr float kInversePi = 0.318309886f;
    const float eyeSign = input.sameSide ? -1.0f : 1.0f;  // from the sample to the eye is -d
    forSamples([&](int k) HWY_ATTR {
        const auto a = load(w.in.a, k), b = load(w.in.b, k), slant = load(w.in.slant, k);
        const auto nx = load(surface.normal[0], k), ny = load(surface.normal[1], k), nz = load(surface.normal[2], k);
        // The light travels along (a, b, 1) / slant, the way to it is the opposite.
        const auto cosine = hn::Neg(hn::Div(hn::MulAdd(nx, a, hn::MulAdd(ny, b, nz)), slant));
        const auto facing = surface.twoSided ? hn::Abs(cosine) : hn::Max(cosine, constant(0));
        const auto weight = load(surface.weight, k);
        const auto diffuse = hn::Mul(constant(surface.diffuse * kInversePi),
                                     hn::MulAdd(weight, hn::Sub(facing, constant(1)), constant(1)));
        const auto amount = load(w.light, k);

        // Towards the eye, and how far the mirrored light R = 2 (N.L) N - L points there.
        const auto ea = load(input.samples->eyeA, k), eb = load(input.samples->eyeB, k);
        const auto normalEye = hn::MulAdd(nx, ea, hn::MulAdd(ny, eb, nz));
        const auto lightEye = hn::Neg(hn::Div(hn::MulAdd(a, ea, hn::MulAdd(b, eb, constant(1))), slant));
        const auto mirrored = hn::Mul(hn::Div(constant(eyeSign), load(w.slantEye, k)),
                                      hn::MulSub(hn::Mul(constant(2), cosine), normalEye, lightEye));
        const auto shine =
            hn::IfThenElseZero(hn::Gt(facing, constant(0)), power(hn::Max(mirrored, constant(0)), surface.exponent));
        const auto specular = hn::Mul(hn::Mul(constant(surface.specular * kInversePi), hn::Mul(shine, weight)),
                                      load(surface.extinction, k));
        for (int c = 0; c < 3; ++c) {
            const auto source = hn::MulAdd(load(surface.emission[c], k), diffuse, specular);
            auto radiance = hn::Mul(hn::Mul(source, amount), constant(light.intensity[c]));
            if constexpr (kTinted) radiance = hn::Mul(radiance, load(w.in.tint + c * kTileSize, k));
            hn::Store(hn::Add(load(w.rgb[c], k), radiance), d, w.rgb[c] + k);
        }
    });
}

HWY_ATTR void addLight(const ShadeInput& input, int index, Work& w) {
    const SheetLight& light = input.lights[index];
    if (light.slide.image) {
        const SampleTile& s = *input.samples;
        const SlideSamples samples{s.u, s.v, s.eyeA, s.eyeB, input.thickness / input.texel, s.spacing};
        if (!tintTile(light.slide, samples, w.in.tint)) return;  // outside of the picture
    }
    if (light.distant)
        meetDistant(light, w.in);
    else
        meetPoint(input, light, w.in);
    if (light.spot) limitToCone(light, w.in);
    if (light.windows) limitToWindow(light, w.in);

    const float* tauIn = input.tauIn + index * kTileSize;
    const float path = light.withinSheet ? input.thickness : 0.0f;
    if (!light.shadowed)
        transmit<false, true>(input, w.in, path, tauIn, w.tauEye, w.pathEye, w.light);
    else if (input.sameSide)
        transmit<true, true>(input, w.in, path, tauIn, w.tauEye, w.pathEye, w.light);
    else
        transmit<true, false>(input, w.in, path, tauIn, w.tauEye, w.pathEye, w.light);
    const auto add = [&](auto tinted) HWY_ATTR {
        constexpr bool kTinted = decltype(tinted)::value;
        for (int m = 0; m < input.mediumCount; ++m) addScattered<kTinted>(input, light, input.media[m], w);
        for (int s = 0; s < input.surfaceCount; ++s) addReflected<kTinted>(input, light, input.surfaces[s], w);
    };
    if (light.slide.image)
        add(std::true_type());
    else
        add(std::false_type());
}

HWY_ATTR void addUnshadowed(const float* extinction, float radiance, int channel, Work& w) {
    const DF d;
    if (radiance == 0) return;
    forSamples([&](int k) HWY_ATTR {
        const auto part = hn::Mul(hn::Mul(load(extinction, k), load(w.pathEye, k)), psi(load(w.tauEye, k)));
        hn::Store(hn::MulAdd(part, constant(radiance), load(w.rgb[channel], k)), d, w.rgb[channel] + k);
    });
}

HWY_ATTR void addAmbient(const ShadeInput& input, Work& w) {
    for (int c = 0; c < 3; ++c) {
        for (int m = 0; m < input.mediumCount; ++m)
            addUnshadowed(input.media[m].extinction, input.ambient[c] * input.media[m].albedo[c], c, w);
        for (int s = 0; s < input.surfaceCount; ++s)
            addUnshadowed(input.surfaces[s].emission[c], input.ambient[c] * input.surfaces[s].ambient, c, w);
    }
}

HWY_ATTR void shadeTileOnTarget(const ShadeInput& input, float* out) {
    const DF d;
    Work w;
    forSamples([&](int k) HWY_ATTR {
        const auto a = load(input.samples->eyeA, k), b = load(input.samples->eyeB, k);
        const auto slant = hn::Sqrt(hn::MulAdd(a, a, hn::MulAdd(b, b, constant(1))));
        const auto path = hn::Mul(slant, constant(input.thickness));
        hn::Store(slant, d, w.slantEye + k);
        hn::Store(path, d, w.pathEye + k);
        hn::Store(hn::Mul(path, load(input.extinction, k)), d, w.tauEye + k);
        for (auto& channel : w.rgb) hn::Store(constant(0), d, channel + k);
    });
    for (int i = 0; i < input.lightCount; ++i) addLight(input, i, w);
    if (input.ambient[0] != 0 || input.ambient[1] != 0 || input.ambient[2] != 0) addAmbient(input, w);
    forSamples([&](int k) HWY_ATTR {
        hn::StoreInterleaved4(load(w.rgb[0], k), load(w.rgb[1], k), load(w.rgb[2], k),
                              hn::Neg(oneMinusExp(load(w.tauEye, k))), d, out + 4 * k);
    });
}

HWY_ATTR void texelSamplesOnTarget(const Sheets& sheets, const EyeSlopes& eye, double middle, int texelX, int texelY,
                                   SampleTile& samples) {
    const DF d;
    // Rays from a point: slope = offset / distance along w. Within half a sheet of the eye slopes grow without
    // bound; texels there are seen by no ray that has crossed a sheet, and must only stay finite.
    double away = middle - eye.tsEye.z;
    if (away > -0.25 && away < 0.25) away = away < 0 ? -0.25 : 0.25;
    const double scale = sheets.texel / (sheets.thickness * away);
    const auto step = constant(static_cast<float>(scale));
    const float a0 = static_cast<float>((texelX - eye.tsEye.x) * scale);
    for (int j = 0; j < kTileEdge; ++j) {
        const float b = static_cast<float>(eye.parallel ? eye.b : (texelY + j - eye.tsEye.y) * scale);
        for (int i = 0; i < kTileEdge; i += static_cast<int>(hn::Lanes(d))) {
            const int k = j * kTileEdge + i;
            const auto column = hn::Iota(d, static_cast<float>(i));
            hn::Store(hn::Add(column, constant(static_cast<float>(texelX))), d, samples.u + k);
            hn::Store(constant(static_cast<float>(texelY + j)), d, samples.v + k);
            hn::Store(eye.parallel ? constant(static_cast<float>(eye.a)) : hn::MulAdd(column, step, constant(a0)), d,
                      samples.eyeA + k);
            hn::Store(constant(b), d, samples.eyeB + k);
        }
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scrim {

HWY_EXPORT(shadeTileOnTarget);
HWY_EXPORT(texelSamplesOnTarget);

void shadeTile(const ShadeInput& input, float* out) {
    HWY_DYNAMIC_DISPATCH(shadeTileOnTarget)(input, out);
}

void texelSamples(const Sheets& sheets, const EyeSlopes& eye, double middle, int texelX, int texelY,
                  SampleTile& samples) {
    HWY_DYNAMIC_DISPATCH(texelSamplesOnTarget)(sheets, eye, middle, texelX, texelY, samples);
}

}  // namespace scrim
#endif
