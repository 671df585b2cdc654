// SPDX-License-Identifier: Apache-2.0
// Internal, compiled once for each instruction set (Highway's method): the direction and strength
// of a light at the samples of a tile, and how volumes scatter or reflect it. What a light does not
// need (distance, cone, window) is a pass that is not run.
#if defined(SCRIM_SHADE_TILE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SCRIM_SHADE_TILE_INL_H_
#undef SCRIM_SHADE_TILE_INL_H_
#else
#define SCRIM_SHADE_TILE_INL_H_
#endif

#include <scrim/base/real.h>
#include <scrim/engine/shade/lamp_on_path.h>
#include <scrim/engine/shade/shade_tile.h>

#include <scrim/engine/simd-inl.h>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

// One light at the samples of a tile.
struct Incidence {
    alignas(64) Real a[kTileSize];  // slopes of its rays
    alignas(64) Real b[kTileSize];
    alignas(64) Real slant[kTileSize];       // 1 / cos of its angle to w
    alignas(64) Real irradiance[kTileSize];  // before attenuation, relative to intensity
    alignas(64) Real tint[3 * kTileSize];    // factor by the light's slide, if it has one
    // The samples along whose paths the light turns (see LampOnPath).
    int turning = 0;
    int turns[kTileSize];
};

HWY_ATTR void meetDistant(const DistantOnSheet& light, Incidence& in) {
    const DF d;
    in.turning = 0;
    const auto a = constant(light.slopeA), b = constant(light.slopeB);
    const auto slant = hn::Sqrt(hn::MulAdd(a, a, hn::MulAdd(b, b, constant(1))));
    forSamples([&](int k) HWY_ATTR {
        hn::Store(a, d, in.a + k);
        hn::Store(b, d, in.b + k);
        hn::Store(slant, d, in.slant + k);
        hn::Store(constant(1), d, in.irradiance + k);
    });
}

// Close to a light 1/r^2 changes within a sheet, so its mean over the eye's segment is taken at the
// two points of Gauss quadrature. It is constant within the light's radius.
HWY_ATTR HWY_INLINE VF meanDecay(const ShadeInput& input, const NearOnSheet& light, VF a, VF b, VF slant2, int k) {
    const auto z = constant(light.distanceW), gauss = constant(Real(0.28867513459481287) * input.thickness);
    const auto ea = load(input.samples->eyeA, k), eb = load(input.samples->eyeB, k);
    // |z (a, b, 1) +- g (ea, eb, 1)|^2
    const auto cross = hn::Mul(hn::Mul(z, gauss), hn::MulAdd(a, ea, hn::MulAdd(b, eb, constant(1))));
    const auto eye2 = hn::Mul(hn::Mul(gauss, gauss), hn::MulAdd(ea, ea, hn::MulAdd(eb, eb, constant(1))));
    const auto middle = hn::MulAdd(hn::Mul(z, z), slant2, eye2);
    const auto least = constant(light.radius2);
    const auto far = hn::Max(hn::MulAdd(constant(2), cross, middle), least);
    const auto near = hn::Max(hn::NegMulAdd(constant(2), cross, middle), least);
    return hn::Mul(constant(0.5), hn::Add(hn::Div(constant(1), far), hn::Div(constant(1), near)));
}

