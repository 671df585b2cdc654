// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/light/sheet_light.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "scrim/engine/light/sheet_light.cpp"
#include <hwy/foreach_target.h>
#include <scrim/engine/simd-inl.h>

// Definitions that do not depend on the target.
#ifndef SCRIM_SLIDE_TILE_ONCE
#define SCRIM_SLIDE_TILE_ONCE
namespace scrim {
namespace {

// The most taps. A longer footprint uses a coarser level: less sharp across, but never aliased.
constexpr int kMostTaps = 16;

// Footprints shorter than this fraction of a pixel of the slide are points.
constexpr Real kPoint = Real(0.5);

// A footprint whose length exceeds its width by less than this fraction of the width counts as round and takes one tap.
constexpr Real kNearlyRound = Real(0.25);

// The pixels of a level that blurs as much as a box does, relative to the box.
constexpr Real kOfBox = Real(0.577);

// The map of one tile in the engine's floats: slide positions are relative to `corner`, the place of the tile's first
// sample. This keeps their precision, however far they are from the picture's origin and from the world's.
struct TileMap {
    Real u0, v0;
    Real at[3], perU[3], perV[3], perN[3];  // (X - cornerX W, Y - cornerY W, W)
    double cornerX, cornerY;
};

TileMap tileMap(const SheetSlide& slide, Real u0, Real v0) {
    const SlideMap::OnSheet& m = slide.map;
    const double width = slide.image->width(), height = slide.image->height();
    const Vec3 base = m.atOrigin + double(u0) * m.perU + double(v0) * m.perV;
    TileMap out{};
    out.u0 = u0;
    out.v0 = v0;
    const bool inFront = base.z > 0;
    out.cornerX = inFront ? base.x / base.z : 0.5 * width;
    out.cornerY = inFront ? base.y / base.z : 0.5 * height;
    if (slide.outside != SlideOutside::repeat) {
        out.cornerX = std::clamp(out.cornerX, -width, 2 * width);
        out.cornerY = std::clamp(out.cornerY, -height, 2 * height);
    }
    // W is in world units, of any magnitude; relative to the corner's it is close to 1.
    const double scale = inFront ? 1 / base.z : 1;
    const auto put = [&](const Vec3& h, Real* to) {
        to[0] = static_cast<Real>(scale * (h.x - out.cornerX * h.z));
        to[1] = static_cast<Real>(scale * (h.y - out.cornerY * h.z));
        to[2] = static_cast<Real>(scale * h.z);
    };
    put(base, out.at);
    put(m.perU, out.perU);
    put(m.perV, out.perV);
    put(m.perN, out.perN);
    return out;
}

// The place of the tile's corner on one level, with pixel centres at integers.
struct LevelPlace {
    const float* pixels;
    int width, height;
    int x, y;             // integer part
    Real fx, fy;          // fraction
    Real scaleX, scaleY;  // level pixels per pixel of the picture
};
constexpr std::size_t kMostLevels = 32;

void splitPlace(double corner, int whole, int part, SlideOutside outside, int& index, Real& rest, Real& scale) {
    const double ratio = double(part) / whole;
    if (outside == SlideOutside::repeat) corner -= whole * std::floor(corner / whole);
    const double at = corner * ratio - 0.5, floor = std::floor(at);
    index = static_cast<int>(floor);
    rest = static_cast<Real>(at - floor);
    scale = static_cast<Real>(ratio);
}

}  // namespace
}  // namespace scrim
#endif

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

// The footprints of all samples, in pixels of the picture; positions are relative to the tile's corner.
struct Footprints {
    alignas(64) Real x[kTileSize], y[kTileSize];          // centre
    alignas(64) Real stepX[kTileSize], stepY[kTileSize];  // from tap to tap
    alignas(64) Real taps[kTileSize];                     // number of taps; 0: unlit
    alignas(64) Real size[kTileSize];                     // size that each tap is averaged over
    alignas(64) Real boxX[kTileSize], boxY[kTileSize];    // edges of a tap's own box
};

