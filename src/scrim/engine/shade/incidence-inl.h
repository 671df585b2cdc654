// SPDX-License-Identifier: Apache-2.0
// Internal, one a SIMD target (Highway's way): where a light stands and shines, as seen from the
// samples of a tile. What a light does not need (distance, cone, window) is a pass that is not run.
#if defined(SCRIM_SHADE_INCIDENCE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SCRIM_SHADE_INCIDENCE_INL_H_
#undef SCRIM_SHADE_INCIDENCE_INL_H_
#else
#define SCRIM_SHADE_INCIDENCE_INL_H_
#endif

#include <scrim/engine/shade/shade_tile.h>

#include <scrim/engine/shade/vector_math-inl.h>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

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

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