HWY_ATTR void meetPoint(const ShadeInput& input, const NearOnSheet& light, Incidence& in) {
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

// The cosine between the light's ray and an axis.
HWY_ATTR HWY_INLINE VF cosineTo(Real axisU, Real axisV, Real axisW, const Incidence& in, int k) {
    const auto along =
        hn::MulAdd(load(in.a, k), constant(axisU), hn::MulAdd(load(in.b, k), constant(axisV), constant(axisW)));
    return hn::Div(along, load(in.slant, k));
}

// Applies a spot's cone: smooth between the cosines of its outer and inner angle.
HWY_ATTR void limitToCone(const NearOnSheet& light, const NearOnSheet::Cone& cone, Incidence& in) {
    const DF d;
    const auto outer = constant(cone.cosOuter);
    const auto inverse = constant(1 / (cone.cosInner - cone.cosOuter));
    forSamples([&](int k) HWY_ATTR {
        const auto cosine = cosineTo(light.axisU, light.axisV, light.axisW, in, k);
        auto t = hn::Mul(hn::Sub(cosine, outer), inverse);
        t = hn::Min(hn::Max(t, constant(0)), constant(1));
        const auto smooth = hn::Mul(hn::Mul(t, t), hn::NegMulAdd(constant(2), t, constant(3)));
        hn::Store(hn::Mul(load(in.irradiance, k), smooth), d, in.irradiance + k);
    });
}

// Applies Lambert's cosine, for an element of a surface, and its spread.
HWY_ATTR void limitToFront(const NearOnSheet& light, const NearOnSheet::Face& face, Incidence& in) {
    const DF d;
    if (face.spreadScale > 0) {
        const auto tangent = constant(face.spreadTangent), scale = constant(face.spreadScale);
        forSamples([&](int k) HWY_ATTR {
            const auto cosine = hn::Max(cosineTo(light.axisU, light.axisV, light.axisW, in, k), constant(0));
            const auto sine = hn::Sqrt(hn::Max(hn::NegMulAdd(cosine, cosine, constant(1)), constant(0)));
            // cosine times (tangent - sine / cosine)
            const auto part = hn::Mul(hn::Max(hn::MulSub(cosine, tangent, sine), constant(0)), scale);
            hn::Store(hn::Mul(load(in.irradiance, k), part), d, in.irradiance + k);
        });
        return;
    }
    forSamples([&](int k) HWY_ATTR {
        const auto cosine = hn::Max(cosineTo(light.axisU, light.axisV, light.axisW, in, k), constant(0));
        hn::Store(hn::Mul(load(in.irradiance, k), cosine), d, in.irradiance + k);
    });
}

// Applies the profile of a luminaire: LightProfile::at for all samples.
HWY_ATTR void applyProfile(const NearOnSheet::Profile& of, Incidence& in) {
    const DF d;
    const LightProfile& profile = *of.table;
    constexpr Real kPi = Real(3.14159265358979324), kRounding = Real(1e-5);
    const auto toRadians = [](double degrees) { return static_cast<Real>(degrees) * (kPi / 180); };
    const auto first = constant(toRadians(profile.first()) - kRounding);
    const auto last = constant(toRadians(profile.last()) + kRounding);
    const auto perRow = constant(static_cast<Real>(profile.rows() - 1) / kPi);
    const auto perColumn = constant(static_cast<Real>(profile.columns() - 1) / (2 * kPi));
    alignas(64) Real row[kTileSize], column[kTileSize];
    forSamples([&](int k) HWY_ATTR {
        const auto along = [&](int i) HWY_ATTR {
            const Vec3& axis = of.frame[i];
            return cosineTo(static_cast<Real>(axis.x), static_cast<Real>(axis.y), static_cast<Real>(axis.z), in, k);
        };
        const auto angle = [&](VF cosine)
                               HWY_ATTR { return hn::Acos(d, hn::Min(hn::Max(cosine, constant(-1)), constant(1))); };
        const auto x = along(0), y = along(1), vertical = angle(along(2));
        const auto length = hn::Sqrt(hn::MulAdd(x, x, hn::MulAdd(y, y, constant(Real(1e-30)))));
        const auto turn = angle(hn::Div(hn::Neg(y), length));
        const auto horizontal = hn::IfThenElse(hn::Lt(x, constant(0)), hn::Sub(constant(2 * kPi), turn), turn);
        hn::Store(hn::Mul(vertical, perRow), d, row + k);
        hn::Store(hn::Mul(horizontal, perColumn), d, column + k);
        const auto sends = hn::And(hn::Ge(vertical, first), hn::Le(vertical, last));
        hn::Store(hn::IfThenElseZero(sends, load(in.irradiance, k)), d, in.irradiance + k);
    });
    for (int k = 0; k < kTileSize; ++k) {
        if (in.irradiance[k] == 0) continue;
        const int i = std::min(static_cast<int>(row[k]), profile.rows() - 2);
        const int j = std::min(static_cast<int>(column[k]), profile.columns() - 2);
        const float* corner = profile.values() + std::ptrdiff_t(i) * profile.columns() + j;
        const Real right = column[k] - static_cast<Real>(j), down = row[k] - static_cast<Real>(i);
        const auto across = [&](const float* p) { return p[0] + right * (p[1] - p[0]); };
        const Real above = across(corner);
        in.irradiance[k] *= above + down * (across(corner + profile.columns()) - above);
    }
}

// Applies this part's share of a light that is divided into overlapping windows; the shares in a direction sum to 1.
HWY_ATTR void limitToWindow(const NearOnSheet::Window& window, Incidence& in) {
    const DF d;
    const auto edge = constant(window.cosEdge);
    forSamples([&](int k) HWY_ATTR {
        auto own = constant(0), sum = constant(0);
        for (std::size_t i = 0; i < window.axes->size(); ++i) {
            const Vec3& axis = (*window.axes)[i];
            const auto cosine =
                cosineTo(static_cast<Real>(axis.x), static_cast<Real>(axis.y), static_cast<Real>(axis.z), in, k);
            auto t = hn::Max(hn::Sub(cosine, edge), constant(0));
            t = hn::Mul(t, t);
            sum = hn::Add(sum, t);
            if (static_cast<int>(i) == window.number) own = t;
        }
        const auto share = hn::Div(own, hn::Max(sum, constant(1e-20)));
        hn::Store(hn::Mul(load(in.irradiance, k), share), d, in.irradiance + k);
    });
}

// The sum of all channels at sample k.
HWY_ATTR HWY_INLINE double extinctionAt(const ShadeInput& input, int k) {
    double sum = 0;
    for (int r = 0; r < input.channels; ++r) sum += double(input.extinction[r][k]);
    return sum;
}

// What sample k leaves of a light of the input.
HWY_ATTR LampOnPath::Passage passageAt(const ShadeInput& input, const SheetLight& light, int k) {
    LampOnPath::Passage passage{extinctionAt(input, k), light.shadowed && light.withinSheet, input.sameSide};
    if (!light.shadowed || input.tauOut) return passage;
    const Real* tau = input.tauAtEntry(std::size_t(&light - input.lights.data()));
    for (int r = 0; r < input.channels; ++r) passage.entry += double(tau[r * kTileSize + k]);
    return passage;
}

// Where the light sees much of a path at once, its mean over the path counts. Only what has extinction is asked.
HWY_ATTR void meetAlongPaths(const ShadeInput& input, const SheetLight& light, Incidence& in) {
    const LampOnPath lamp(*light.near(), input.texel, input.thickness);
    if (!lamp.changes(*input.samples)) return;
    for (int k = 0; k < kTileSize; ++k) {
        const LampOnPath::Course course = lamp.courseOf(*input.samples, k);
        if (course == LampOnPath::Course::dark) in.irradiance[k] = 0;
        if (course != LampOnPath::Course::changing) continue;
        const LampOnPath::Passage passage = passageAt(input, light, k);
        if (passage.extinction == 0) continue;
        const LampOnPath::Mean mean = lamp.over(*input.samples, k, passage);
        in.irradiance[k] = static_cast<Real>(mean.irradiance);
        if (mean.irradiance == 0) continue;
        in.turns[in.turning++] = k;
        in.a[k] = static_cast<Real>(mean.a);
        in.b[k] = static_cast<Real>(mean.b);
        in.slant[k] = static_cast<Real>(std::sqrt(1 + mean.a * mean.a + mean.b * mean.b));
    }
}

// The slide's mean over the paths; false where it is black at all of them.
HWY_ATTR bool tintAlongPaths(const ShadeInput& input, const SheetLight& light, Real* tint) {
    const Real toTexels = input.thickness / input.texel;
    bool any = false;
    const auto meets = [&](const SampleTile& part, Real* values) {
        if (tintTile(light.slide, part, toTexels, values))
            any = true;
        else
            std::fill_n(values, 3 * kTileSize, Real(0));
    };
    if (!light.near()) return tintTile(light.slide, *input.samples, toTexels, tint);
    bool wanted[kTileSize];
    for (int k = 0; k < kTileSize; ++k) wanted[k] = extinctionAt(input, k) > 0;
    if (LampOnPath(*light.near(), input.texel, input.thickness).average(*input.samples, wanted, 3, meets, tint))
        return any;
    return tintTile(light.slide, *input.samples, toTexels, tint);
}

// A light that shines from a point, with all that limits it.
HWY_ATTR void meetNear(const ShadeInput& input, const SheetLight& of, Incidence& in) {
    const NearOnSheet& light = *of.near();
    in.turning = 0;
    meetPoint(input, light, in);
    if (light.cone) limitToCone(light, *light.cone, in);
    if (light.profile) applyProfile(*light.profile, in);
    if (light.face) limitToFront(light, *light.face, in);
    meetAlongPaths(input, of, in);
    if (light.window) limitToWindow(*light.window, in);
}

HWY_ATTR void scale(const Real* factors, Real* values) {
    const DF d;
    forSamples([&](int k) HWY_ATTR { hn::Store(hn::Mul(load(factors, k), load(values, k)), d, values + k); });
}

constexpr Real kInverseFourPi = Real(0.07957747154594767);

// A light at the samples of a tile, and the outputs for its response. Rows of channels may be one and the same.
struct Lit {
    const ShadeInput* input;
    const SheetLight* light;
    const Incidence* in;
    const Real* slantEye;
    const Real* amount[3];  // radiance per unit of intensity, scattering coefficient and phase function
    Real* to[3];
    const PhaseOverCaps* caps = nullptr;  // in place of the phase function; null: the light is no part of a wide one
};

// The half angle of a cap as wide as what the light stands for is seen.
HWY_ATTR HWY_INLINE VF halfAngleOf(const Lit& lit, int k) {
    const SheetLight& light = *lit.light;
    if (light.distant() != nullptr) return constant(light.part);
    const NearOnSheet& near = *light.near();
    constexpr Real kInversePi = Real(0.3183098861837907);
    const auto r = hn::Mul(constant(near.distanceW), load(lit.in->slant, k));
    auto solidAngle = hn::Div(constant(light.part * kInversePi), hn::Mul(r, r));
    if (near.face) {
        const auto facing = cosineTo(near.axisU, near.axisV, near.axisW, *lit.in, k);
        solidAngle = hn::Mul(solidAngle, hn::Max(facing, constant(0)));
    }
    return hn::Sqrt(solidAngle);
}

// The cosine between the light's direction of travel and the direction towards the eye, which is
// opposite to the eye's ray.
HWY_ATTR HWY_INLINE VF scatteringCosine(const Lit& lit, int k) {
    const Incidence& in = *lit.in;
    const auto dot = hn::MulAdd(load(in.a, k), load(lit.input->samples->eyeA, k),
                                hn::MulAdd(load(in.b, k), load(lit.input->samples->eyeB, k), constant(1)));
    const auto cosine = hn::Div(dot, hn::Mul(load(in.slant, k), load(lit.slantEye, k)));
    return lit.input->sameSide ? hn::Neg(cosine) : cosine;
}

// Calls add(k, value of the phase function) for all samples, with one loop for each kind of phase function.
template <class Add>
HWY_ATTR HWY_INLINE void withPhase(const Phase& phase, const Lit& lit, const Add& add) {
    if (phase.isotropic()) {
        forSamples([&](int k) HWY_ATTR { add(k, constant(kInverseFourPi)); });
        return;
    }
    if (lit.caps)
        return forSamples(
            [&](int k) HWY_ATTR { add(k, capsAt(DF(), *lit.caps, halfAngleOf(lit, k), scatteringCosine(lit, k))); });
    const Lobe lobe(phase.g, kInverseFourPi), other(phase.g2, kInverseFourPi, phase.alpha);
    const auto blend = constant(static_cast<Real>(phase.blend));
    const auto directed = constant(Real(0.75) * kInverseFourPi * static_cast<Real>(phase.strength));
    const auto even = constant(kInverseFourPi * static_cast<Real>(1 - 0.25 * phase.strength));
    switch (phase.type) {
        case PhaseType::henyeyGreenstein:
            return forSamples([&](int k) HWY_ATTR { add(k, henyeyGreenstein(DF(), scatteringCosine(lit, k), lobe)); });
        case PhaseType::twoLobe:
            return forSamples([&](int k) HWY_ATTR {
                const auto cosine = scatteringCosine(lit, k);
                const auto first = henyeyGreenstein(DF(), cosine, lobe);
                add(k, hn::MulAdd(blend, hn::Sub(drainePhase(DF(), cosine, other), first), first));
            });
        case PhaseType::rayleigh:
            return forSamples([&](int k) HWY_ATTR {
                const auto cosine = scatteringCosine(lit, k);
                add(k, hn::MulAdd(directed, hn::Mul(cosine, cosine), even));
            });
    }
}

// As withPhase, with the mean of the phase function over paths along which the light turns.
template <class Add>
HWY_ATTR HWY_INLINE void withMeanPhase(const Phase& phase, const Lit& lit, const Add& add) {
    const DF d;
    const ShadeInput& input = *lit.input;
    alignas(64) Real values[kTileSize];
    withPhase(phase, lit, [&](int k, VF value) HWY_ATTR { hn::Store(value, d, values + k); });
    const LampOnPath lamp(*lit.light->near(), input.texel, input.thickness);
    for (int i = 0; i < lit.in->turning; ++i) {
        const int k = lit.in->turns[i];
        values[k] = static_cast<Real>(lamp.phaseOver(*input.samples, k, passageAt(input, *lit.light, k), phase));
    }
    forSamples([&](int k) HWY_ATTR { add(k, load(values, k)); });
}

// Adds scattered light. `kTinted`: the light has a slide (ZC02 eq. 9: its intensity is a vector
// that varies from place to place). `kPerChannel`: channels differ by more than a factor, because
// extinction is coloured or the albedo is a grid.
template <bool kTinted, bool kPerChannel>
HWY_ATTR void addScattered(const Lit& lit, const SheetMedium& medium, const Phase& phase, Real part) {
    const DF d;
    Real weight[3];
    for (int c = 0; c < 3; ++c) weight[c] = part * lit.light->intensity[c] * medium.albedo[c];
    const auto addPhase = [&](int k, VF value) HWY_ATTR {
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
    };
    if (lit.in->turning == 0 || phase.isotropic() || lit.caps)
        withPhase(phase, lit, addPhase);
    else
        withMeanPhase(phase, lit, addPhase);
}

// x^exponent for x in [0, 1]; 0 at 0.
HWY_ATTR HWY_INLINE VF power(VF x, Real exponent) {
    const DF d;
    const auto safe = hn::Max(x, constant(1e-30));
    return hn::IfThenElseZero(hn::Gt(x, constant(1e-30)),
                              expMinus(hn::Mul(hn::Neg(hn::Log(d, safe)), constant(exponent))));
}

// Adds the light that a classified volume reflects by Phong's model (ZC02 eq. 6, 8 and 9, and
// phong() in classified.h). A white diffuse surface that faces the light reflects k_d E / pi.
template <bool kTinted>
HWY_ATTR void addReflected(const Lit& lit, const SheetSurface& surface) {
    const DF d;
    constexpr Real kInversePi = Real(0.3183098861837907);
    const Incidence& in = *lit.in;
    const SampleTile& samples = *lit.input->samples;
    const Real eyeSign = lit.input->sameSide ? Real(-1) : Real(1);  // the direction from the sample to the eye is -d
    forSamples([&](int k) HWY_ATTR {
        const auto a = load(in.a, k), b = load(in.b, k), slant = load(in.slant, k);
        const auto nx = load(surface.normal[0], k), ny = load(surface.normal[1], k), nz = load(surface.normal[2], k);
        // The light travels along (a, b, 1) / slant; the direction to it is the opposite.
        const auto cosine = hn::Neg(hn::Div(hn::MulAdd(nx, a, hn::MulAdd(ny, b, nz)), slant));
        const auto facing = surface.twoSided ? hn::Abs(cosine) : hn::Max(cosine, constant(0));
        const auto weight = load(surface.weight, k);
        const auto diffuse = hn::Mul(constant(surface.diffuse * kInversePi),
                                     hn::MulAdd(weight, hn::Sub(facing, constant(1)), constant(1)));

        // The direction towards the eye, and its cosine to the mirrored light R = 2 (N.L) N - L.
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