// The change of the slide position along (dX, dY, dW), at position (x, y): the derivative of X / W.
HWY_ATTR HWY_INLINE VF moved(VF d, VF dW, VF at, VF inverseW) {
    return hn::Mul(hn::NegMulAdd(at, dW, d), inverseW);
}

struct Vector3 {
    VF x, y, w;
};

HWY_ATTR HWY_INLINE Vector3 combined(const TileMap& m, VF u, VF v, VF n) {
    const auto part = [&](int i) HWY_ATTR {
        return hn::MulAdd(u, constant(m.perU[i]), hn::MulAdd(v, constant(m.perV[i]), hn::Mul(n, constant(m.perN[i]))));
    };
    return {part(0), part(1), part(2)};
}

// For one vector of samples: whether it is lit, the centre of its footprint, and the sums over the
// footprint's edges of the products of their coordinates.
struct Spread {
    hn::Mask<DF> lit;
    VF x, y, xx, xy, yy;
};

// Divides footprints along their long axis into taps.
HWY_ATTR HWY_INLINE void storeFootprint(const Spread& spread, int k, Footprints& out) {
    const DF d;
    const auto zero = constant(0), one = constant(1);
    const auto& [lit, x, y, xx, xy, yy] = spread;
    // Squares of the lengths of the two axes: the eigenvalues of the covariance times 12.
    const auto half = constant(0.5);
    const auto mean = hn::Mul(half, hn::Add(xx, yy)), difference = hn::Mul(half, hn::Sub(xx, yy));
    const auto root = hn::Sqrt(hn::MulAdd(difference, difference, hn::Mul(xy, xy)));
    const auto longer = hn::Sqrt(hn::Add(mean, root));
    const auto shorter = hn::Sqrt(hn::Max(hn::Sub(mean, root), zero));
    auto taps = hn::Ceil(hn::Sub(hn::Div(longer, hn::Max(shorter, constant(kPoint))), constant(kNearlyRound)));
    taps = hn::Min(hn::Max(taps, one), constant(kMostTaps));
    const auto part = hn::Div(longer, taps);

    // The direction of the long axis, from the longer column of the matrix.
    const auto steep = hn::Lt(difference, zero);
    auto axisX = hn::IfThenElse(steep, xy, hn::Add(difference, root));
    auto axisY = hn::IfThenElse(steep, hn::Sub(root, difference), xy);
    const auto norm = hn::Sqrt(hn::MulAdd(axisX, axisX, hn::Mul(axisY, axisY)));
    const auto round = hn::Lt(norm, constant(1e-20));
    const auto toUnit = hn::Div(one, hn::IfThenElse(round, one, norm));
    axisX = hn::IfThenElse(round, one, hn::Mul(axisX, toUnit));
    axisY = hn::IfThenElse(round, zero, hn::Mul(axisY, toUnit));

    hn::Store(x, d, out.x + k);
    hn::Store(y, d, out.y + k);
    hn::Store(hn::Mul(part, axisX), d, out.stepX + k);
    hn::Store(hn::Mul(part, axisY), d, out.stepY + k);
    hn::Store(hn::IfThenElseZero(lit, taps), d, out.taps + k);
    // Interpolation within a level of pixels of edge e has a variance of e^2 / 12 + e^2 / 6, that of a box of 1.7 e.
    hn::Store(hn::Mul(constant(kOfBox), hn::Max(shorter, part)), d, out.size + k);
    // The rest of the footprint after division into taps. A thousandth of a pixel keeps quotients finite.
    const auto taken = hn::Mul(hn::Mul(longer, longer), hn::Sub(one, hn::Div(one, hn::Mul(taps, taps))));
    const auto least = constant(1e-6);
    hn::Store(hn::Sqrt(hn::Max(hn::NegMulAdd(taken, hn::Mul(axisX, axisX), xx), least)), d, out.boxX + k);
    hn::Store(hn::Sqrt(hn::Max(hn::NegMulAdd(taken, hn::Mul(axisY, axisY), yy), least)), d, out.boxY + k);
}

