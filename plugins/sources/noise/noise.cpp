// SPDX-License-Identifier: Apache-2.0
// Volume source `noise`: procedural smoke, fog and clouds, so that there is something to render without a file.
//
// It is not a simulation. An envelope (a rising plume, a ball or a slab) gives a signed depth below the surface of
// the smoke; turbulence lifts and dents that surface, and density grows from 0 at the surface to its full value one
// `softness` below. Turbulence is a sum of octaves of gradient noise (Perlin 1985, with the quintic fade and the
// gradients of Perlin 2002), each `lacunarity` times finer and `gain` times weaker than the last:
//   billow(p) = sum_o gain^o (1 - |noise(p lacunarity^o)|) / sum_o gain^o,
// whose creases between round bulges are what one takes for convection; a smooth fBm of the same octaves thins the
// inside. Positions are displaced beforehand by a vector of two octaves of noise (domain warping), which curls the
// bulges. The plume widens with height as an entraining plume does (radius proportional to height above a virtual
// source below it; Morton, Taylor and Turner 1956), wanders sideways, roughens as it rises, and thins out at the top.
//
// Two shapes are made otherwise. A box is haze: full density, thinned by the billows of `turbulence` (0: even), with
// soft faces. A hypertexture (Perlin and Hoffert 1989) is a soft ball, full up to an inner radius ri, from where
// density falls with the square of the distance to 0 at the outer one, ro:
//   D(p) = (ro^2 - |p|^2) / (ro^2 - ri^2), clamped to [0, 1],
// looked up at p (1 + turbulence billow(p)): creases reach into the ball, and nothing ever reaches out of it.
//
// Parameters (lengths in world units; the volume is centred on the origin, y is up):
//   resolution  voxels along the longest axis
//   size        length of that axis
//   shape       plume, ball, slab, box or hypertexture
//   density     largest value
//   frequency   bulges of the coarsest octave along size
//   octaves     number of octaves; those finer than voxels are left out
//   lacunarity  how much finer the next octave is
//   gain        how much weaker the next octave is
//   turbulence  height of bulges, in parts of the radius; how much a box lacks, how deep a hypertexture's creases are
//   warp        how far positions are displaced, in bulges
//   coverage    0.5: as described; 1 fills the envelope, 0 leaves only the strongest bulges (not for hypertextures)
//   softness    depth over which density grows, in parts of the radius (of a box: of half its least edge)
//   seed        another number, another smoke
//   proportions of a box: its edges, the longest of which is `size`
//
// Every voxel is a pure function of its place and the parameters, so the bytes are the same on each run and machine
// with IEEE arithmetic; blocks whose whole extent lies outside the highest possible bulge are never evaluated.
#include <scrim/volume/scrim_source.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <exception>
#include <iterator>
#include <string_view>

