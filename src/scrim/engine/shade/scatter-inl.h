// SPDX-License-Identifier: Apache-2.0
// Internal, one a SIMD target (Highway's way): what volumes make of the light that reaches the samples of a tile.
#if defined(SCRIM_SHADE_SCATTER_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SCRIM_SHADE_SCATTER_INL_H_
#undef SCRIM_SHADE_SCATTER_INL_H_
#else
#define SCRIM_SHADE_SCATTER_INL_H_
#endif

#include <scrim/engine/shade/incidence-inl.h>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

constexpr float kInverseFourPi = 0.0795774715f;

// A light at the samples of a tile, and where what is made of it goes. Rows of channels may be one and the same.
struct Lit {
    const ShadeInput* input;
    const SheetLight* light;
    const Incidence* in;
    const float* slantEye;
    const float* amount[3];  // radiance per unit of intensity, scattering coefficient and phase function
    float* to[3];
};

// Cosine between the way light travels and the way it leaves towards the eye, against the direction of the eye's ray.
HWY_ATTR HWY_INLINE VF scatteringCosine(const Lit& lit, int k) {
    const Incidence& in = *lit.in;
    const auto dot = hn::MulAdd(load(in.a, k), load(lit.input->samples->eyeA, k),
                                hn::MulAdd(load(in.b, k), load(lit.input->samples->eyeB, k), constant(1)));
    const auto cosine = hn::Div(dot, hn::Mul(load(in.slant, k), load(lit.slantEye, k)));
    return lit.input->sameSide ? hn::Neg(cosine) : cosine;
}

HWY_ATTR HWY_INLINE VF henyeyGreenstein(VF cosine, float g) {
    const auto x = hn::NegMulAdd(constant(2 * g), cosine, constant(1 + g * g));
    return hn::Div(constant((1 - g * g) * kInverseFourPi), hn::Mul(x, hn::Sqrt(x)));
}

// Calls add(k, value of the phase function) for all samples: one loop a kind of phase function.
template <class Add>
HWY_ATTR HWY_INLINE void withPhase(const Phase& phase, const Lit& lit, const Add& add) {
    if (phase.isotropic()) {
        forSamples([&](int k) HWY_ATTR { add(k, constant(kInverseFourPi)); });
        return;
    }
    const auto g = static_cast<float>(phase.g), g2 = static_cast<float>(phase.g2);
    const auto blend = constant(static_cast<float>(phase.blend));
    const auto directed = constant(0.75f * kInverseFourPi * static_cast<float>(phase.strength));
    const auto even = constant(kInverseFourPi * static_cast<float>(1 - 0.25 * phase.strength));
    switch (phase.type) {
        case PhaseType::henyeyGreenstein:
            return forSamples([&](int k) HWY_ATTR { add(k, henyeyGreenstein(scatteringCosine(lit, k), g)); });
        case PhaseType::twoLobe:
            return forSamples([&](int k) HWY_ATTR {
                const auto cosine = scatteringCosine(lit, k);
                const auto first = henyeyGreenstein(cosine, g);
                add(k, hn::MulAdd(blend, hn::Sub(henyeyGreenstein(cosine, g2), first), first));
            });
        case PhaseType::rayleigh:
            return forSamples([&](int k) HWY_ATTR {
                const auto cosine = scatteringCosine(lit, k);
                add(k, hn::MulAdd(directed, hn::Mul(cosine, cosine), even));
            });
    }
}

// `kTinted`: the light has a slide (ZC02 eq. 9: its intensity is a vector that varies from place to place).
// `kPerChannel`: channels differ in more than a factor, because extinction is coloured or the albedo is a grid.
template <bool kTinted, bool kPerChannel>
HWY_ATTR void addScattered(const Lit& lit, const SheetMedium& medium, const Phase& phase, float part) {
    const DF d;
    float weight[3];
    for (int c = 0; c < 3; ++c) weight[c] = part * lit.light->intensity[c] * medium.albedo[c];
    withPhase(phase, lit, [&](int k, VF value) HWY_ATTR {
        const auto scattered = [&](int c)
                                   HWY_ATTR { return hn::Mul(load(medium.scatter[c], k), load(lit.amount[c], k)); };
        const auto shared = hn::Mul(scattered(0), value);
        const auto add = [&](int c) HWY_ATTR {
            auto amount = shared;
            if constexpr (kPerChannel) amount = hn::Mul(scattered(c), value);
            if constexpr (kTinted) amount = hn::Mul(amount, load(lit.in->tint + c * kTileSize, k));
            hn::Store(hn::MulAdd(amount, constant(weight[c]), load(lit.to[c], k)), d, lit.to[c] + k);
        };
        add(0);
        add(1);
        add(2);
    });
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
HWY_ATTR void addReflected(const Lit& lit, const SheetSurface& surface) {
    const DF d;
    constexpr float kInversePi = 0.318309886f;
    const Incidence& in = *lit.in;
    const SampleTile& samples = *lit.input->samples;
    const float eyeSign = lit.input->sameSide ? -1.0f : 1.0f;  // from the sample to the eye is -d
    forSamples([&](int k) HWY_ATTR {
        const auto a = load(in.a, k), b = load(in.b, k), slant = load(in.slant, k);
        const auto nx = load(surface.normal[0], k), ny = load(surface.normal[1], k), nz = load(surface.normal[2], k);
        // The light travels along (a, b, 1) / slant, the way to it is the opposite.
        const auto cosine = hn::Neg(hn::Div(hn::MulAdd(nx, a, hn::MulAdd(ny, b, nz)), slant));
        const auto facing = surface.twoSided ? hn::Abs(cosine) : hn::Max(cosine, constant(0));
        const auto weight = load(surface.weight, k);
        const auto diffuse = hn::Mul(constant(surface.diffuse * kInversePi),
                                     hn::MulAdd(weight, hn::Sub(facing, constant(1)), constant(1)));

        // Towards the eye, and how far the mirrored light R = 2 (N.L) N - L points there.
        const auto ea = load(samples.eyeA, k), eb = load(samples.eyeB, k);
        const auto normalEye = hn::MulAdd(nx, ea, hn::MulAdd(ny, eb, nz));
        const auto lightEye = hn::Neg(hn::Div(hn::MulAdd(a, ea, hn::MulAdd(b, eb, constant(1))), slant));
        const auto mirrored = hn::Mul(hn::Div(constant(eyeSign), load(lit.slantEye, k)),
                                      hn::MulSub(hn::Mul(constant(2), cosine), normalEye, lightEye));
        const auto shine =
            hn::IfThenElseZero(hn::Gt(facing, constant(0)), power(hn::Max(mirrored, constant(0)), surface.exponent));
        const auto specular = hn::Mul(hn::Mul(constant(surface.specular * kInversePi), hn::Mul(shine, weight)),
                                      load(surface.extinction, k));
        for (int c = 0; c < 3; ++c) {
            const auto source = hn::MulAdd(load(surface.emission[c], k), diffuse, specular);
            auto radiance = hn::Mul(hn::Mul(source, load(lit.amount[c], k)), constant(lit.light->intensity[c]));
            if constexpr (kTinted) radiance = hn::Mul(radiance, load(in.tint + c * kTileSize, k));
            hn::Store(hn::Add(load(lit.to[c], k), radiance), d, lit.to[c] + k);
        }
    });
}

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