HWY_ATTR void layFootprints(const TileMap& m, const SampleTile& samples, Real slopeToTexels, Footprints& out) {
    const DF d;
    const SampleSpacing& spacing = samples.spacing;
    const auto zero = constant(0), one = constant(1);
    for (int k = 0; k < kTileSize; k += static_cast<int>(hn::Lanes(d))) {
        const auto u = hn::Load(d, samples.u + k), v = hn::Load(d, samples.v + k);
        const auto du = hn::Sub(u, constant(m.u0)), dv = hn::Sub(v, constant(m.v0));
        // Where samples have parts of the sheet, from the middle of the sheet, and of these parts, in sheets.
        const auto away = samples.at ? hn::Sub(hn::Load(d, samples.at + k), constant(samples.step)) : zero;
        const auto part = samples.part ? hn::Load(d, samples.part + k) : one;
        const auto place = [&](int i) HWY_ATTR {
            const auto inMiddle =
                hn::MulAdd(du, constant(m.perU[i]), hn::MulAdd(dv, constant(m.perV[i]), constant(m.at[i])));
            return hn::MulAdd(away, constant(m.perN[i]), inMiddle);
        };
        // No light behind the light, or too close to it for floats.
        const auto w = place(2);
        const auto lit = hn::Gt(w, constant(1e-12));
        const auto inverse = hn::Div(one, hn::IfThenElse(lit, w, one));
        // Positions further away cannot be distinguished, and their squares must stay finite.
        const auto far = constant(1e7);
        const auto x = hn::Max(hn::Min(hn::Mul(place(0), inverse), far), hn::Neg(far));
        const auto y = hn::Max(hn::Min(hn::Mul(place(1), inverse), far), hn::Neg(far));

        // The footprint's three edges: a step to either neighbour, and the eye's path through the sheet.
        const auto toTexels = constant(slopeToTexels);
        const auto slopeU = hn::Mul(hn::Load(d, samples.eyeA + k), toTexels);
        const auto slopeV = hn::Mul(hn::Load(d, samples.eyeB + k), toTexels);
        const auto t = hn::MulAdd(u, constant(spacing.tu), hn::MulAdd(v, constant(spacing.tv), constant(spacing.t0)));
        auto xx = zero, xy = zero, yy = zero;
        const auto include = [&](VF edgeU, VF edgeV, VF edgeN) HWY_ATTR {
            const auto edge = combined(m, edgeU, edgeV, edgeN);
            const auto ex = hn::Max(hn::Min(moved(edge.x, edge.w, x, inverse), far), hn::Neg(far));
            const auto ey = hn::Max(hn::Min(moved(edge.y, edge.w, y, inverse), far), hn::Neg(far));
            xx = hn::MulAdd(ex, ex, xx);
            xy = hn::MulAdd(ex, ey, xy);
            yy = hn::MulAdd(ey, ey, yy);
        };
        for (const Real* step : {spacing.x, spacing.y}) {
            const auto n = constant(step[2]);
            include(hn::Mul(t, hn::NegMulAdd(slopeU, n, constant(step[0]))),
                    hn::Mul(t, hn::NegMulAdd(slopeV, n, constant(step[1]))), zero);
        }
        include(hn::Mul(slopeU, part), hn::Mul(slopeV, part), part);

        storeFootprint({lit, x, y, xx, xy, yy}, k, out);
    }
}

template <SlideOutside kOutside>
HWY_INLINE int placed(int i, int size) {
    if constexpr (kOutside == SlideOutside::repeat) {
        if (static_cast<unsigned>(i) < static_cast<unsigned>(size)) return i;
        const int rest = i % size;
        return rest < 0 ? rest + size : rest;
    }
    return std::min(std::max(i, 0), size - 1);
}