namespace {

constexpr int kEdge = 8;  // of a block

struct Vec {
    double x, y, z;
};
Vec operator+(Vec a, Vec b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
Vec operator*(double s, Vec a) {
    return {s * a.x, s * a.y, s * a.z};
}
double length(Vec a) {
    return std::sqrt(a.x * a.x + a.y * a.y + a.z * a.z);
}

double smoothstep(double low, double high, double x) {
    const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

/// A well-mixed 32-bit hash of a lattice point (the finaliser of MurmurHash3 over three odd multiples).
std::uint32_t hash(std::int32_t x, std::int32_t y, std::int32_t z, std::uint32_t seed) {
    std::uint32_t h = seed ^ (static_cast<std::uint32_t>(x) * 0x8da6b343u) ^
                      (static_cast<std::uint32_t>(y) * 0xd8163841u) ^ (static_cast<std::uint32_t>(z) * 0xcb1ab31fu);
    h ^= h >> 16;
    h *= 0x85ebca6bu;
    h ^= h >> 13;
    h *= 0xc2b2ae35u;
    return h ^ (h >> 16);
}

/// Gradient noise, about -1 to 1, 0 at lattice points.
double noise(Vec p, std::uint32_t seed) {
    // The twelve edges of a cube; four of them twice (Perlin 2002), so that four bits choose.
    static constexpr std::array<std::array<double, 3>, 16> kGradients{{{1, 1, 0},
                                                                       {-1, 1, 0},
                                                                       {1, -1, 0},
                                                                       {-1, -1, 0},
                                                                       {1, 0, 1},
                                                                       {-1, 0, 1},
                                                                       {1, 0, -1},
                                                                       {-1, 0, -1},
                                                                       {0, 1, 1},
                                                                       {0, -1, 1},
                                                                       {0, 1, -1},
                                                                       {0, -1, -1},
                                                                       {1, 1, 0},
                                                                       {-1, 1, 0},
                                                                       {0, -1, 1},
                                                                       {0, -1, -1}}};
    // std::floor is a call where the compiler may not use SSE 4.1; this is not.
    const auto below = [](double v) {
        const auto i = static_cast<std::int32_t>(v);
        return v < i ? i - 1 : i;
    };
    const std::int32_t ix = below(p.x), iy = below(p.y), iz = below(p.z);
    const double x = p.x - ix, y = p.y - iy, z = p.z - iz;
    const auto corner = [&](int dx, int dy, int dz) {
        const auto& g = kGradients[hash(ix + dx, iy + dy, iz + dz, seed) & 15u];
        return g[0] * (x - dx) + g[1] * (y - dy) + g[2] * (z - dz);
    };
    const auto fade = [](double t) { return t * t * t * (t * (6 * t - 15) + 10); };
    const auto mix = [](double t, double a, double b) { return a + t * (b - a); };
    const double u = fade(x), v = fade(y), w = fade(z);
    return mix(w, mix(v, mix(u, corner(0, 0, 0), corner(1, 0, 0)), mix(u, corner(0, 1, 0), corner(1, 1, 0))),
               mix(v, mix(u, corner(0, 0, 1), corner(1, 0, 1)), mix(u, corner(0, 1, 1), corner(1, 1, 1))));
}

enum class Shape { plume, ball, slab, box, hypertexture };

struct Settings {
    std::int64_t resolution;
    double size;
    Shape shape;
    double frequency;
    std::int64_t octaves;
    double lacunarity;
    double gain;
    double turbulence;
    double warp;
    double coverage;
    double softness;
    double density;
    std::uint32_t seed;
    Vec half;  ///< of a box, in sizes
};

/// The smoke as a function of position, in units of `size` around the origin: [-0.5, 0.5] on the longest
/// axis.
class Smoke {
  public:
    explicit Smoke(const Settings& s) : m_s(s) {
        double weight = 1;
        double frequency = s.frequency;
        for (std::int64_t o = 0; o < s.octaves; ++o, weight *= s.gain, frequency *= s.lacunarity) {
            if (o > 0 && frequency > static_cast<double>(s.resolution)) break;
            m_weight += weight;
            ++m_octaves;
        }
    }

    /// Half the extent of the box the smoke is confined to.
    Vec halfExtent() const {
        if (m_s.shape == Shape::plume) return {0.36, 0.5, 0.36};
        if (m_s.shape == Shape::box) return m_s.half;
        if (m_s.shape == Shape::slab) return {0.5, 0.15, 0.5};
        return {0.5, 0.5, 0.5};
    }

    /// Whether a ball around `p` is certainly without smoke.
    bool certainlyEmpty(Vec p, double radius) const {
        if (m_s.shape == Shape::box) return boxDepth(p) + radius <= 0;
        if (m_s.shape == Shape::hypertexture) return length(p) - radius >= kOuterRadius;
        const double reach = warpReach() + radius;
        // Within `reach` of p the depth changes by at most this: depth is measured in local radii, and for
        // the plume the radius itself changes with height.
        const double local = std::max(kSmallestRadius, radiusAt(p.y - (m_s.shape == Shape::plume ? reach : 0)));
        const double slope = m_s.shape == Shape::plume ? 1.0 + kPlumeSpread + kWander : 1.0;
        return depth(p) + slope * reach / local + lift(1.0) <= 0;
    }

    double value(Vec p) const {
        if (certainlyEmpty(p, 0)) return 0;
        if (m_s.shape == Shape::box) return haze(p);
        if (m_s.shape == Shape::hypertexture) return hypertexture(p);
        const double roughness = m_s.shape == Shape::plume ? 0.55 + 0.45 * smoothstep(-0.5, 0.1, p.y) : 1.0;
        // The plume's bulges are stretched upwards, and displaced more the higher they are.
        const Vec q = (m_s.frequency) * Vec{p.x, m_s.shape == Shape::plume ? 0.8 * p.y : p.y, p.z};
        const Vec moved = p + (roughness * m_s.warp / m_s.frequency) * displacement(q);
        const Vec r = m_s.frequency * moved;
        const double outer = depth(moved);
        if (outer + lift(1.0) <= 0) return 0;
        const double surface = outer + lift(billow(r)) * roughness;
        if (surface <= 0) return 0;
        const double rise = smoothstep(0, m_s.softness, surface);
        const double inside = 0.75 + 0.6 * fbm(1.7 * r);
        return m_s.density * rise * std::clamp(inside, 0.0, 1.0) * thinning(p);
    }

  private:
    static constexpr double kBaseRadius = 0.05;      // of the plume at its foot
    static constexpr double kPlumeSpread = 0.19;     // growth of its radius with height
    static constexpr double kWander = 0.35;          // bound of the slope of its axis
    static constexpr double kHead = 0.76;            // where its axis ends, in a round head
    static constexpr double kSmallestRadius = 0.03;  // where the plume is thinnest, also below its foot
    static constexpr double kWarpBound = 1.6;        // of the length of `displacement`
    static constexpr double kOuterRadius = 0.48;     // of a hypertexture: a little inside of its box

    /// Distance to the nearest face of the box, negative outside.
    double boxDepth(Vec p) const {
        return std::min({m_s.half.x - std::abs(p.x), m_s.half.y - std::abs(p.y), m_s.half.z - std::abs(p.z)});
    }

    double haze(Vec p) const {
        const double rise = m_s.softness * std::min({m_s.half.x, m_s.half.y, m_s.half.z});
        double part = smoothstep(0, rise, boxDepth(p));
        const double depth = m_s.turbulence * (1 - m_s.coverage);
        if (depth > 0) part *= std::clamp(1 - depth * warpedBillow(p), 0.0, 1.0);
        return m_s.density * part;
    }

    double hypertexture(Vec p) const {
        const double bent = length(p) * (1 + m_s.turbulence * warpedBillow(p));
        const double inner = kOuterRadius * std::max(0.0, 1 - m_s.softness);
        const double fall = kOuterRadius * kOuterRadius - inner * inner;
        return m_s.density * std::clamp((kOuterRadius * kOuterRadius - bent * bent) / fall, 0.0, 1.0);
    }

    double warpedBillow(Vec p) const {
        const Vec q = m_s.frequency * p;
        return billow(q + m_s.warp * displacement(q));
    }

    double warpReach() const { return kWarpBound * m_s.warp / m_s.frequency; }

    double radiusAt(double y) const {
        if (m_s.shape == Shape::ball) return 0.32;
        if (m_s.shape == Shape::slab) return 0.09;
        return std::max(kSmallestRadius, kBaseRadius + kPlumeSpread * (y + 0.5));
    }

    /// Depth below the undisturbed surface, in radii: 1 on the axis (or at the centre), 0 at the surface.
    double depth(Vec p) const {
        if (m_s.shape == Shape::ball) return 1 - length(p) / radiusAt(0);
        if (m_s.shape == Shape::slab) return 1 - std::abs(p.y) / radiusAt(0);
        const double height = p.y + 0.5;
        const double sway = 0.055 * std::min(1.0, 2 * height);
        const double dx = p.x - sway * std::sin(5.1 * height + m_phase());
        const double dz = p.z - sway * std::cos(4.3 * height + 1.7 * m_phase());
        const double dy = std::max(0.0, height - kHead);
        return 1 - std::sqrt(dx * dx + dy * dy + dz * dz) / radiusAt(p.y);
    }
    double m_phase() const { return 0.01 * (m_s.seed % 628u); }

    /// How far a billow of `b` in [0, 1] moves the surface, in radii. Coverage 1 never dents it, 0 never
    /// lifts it.
    double lift(double b) const { return m_s.turbulence * (b - 1 + m_s.coverage); }

    /// Fades towards the ends of the box, so that nothing is cut off.
    double thinning(Vec p) const {
        const Vec h = halfExtent();
        const auto edge = [](double x, double half) { return 1 - smoothstep(0.86 * half, 0.99 * half, std::abs(x)); };
        if (m_s.shape == Shape::plume)
            return (1 - 0.7 * smoothstep(0.0, 0.5, p.y)) * smoothstep(-0.5, -0.46, p.y) * edge(p.x, h.x) *
                   edge(std::max(0.0, p.y), h.y) * edge(p.z, h.z);
        return edge(p.x, h.x) * edge(p.y, h.y) * edge(p.z, h.z);
    }

    Vec displacement(Vec q) const {
        const auto two = [&](Vec a, std::uint32_t seed) { return noise(a, seed) + 0.5 * noise(2.03 * a, seed + 1); };
        return {two(q, m_s.seed + 101), two(q, m_s.seed + 211), two(q, m_s.seed + 307)};
    }

    double billow(Vec q) const {
        double sum = 0;
        double weight = 1;
        for (std::int64_t o = 0; o < m_octaves; ++o, weight *= m_s.gain, q = m_s.lacunarity * q) {
            // |noise| of one octave averages 0.25 and rarely exceeds 0.7; the factor spreads it over [0, 1].
            const double n = noise(q, m_s.seed + static_cast<std::uint32_t>(o));
            sum += weight * std::min(1.0, 1.5 * std::abs(n));
        }
        return sum / m_weight;
    }

    double fbm(Vec q) const {
        double sum = 0;
        double weight = 1;
        for (std::int64_t o = 0; o < m_octaves; ++o, weight *= m_s.gain, q = m_s.lacunarity * q)
            sum += weight * noise(q, m_s.seed + 400 + static_cast<std::uint32_t>(o));
        return sum / m_weight;
    }

    Settings m_s;
    std::int64_t m_octaves = 0;  ///< those not finer than voxels
    double m_weight = 0;         ///< the sum of their weights
};

/// Fills one block; false where it stayed empty. `half`: voxel centres lie at (index + 0.5) / resolution.
bool fillBlock(const Smoke& smoke, const Settings& s, const std::int32_t origin[3], float* values) {
    const double step = 1.0 / static_cast<double>(s.resolution);
    const Vec first{step * (origin[0] + 0.5), step * (origin[1] + 0.5), step * (origin[2] + 0.5)};
    const double half = 0.5 * step * (kEdge - 1);
    if (smoke.certainlyEmpty(first + half * Vec{1, 1, 1}, half * std::sqrt(3.0))) return false;
    bool any = false;
    for (int x = 0; x < kEdge; ++x)
        for (int y = 0; y < kEdge; ++y)
            for (int z = 0; z < kEdge; ++z) {
                const auto v = static_cast<float>(smoke.value(first + step * Vec{double(x), double(y), double(z)}));
                values[(x * kEdge + y) * kEdge + z] = v;
                any = any || v > 0;
            }
    return any;
}

int emit(const scrim_host* host, const Settings& s) {
    const double voxel = s.size / static_cast<double>(s.resolution);
    const double shift = 0.5 * voxel;
    const double worldFromIndex[16] = {voxel, 0, 0, shift, 0, voxel, 0, shift, 0, 0, voxel, shift, 0, 0, 0, 1};
    const int grid = host->add_grid(host, "density", worldFromIndex);
    if (grid < 0) return grid;

    const Smoke smoke(s);
    const Vec h = smoke.halfExtent();
    const auto blocks = [&](double half) {
        return static_cast<std::int32_t>(std::ceil(half * static_cast<double>(s.resolution) / kEdge));
    };
    const std::int32_t nx = blocks(h.x), ny = blocks(h.y), nz = blocks(h.z);
    float values[kEdge * kEdge * kEdge];
    for (std::int32_t bx = -nx; bx < nx; ++bx) {
        for (std::int32_t by = -ny; by < ny; ++by)
            for (std::int32_t bz = -nz; bz < nz; ++bz) {
                const std::int32_t origin[3] = {kEdge * bx, kEdge * by, kEdge * bz};
                if (!fillBlock(smoke, s, origin, values)) continue;
                // Even haze is tiles; other shapes stay as they always were.
                const bool even = s.shape == Shape::box && std::all_of(std::begin(values), std::end(values),
                                                                       [&](float v) { return v == values[0]; });
                const int error = even ? host->add_tile(host, grid, origin, kEdge, values[0])
                                       : host->add_block(host, grid, origin, values);
                if (error != 0) return error;
            }
        if (const int stop = host->progress(host, double(bx + nx + 1) / (2 * nx)); stop != 0) return stop;
    }
    return 0;
}

// The order of `kParameters` and of the reads in `generate` is one.
constexpr scrim_parameter kParameters[] = {
    {"resolution", SCRIM_INTEGER, "128", 8, 4096, nullptr, "voxels along the longest axis"},
    {"size", SCRIM_NUMBER, "2", 1e-6, 1e9, nullptr, "length of the longest axis, in world units"},
    {"shape", SCRIM_STRING, "plume", 0, 0, "plume|ball|slab|box|hypertexture", "what the smoke fills"},
    {"frequency", SCRIM_NUMBER, "5", 0.1, 1000, nullptr, "bulges of the coarsest octave along the size"},
    {"octaves", SCRIM_INTEGER, "5", 1, 16, nullptr, "octaves of turbulence"},
    {"lacunarity", SCRIM_NUMBER, "2.1", 1, 10, nullptr, "how much finer each octave is than the last"},
    {"gain", SCRIM_NUMBER, "0.5", 0, 1, nullptr, "how much weaker each octave is than the last"},
    {"turbulence", SCRIM_NUMBER, "1.6", 0, 10, nullptr, "height of bulges, in parts of the radius"},
    {"warp", SCRIM_NUMBER, "0.35", 0, 2, nullptr, "how far positions are displaced, in bulges"},
    {"coverage", SCRIM_NUMBER, "0.5", 0, 1, nullptr, "1 fills the envelope, 0 leaves the strongest bulges"},
    {"softness", SCRIM_NUMBER, "0.35", 1e-3, 10, nullptr, "depth over which density grows, in parts of the radius"},
    {"density", SCRIM_NUMBER, "1", 0, 1e6, nullptr, "largest value"},
    {"seed", SCRIM_INTEGER, "1", 0, 1e9, nullptr, "another number, another smoke"},
    {"proportions", SCRIM_VEC3, "1, 1, 1", 1e-3, 1e3, nullptr, "of a box: its edges, the longest of which is size"},
};

Settings read(const scrim_value* v) {
    Settings s{};
    s.resolution = v[0].integer;
    s.size = v[1].number[0];
    const std::string_view shape = v[2].text;  // one of these, in the order of the enumeration
    constexpr std::array<std::string_view, 5> kShapes{"plume", "ball", "slab", "box", "hypertexture"};
    s.shape = static_cast<Shape>(std::find(kShapes.begin(), kShapes.end(), shape) - kShapes.begin());
    s.frequency = v[3].number[0];
    s.octaves = v[4].integer;
    s.lacunarity = v[5].number[0];
    s.gain = v[6].number[0];
    s.turbulence = v[7].number[0];
    s.warp = v[8].number[0];
    s.coverage = v[9].number[0];
    s.softness = v[10].number[0];
    s.density = v[11].number[0];
    s.seed = static_cast<std::uint32_t>(v[12].integer);
    const double* edges = v[13].number;
    s.half = (0.5 / std::max({edges[0], edges[1], edges[2]})) * Vec{edges[0], edges[1], edges[2]};
    return s;
}

int generate(const scrim_host* host, const scrim_value* values) {
    try {
        return emit(host, read(values));
    } catch (const std::exception& error) {
        host->fail(host, error.what());
    } catch (...) {
        host->fail(host, "unknown exception");
    }
    return 1;
}

constexpr scrim_source kSource = {SCRIM_SOURCE_ABI,
                                  sizeof(scrim_source),
                                  "noise",
                                  "procedural smoke and haze: plume, ball, slab, box or hypertexture",
                                  kParameters,
                                  sizeof kParameters / sizeof kParameters[0],
                                  sizeof(scrim_parameter),
                                  generate};

}  // namespace

extern "C" SCRIM_SOURCE_EXPORT const scrim_source* scrim_source_v1(void) {
    return &kSource;
}
