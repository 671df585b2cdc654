// SPDX-License-Identifier: Apache-2.0
#include "smoke.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "smoke.cpp"
#include <hwy/foreach_target.h>
#include "gradient_noise-inl.h"

HWY_BEFORE_NAMESPACE();
namespace noise_source {
namespace HWY_NAMESPACE {

constexpr double kBaseRadius = 0.05;   // radius of the plume at its foot
constexpr double kPlumeSpread = 0.19;  // growth of its radius with height
constexpr double kWander = 0.35;  // slope of its axis as assumed by the first culling test, kept as it has always been
constexpr double kWanderBound = 0.4;  // upper bound of that slope, above kLowest
constexpr double kLowest = -0.75;
constexpr double kHead = 0.76;            // height where its axis ends, in a round head
constexpr double kSmallestRadius = 0.03;  // smallest radius of the plume, also below its foot
constexpr double kBallRadius = 0.32;
constexpr double kSlabRadius = 0.09;
constexpr double kWarpBound = 1.6;     // bound on the length of `displacement`
constexpr double kRounding = 1e-9;     // larger than any rounding error in the proofs that a region is empty
constexpr double kFiner = 2.03;        // frequency of the second octave of `displacement`
constexpr double kOuterRadius = 0.48;  // radius of a hypertexture, a little smaller than its box

HWY_ATTR HWY_INLINE Points operator+(const Points& a, const Points& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
HWY_ATTR HWY_INLINE Points operator*(double s, const Points& a) {
    const V v = constant(s);
    return {v * a.x, v * a.y, v * a.z};
}
HWY_ATTR HWY_INLINE V length(V x, V y, V z) {
    return hn::Sqrt(x * x + y * y + z * z);
}
HWY_ATTR HWY_INLINE V clamped(V x) {
    return hn::Min(hn::Max(x, constant(0)), constant(1));
}
HWY_ATTR HWY_INLINE V smoothstep(double low, double high, V x) {
    const V t = clamped((x - constant(low)) / constant(high - low));
    return t * t * (constant(3) - constant(2) * t);
}

/// The smoke as a function of position, in units of `size` around the origin: [-0.5, 0.5] on the longest axis.
class Smoke {
  public:
    HWY_ATTR explicit Smoke(const Settings& s) : m_s(s), m_plume(s.shape == Shape::plume), m_half(halfExtent(s)) {
        double weight = 1;
        double frequency = s.frequency;
        for (std::int64_t o = 0; o < s.octaves; ++o, weight *= s.gain, frequency *= s.lacunarity) {
            if (o > 0 && frequency > static_cast<double>(s.resolution)) break;
            m_weight += weight;
            ++m_octaves;
        }
    }

    /// The position of the plume's axis at some heights.
    struct Sway {
        V x, z;
    };

    /// The position at one height, the same for all lanes.
    HWY_ATTR Sway swayAt(double y) const {
        if (!m_plume) return {constant(0), constant(0)};
        const double height = y + 0.5;
        const double reach = 0.055 * std::min(1.0, 2 * height);
        return {constant(reach * std::sin(5.1 * height + phase())),
                constant(reach * std::cos(4.3 * height + 1.7 * phase()))};
    }

    /// True for lanes in which the ball around the point is certainly without smoke.
    HWY_ATTR hn::Mask<D> certainlyEmpty(const Points& p, const Sway& sway, double radius) const {
        if (m_s.shape == Shape::box) return boxDepth(p) + constant(radius) <= constant(0);
        if (m_s.shape == Shape::hypertexture) return length(p.x, p.y, p.z) - constant(radius) >= constant(kOuterRadius);
        const double reach = warpReach() + radius;
        // Bound on the change of depth within `reach` of p: depth is measured in local radii, and the plume's radius
        // itself changes with height.
        const V local = hn::Max(constant(kSmallestRadius), radiusAt(m_plume ? p.y - constant(reach) : p.y));
        const double slope = m_plume ? 1.0 + kPlumeSpread + kWander : 1.0;
        return depth(p, sway) + constant(slope * reach) / local + lift(constant(1)) <= constant(0);
    }

    /// As certainlyEmpty. It costs about half of `value`, and proves more where `radius` is small.
    HWY_ATTR hn::Mask<D> provablyEmpty(const Points& p, double radius) const {
        if (m_s.shape == Shape::box || m_s.shape == Shape::hypertexture) return constant(0) > constant(0);
        const Points moved = displaced(p, roughnessAt(p.y));
        // Bound on the distance from `moved` of any displaced point of the ball: the three components of the
        // displacement change like two octaves of noise, and roughness changes as well.
        const double stretch = std::sqrt(3.0) * m_s.warp * (1 + 0.5 * kFiner) * kNoiseSlope;
        const double rougher = std::sqrt(3.0) * 1.5 * kNoiseBound * m_s.warp / m_s.frequency * 0.45 * 1.5 / 0.6;
        const double reach = radius * (1 + stretch + (m_plume ? rougher : 0));
        const double slope = m_plume ? 1 + kWanderBound : 1, spread = m_plume ? kPlumeSpread : 0;
        const V middle = distance(moved, sways(moved.y, moved.y == moved.y));
        const V nearest = hn::Max(constant(0), middle - constant(slope * reach));
        const V deepest = constant(1) - nearest / (radiusAt(moved.y) + constant(spread * reach));
        return hn::And(deepest + lift(constant(1)) <= constant(-kRounding), knownAxis(moved.y - constant(reach)));
    }

    /// Density at points of one height.
    HWY_ATTR V value(const Points& p, const Sway& sway) const {
        const hn::Mask<D> empty = certainlyEmpty(p, sway, 0);
        if (hn::AllTrue(D(), empty)) return constant(0);
        if (m_s.shape == Shape::box) return hn::IfThenZeroElse(empty, haze(p));
        if (m_s.shape == Shape::hypertexture) return hn::IfThenZeroElse(empty, hypertexture(p));
        return hn::IfThenZeroElse(empty, smoke(p, sway));
    }

  private:
    HWY_ATTR V smoke(const Points& p, const Sway& sway) const {
        const V roughness = roughnessAt(p.y);
        const Points moved = displaced(p, roughness);
        // The exact position of the axis at the height of `moved` costs sines. This is an upper bound on depth without
        // them.
        const V aside = constant(m_plume ? kWanderBound : 0) * hn::Abs(moved.y - p.y);
        const V nearest = hn::Max(constant(0), distance(moved, sway) - aside);
        const V deepest = hn::IfThenElse(knownAxis(moved.y), constant(1 + kRounding) - nearest / radiusAt(moved.y),
                                         constant(1 + kRounding));
        const hn::Mask<D> reachable = deepest + lift(constant(1)) > constant(0);
        if (hn::AllFalse(D(), reachable)) return constant(0);
        const Points r = m_s.frequency * moved;
        // The smallest billow that lifts the surface to this point.
        const V least = constant(1 - m_s.coverage) - deepest / (roughness * constant(m_s.turbulence));
        const V lifted = lift(billow(r, hn::IfThenElse(reachable, least, constant(2)))) * roughness;
        const hn::Mask<D> possible = hn::And(reachable, deepest + lifted > constant(0));
        if (hn::AllFalse(D(), possible)) return constant(0);
        const V outer = depth(moved, sways(moved.y, possible)), surface = outer + lifted;
        const hn::Mask<D> reached = outer + lift(constant(1)) > constant(0);
        const hn::Mask<D> filled = hn::And(possible, hn::And(reached, surface > constant(0)));
        if (hn::AllFalse(D(), filled)) return constant(0);
        const V rise = smoothstep(0, m_s.softness, surface);
        const V inside = constant(0.75) + constant(0.6) * fbm(1.7 * r);
        return hn::IfThenElseZero(filled, constant(m_s.density) * rise * clamped(inside) * thinning(p));
    }

    HWY_ATTR V roughnessAt(V y) const {
        return m_plume ? constant(0.55) + constant(0.45) * smoothstep(-0.5, 0.1, y) : constant(1);
    }

    /// The displaced points. The plume's bulges are stretched upwards, and displaced more the higher they are.
    HWY_ATTR Points displaced(const Points& p, V roughness) const {
        const Points way = displacement(m_s.frequency * Points{p.x, m_plume ? constant(0.8) * p.y : p.y, p.z});
        const V bulges = roughness * constant(m_s.warp) / constant(m_s.frequency);
        return p + Points{bulges * way.x, bulges * way.y, bulges * way.z};
    }

    /// Distance to the nearest face of the box, negative outside.
    HWY_ATTR V boxDepth(const Points& p) const {
        return hn::Min(constant(m_half[0]) - hn::Abs(p.x),
                       hn::Min(constant(m_half[1]) - hn::Abs(p.y), constant(m_half[2]) - hn::Abs(p.z)));
    }

    HWY_ATTR V haze(const Points& p) const {
        V part = smoothstep(0, m_s.softness * std::min({m_half[0], m_half[1], m_half[2]}), boxDepth(p));
        const double most = m_s.turbulence * (1 - m_s.coverage);
        if (most > 0) part = part * clamped(constant(1) - constant(most) * warpedBillow(p));
        return constant(m_s.density) * part;
    }

    HWY_ATTR V hypertexture(const Points& p) const {
        const V bent = length(p.x, p.y, p.z) * (constant(1) + constant(m_s.turbulence) * warpedBillow(p));
        const double inner = kOuterRadius * std::max(0.0, 1 - m_s.softness);
        const double outer2 = kOuterRadius * kOuterRadius, fall = outer2 - inner * inner;
        return constant(m_s.density) * clamped((constant(outer2) - bent * bent) / constant(fall));
    }

    HWY_ATTR V warpedBillow(const Points& p) const {
        const Points q = m_s.frequency * p;
        return billow(q + m_s.warp * displacement(q), constant(-1));
    }

    HWY_ATTR double warpReach() const { return kWarpBound * m_s.warp / m_s.frequency; }

    HWY_ATTR V radiusAt(V y) const {
        if (m_s.shape == Shape::ball) return constant(kBallRadius);
        if (m_s.shape == Shape::slab) return constant(kSlabRadius);
        return hn::Max(constant(kSmallestRadius), constant(kBaseRadius) + constant(kPlumeSpread) * (y + constant(0.5)));
    }

    /// Depth below the undisturbed surface, in radii: 1 on the axis (or at the centre), 0 at the surface.
    HWY_ATTR V depth(const Points& p, const Sway& sway) const {
        return constant(1) - distance(p, sway) / radiusAt(p.y);
    }

    /// Distance from the axis, the centre or the middle plane.
    HWY_ATTR V distance(const Points& p, const Sway& sway) const {
        if (m_s.shape == Shape::ball) return length(p.x, p.y, p.z);
        if (m_s.shape == Shape::slab) return hn::Abs(p.y);
        const V dy = hn::Max(constant(0), p.y + constant(0.5) - constant(kHead));
        return length(p.x - sway.x, dy, p.z - sway.z);
    }

    /// The position of the axis at a different height in each wanted lane. Sines are computed one by one by the C
    /// library, which gives the same result for every instruction set.
    HWY_ATTR Sway sways(V y, hn::Mask<D> wanted) const {
        if (!m_plume) return {constant(0), constant(0)};
        const V height = y + constant(0.5);
        HWY_ALIGN double x[8], z[8], is[8];
        hn::Store(constant(5.1) * height + constant(phase()), D(), x);
        hn::Store(constant(4.3) * height + constant(1.7 * phase()), D(), z);
        hn::Store(hn::IfThenElseZero(wanted, constant(1)), D(), is);
        for (std::size_t i = 0; i < hn::Lanes(D()); ++i) {
            if (is[i] == 0) continue;
            x[i] = std::sin(x[i]);
            z[i] = std::cos(z[i]);
        }
        const V reach = constant(0.055) * hn::Min(constant(1), constant(2) * height);
        return {reach * hn::Load(D(), x), reach * hn::Load(D(), z)};
    }
    /// True where the bound on the slope of the axis holds.
    HWY_ATTR hn::Mask<D> knownAxis(V y) const { return y >= constant(m_plume ? kLowest : -1e30); }

    HWY_ATTR double phase() const { return 0.01 * (m_s.seed % 628u); }

    /// The distance, in radii, by which a billow of `b` in [0, 1] moves the surface. With coverage 1 the surface is
    /// never dented, with 0 never lifted.
    HWY_ATTR V lift(V b) const { return constant(m_s.turbulence) * (b - constant(1) + constant(m_s.coverage)); }

    /// Fades towards the ends of the box, so that nothing is cut off.
    HWY_ATTR V thinning(const Points& p) const {
        const auto edge = [](V x, double half)
                              HWY_ATTR { return constant(1) - smoothstep(0.86 * half, 0.99 * half, hn::Abs(x)); };
        if (!m_plume) return edge(p.x, m_half[0]) * edge(p.y, m_half[1]) * edge(p.z, m_half[2]);
        return (constant(1) - constant(0.7) * smoothstep(0.0, 0.5, p.y)) * smoothstep(-0.5, -0.46, p.y) *
               edge(p.x, m_half[0]) * edge(hn::Max(constant(0), p.y), m_half[1]) * edge(p.z, m_half[2]);
    }

    HWY_ATTR Points displacement(const Points& q) const {
        const Cells coarse = cellsAt(q), fine = cellsAt(kFiner * q);
        const auto two = [&](std::uint32_t seed) HWY_ATTR {
            return gradientNoise(coarse, m_s.seed + seed) + constant(0.5) * gradientNoise(fine, m_s.seed + seed + 1);
        };
        return {two(101), two(211), two(307)};
    }

    /// The billow at q. If it is certain to be below `least` in all lanes, the result may be any value below that.
    HWY_ATTR V billow(Points q, V least) const {
        V sum = constant(0);
        double weight = 1, rest = m_weight;
        for (std::int64_t o = 0; o < m_octaves; ++o, weight *= m_s.gain, q = m_s.lacunarity * q) {
            // |noise| of one octave averages 0.25 and rarely exceeds 0.7; the factor spreads it over [0, 1].
            const V n = gradientNoise(cellsAt(q), m_s.seed + static_cast<std::uint32_t>(o));
            sum = sum + constant(weight) * hn::Min(constant(1), constant(1.5) * hn::Abs(n));
            rest -= weight;
            if (hn::AllTrue(D(), sum + constant(rest + kRounding) < least * constant(m_weight))) break;
        }
        return sum / constant(m_weight);
    }

    HWY_ATTR V fbm(Points q) const {
        V sum = constant(0);
        double weight = 1;
        for (std::int64_t o = 0; o < m_octaves; ++o, weight *= m_s.gain, q = m_s.lacunarity * q)
            sum = sum + constant(weight) * gradientNoise(cellsAt(q), m_s.seed + 400 + static_cast<std::uint32_t>(o));
        return sum / constant(m_weight);
    }

    const Settings& m_s;
    bool m_plume;
    std::array<double, 3> m_half;
    std::int64_t m_octaves = 0;  ///< the octaves that are not finer than voxels
    double m_weight = 0;         ///< the sum of their weights
};

/// The lattice of voxel centres, which lie at (index + 0.5) / resolution.
struct Lattice {
    double step;
    double first[3];

    HWY_ATTR double at(int axis, double voxel) const { return first[axis] + step * voxel; }
};

constexpr int kPart = 4;  // edge of the parts of a block that are culled separately, and the number of lanes along z

/// Fills a part of a block, from voxel (x0, y0, z0). Lanes are voxels along z, and along x where there are more than
/// four.
HWY_ATTR void fillPart(const Smoke& smoke, const Lattice& lattice, int x0, int y0, int z0, float* values) {
    constexpr int kLanes = HWY_MIN(8, HWY_LANES(double)), kAlongZ = HWY_MIN(kPart, kLanes), kAlongX = kLanes / kAlongZ;
    HWY_ALIGN double xs[kLanes], zs[kLanes];
    HWY_ALIGN float some[kLanes];
    for (int y = y0; y < y0 + kPart; ++y) {
        const Smoke::Sway sway = smoke.swayAt(lattice.at(1, y));
        for (int x = x0; x < x0 + kPart; x += kAlongX)
            for (int z = z0; z < z0 + kPart; z += kAlongZ) {
                for (int i = 0; i < kLanes; ++i) {
                    xs[i] = lattice.at(0, x + i / kAlongZ);
                    zs[i] = lattice.at(2, z + i % kAlongZ);
                }
                const V v = smoke.value({hn::Load(D(), xs), constant(lattice.at(1, y)), hn::Load(D(), zs)}, sway);
                const hn::Rebind<float, D> floats;
                hn::Store(hn::DemoteTo(floats, v), floats, some);
                for (int i = 0; i < kLanes; ++i)
                    values[((x + i / kAlongZ) * kEdge + y) * kEdge + z + i % kAlongZ] = some[i];
            }
    }
}

HWY_ATTR bool fillBlockOnTarget(const Settings& s, const std::int32_t origin[3], float* values) {
    const Smoke smoke(s);
    const double step = 1.0 / static_cast<double>(s.resolution);
    const Lattice lattice{step, {step * (origin[0] + 0.5), step * (origin[1] + 0.5), step * (origin[2] + 0.5)}};
    const double half = 0.5 * step * (kEdge - 1);
    const Points middle{constant(lattice.first[0] + half), constant(lattice.first[1] + half),
                        constant(lattice.first[2] + half)};
    const Smoke::Sway sway = smoke.swayAt(lattice.first[1] + half);
    if (hn::AllTrue(D(), smoke.certainlyEmpty(middle, sway, half * std::sqrt(3.0)))) return false;

    // The centres of the block's eight parts.
    constexpr double kMiddle = 0.5 * (kPart - 1);
    HWY_ALIGN double x[8], y[8], z[8], empty[8];
    for (int i = 0; i < 8; ++i) {
        x[i] = lattice.at(0, kMiddle + (i & 4));
        y[i] = lattice.at(1, kMiddle + (i << 1 & 4));
        z[i] = lattice.at(2, kMiddle + (i << 2 & 4));
    }
    for (std::size_t i = 0; i < 8; i += hn::Lanes(D())) {
        const Points p{hn::Load(D(), x + i), hn::Load(D(), y + i), hn::Load(D(), z + i)};
        const auto none = smoke.provablyEmpty(p, kMiddle * step * std::sqrt(3.0) * (1 + 1e-9));
        hn::Store(hn::IfThenElseZero(none, constant(1)), D(), empty + i);
    }
    std::fill(values, values + kBlockVoxels, 0.0f);
    for (int i = 0; i < 8; ++i)
        if (empty[i] == 0) fillPart(smoke, lattice, i & 4, i << 1 & 4, i << 2 & 4, values);
    return std::any_of(values, values + kBlockVoxels, [](float v) { return v > 0; });
}

}  // namespace HWY_NAMESPACE
}  // namespace noise_source
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace noise_source {

HWY_EXPORT(fillBlockOnTarget);

std::array<double, 3> halfExtent(const Settings& s) {
    if (s.shape == Shape::plume) return {0.36, 0.5, 0.36};
    if (s.shape == Shape::box) return s.boxHalf;
    if (s.shape == Shape::slab) return {0.5, 0.15, 0.5};
    return {0.5, 0.5, 0.5};
}

bool fillBlock(const Settings& settings, const std::int32_t origin[3], float* values) {
    return HWY_DYNAMIC_DISPATCH(fillBlockOnTarget)(settings, origin, values);
}

}  // namespace noise_source
#endif