template <SlideOutside kOutside>
HWY_ATTR HWY_INLINE V4 bilinear(const LevelPlace& level, Real x, Real y) {
    const Real ax = level.fx + x * level.scaleX, ay = level.fy + y * level.scaleY;
    const Real floorX = std::floor(ax), floorY = std::floor(ay);
    const int ix = level.x + static_cast<int>(floorX), iy = level.y + static_cast<int>(floorY);
    const auto column = [&](int i) { return 4 * static_cast<std::ptrdiff_t>(placed<kOutside>(i, level.width)); };
    const auto row = [&](int i) {
        return level.pixels + 4 * static_cast<std::ptrdiff_t>(level.width) * placed<kOutside>(i, level.height);
    };
    const std::ptrdiff_t left = column(ix), right = column(ix + 1);
    const float *top = row(iy), *bottom = row(iy + 1);
    return lerp4(lerp4(load4(top + left), load4(top + right), ax - floorX),
                 lerp4(load4(bottom + left), load4(bottom + right), ax - floorX), ay - floorY);
}

// The fraction of a tap's box, along one axis, that lies within the picture.
HWY_INLINE Real within(Real middle, Real box, Real begin, Real end) {
    // It is computed from both borders, so that it is exactly 1 well inside, however small the box.
    const Real left = std::min((middle - begin) / box + Real(0.5), Real(1)),
               right = std::min((end - middle) / box + Real(0.5), Real(1));
    return std::max(left + right - 1, Real(0));
}

struct Levels {
    std::array<LevelPlace, kMostLevels> places;
    int count;
    Real beginX, beginY, endX, endY;  // the picture, relative to the tile's corner
};

// True if the picture is black within `reach` of (x, y) along both axes, by a level of which few
// pixels cover that square.
template <SlideOutside kOutside>
HWY_ATTR bool blackAround(const Levels& levels, Real x, Real y, Real reach) {
    int level;
    std::frexp(std::max(reach, Real(1)), &level);
    const LevelPlace& in = levels.places[std::min(level, levels.count - 1)];
    const auto pixel = [](int whole, Real fraction, Real place) {
        return whole + static_cast<int>(std::floor(fraction + place + Real(0.5)));
    };
    const int left = pixel(in.x, in.fx, (x - reach) * in.scaleX), right = pixel(in.x, in.fx, (x + reach) * in.scaleX);
    const int top = pixel(in.y, in.fy, (y - reach) * in.scaleY), bottom = pixel(in.y, in.fy, (y + reach) * in.scaleY);
    constexpr int kMany = 4;
    if (right - left > kMany || bottom - top > kMany) return false;
    for (int j = top; j <= bottom; ++j)
        for (int i = left; i <= right; ++i) {
            const float* rgb = in.pixels + 4 * (static_cast<std::ptrdiff_t>(in.width) * placed<kOutside>(j, in.height) +
                                                placed<kOutside>(i, in.width));
            if (rgb[0] != 0 || rgb[1] != 0 || rgb[2] != 0) return false;
        }
    return true;
}

// The mean of all taps of sample k.
template <SlideOutside kOutside>
HWY_ATTR V4 tapped(const Levels& levels, const Footprints& prints, int k) {
    const int taps = static_cast<int>(prints.taps[k]);
    // A level's pixel reaches two of its edges to either side, and the coarser of two levels four of the size.
    const Real length = std::max(std::abs(prints.stepX[k]), std::abs(prints.stepY[k]));
    const Real reach = Real(0.5) * prints.taps[k] * length + 4 * std::max(prints.size[k], Real(1));
    if (blackAround<kOutside>(levels, prints.x[k], prints.y[k], reach))
        return each4([](std::size_t) HWY_ATTR { return hn::Zero(D4()); });
    // A size of 2^l needs level l. Between levels, interpolation is linear in the size's mantissa.
    int exponent;
    Real between = 2 * std::frexp(std::max(Real(1), prints.size[k]), &exponent) - 1;
    int level = exponent - 1;
    if (level >= levels.count - 1) {
        level = levels.count - 1;
        between = 0;
    }
    V4 sum = each4([](std::size_t) HWY_ATTR { return hn::Zero(D4()); });
    for (int i = 0; i < taps; ++i) {
        const Real offset = static_cast<Real>(i) - Real(0.5) * static_cast<Real>(taps - 1);
        const Real x = prints.x[k] + offset * prints.stepX[k], y = prints.y[k] + offset * prints.stepY[k];
        Real weight = 1;
        if constexpr (kOutside == SlideOutside::black) {
            weight = within(x, prints.boxX[k], levels.beginX, levels.endX) *
                     within(y, prints.boxY[k], levels.beginY, levels.endY);
            if (weight == 0) continue;
        }
        auto value = bilinear<kOutside>(levels.places[level], x, y);
        if (between > 0) value = lerp4(value, bilinear<kOutside>(levels.places[level + 1], x, y), between);
        weight /= static_cast<Real>(taps);
        sum = each4([&](std::size_t i4)
                        HWY_ATTR { return hn::MulAdd(hn::Set(D4(), weight), value.part[i4], sum.part[i4]); });
    }
    return sum;
}

template <SlideOutside kOutside>
HWY_ATTR bool tintWith(const Levels& levels, const Footprints& prints, Real* tint) {
    Real most = 0;
    for (int k = 0; k < kTileSize; ++k) {
        alignas(32) Real value[4] = {0, 0, 0, 0};
        if (prints.taps[k] > 0) {
            store4(tapped<kOutside>(levels, prints, k), value);
            most = std::max({most, value[0], value[1], value[2]});
        }
        for (int c = 0; c < 3; ++c) tint[c * kTileSize + k] = value[c];
    }
    return most > 0;
}

HWY_ATTR bool tintTileOnTarget(const SheetSlide& slide, const SampleTile& samples, Real slopeToTexels, Real* tint) {
    const TileMap map = tileMap(slide, samples.u[0], samples.v[0]);
    Footprints prints;
    layFootprints(map, samples, slopeToTexels, prints);

    const Texture& image = *slide.image;
    Levels levels;
    levels.count = static_cast<int>(std::min(image.levels().size(), kMostLevels));
    levels.beginX = static_cast<Real>(-map.cornerX);
    levels.beginY = static_cast<Real>(-map.cornerY);
    levels.endX = static_cast<Real>(image.width() - map.cornerX);
    levels.endY = static_cast<Real>(image.height() - map.cornerY);
    for (int i = 0; i < levels.count; ++i) {
        const Texture::Level& level = image.levels()[i];
        LevelPlace& place = levels.places[i];
        place.pixels = level.rgba.data();
        place.width = level.width;
        place.height = level.height;
        splitPlace(map.cornerX, image.width(), level.width, slide.outside, place.x, place.fx, place.scaleX);
        splitPlace(map.cornerY, image.height(), level.height, slide.outside, place.y, place.fy, place.scaleY);
    }
    switch (slide.outside) {
        case SlideOutside::black:
            return tintWith<SlideOutside::black>(levels, prints, tint);
        case SlideOutside::clamp:
            return tintWith<SlideOutside::clamp>(levels, prints, tint);
        case SlideOutside::repeat:
            break;
    }
    return tintWith<SlideOutside::repeat>(levels, prints, tint);
}

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scrim {

HWY_EXPORT(tintTileOnTarget);

bool tintTile(const SheetSlide& slide, const SampleTile& samples, Real slopeToTexels, Real* tint) {
    return SCRIM_ON_TARGET(slide.simd, tintTileOnTarget)(slide, samples, slopeToTexels, tint);
}

}  // namespace scrim
#endif
