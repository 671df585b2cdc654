// SPDX-License-Identifier: Apache-2.0
#include <scrim/verify/verify_pixels.h>

#include <scrim/base/parallel.h>
#include <scrim/volume/kernel.h>
#include <scrim/base/split_mix.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>

#include <glm/matrix.hpp>

namespace scrim {
namespace {

// The box of a field, kernel included, and the eye's rays in the field's index space.
struct BoxTest {
    Bounds isBox;
    RayFamily isRays;

    bool meets(double x, double y) const {
        const auto [begin, end] = isBox.clip(isRays.origin(x, y), isRays.direction(x, y), isRays.near,
                                             std::numeric_limits<double>::infinity());
        return begin <= end;
    }
};

std::vector<BoxTest> boxTests(const ViewScene& scene) {
    const RayFamily ws = wsRays(scene.camera);
    std::vector<BoxTest> tests;
    for (const ViewVolume& volume : scene.volumes)
        for (const ViewField& field : fieldsOf(volume)) {
            const Mat4 isFromWs = glm::inverse(field.wsFromIs);
            const Mat3 linear(isFromWs);
            BoxTest& test = tests.emplace_back();
            test.isBox = field.field->isBounds();
            const double radius = kernelRadius(field.kernel.value_or(scene.dials.kernel));
            test.isBox.lower -= radius;
            test.isBox.upper += radius;
            if (volume.velocity) {
                Bounds ways;
                for (const Vec3& way : volume.velocity->wsRange().corners()) ways.include(linear * way);
                test.isBox.lower += ways.lower;
                test.isBox.upper += ways.upper;
            }
            test.isRays = {transformPoint(isFromWs, ws.origin0),
                           linear * ws.originX,
                           linear * ws.originY,
                           linear * ws.direction0,
                           linear * ws.directionX,
                           linear * ws.directionY,
                           ws.near};
        }
    return tests;
}

bool shows(const Image& image, int x, int y) {
    if (!image.window.contains(x, y)) return false;
    const float* rgba = image.rgba.data() + image.indexOf(x, y);
    return std::any_of(rgba, rgba + 4, [](float v) { return v != 0; });  // a NaN counts as shown
}

// The corner of the square that holds a pixel.
Int2 squareCorner(const Int2& pixel, int edge) {
    const auto down = [&](int v) { return v - ((v % edge) + edge) % edge; };
    return {down(pixel.x), down(pixel.y)};
}

// Spreads the bits of x to the even places.
std::uint64_t spread(std::uint32_t x) {
    std::uint64_t v = x;
    v = (v | v << 16) & 0x0000ffff0000ffff;
    v = (v | v << 8) & 0x00ff00ff00ff00ff;
    v = (v | v << 4) & 0x0f0f0f0f0f0f0f0f;
    v = (v | v << 2) & 0x3333333333333333;
    return (v | v << 1) & 0x5555555555555555;
}

// The i-th point of a scrambled van der Corput sequence, in steps of 2^-bits. As a function of i it
// is a permutation of [0, 2^bits).
std::uint64_t scrambledPoint(std::uint64_t i, int bits, std::uint64_t seed) {
    std::uint64_t point = 0;
    for (int b = 0; b < bits; ++b) {
        // Each node of the binary tree either swaps its halves or does not.
        const std::uint64_t node = std::uint64_t{1} << b | point;
        point = point << 1 | ((i >> b & 1) ^ (splitMix(splitMix(seed) ^ node) & 1));
    }
    return point;
}

}  // namespace

std::vector<Int2> verificationOrder(const ViewScene& truth, const Image& image, unsigned seed, int edge) {
    const PixelWindow& region = truth.region;
    std::vector<BoxTest> tests = boxTests(truth);
    if (truth.moments) {
        // The number of moments at which boxes are tested: steps of about a pixel, since anything
        // closer to a box than that may show in the picture.
        const int steps = std::clamp(static_cast<int>(truth.moments->path), 4, 64);
        for (int i = 0; i <= steps; ++i) {
            const double part = static_cast<double>(i) / steps;
            const double t = (1 - part) * truth.moments->open + part * truth.moments->close;
            for (int rim = 0; rim < (truth.moments->lens ? 9 : 1); ++rim) {
                const double angle = 0.25 * std::numbers::pi * rim;
                const Vec2 place = rim == 0 ? Vec2(0) : Vec2(std::cos(angle), std::sin(angle));
                for (const BoxTest& test : boxTests(truth.moments->at({t, place}))) tests.push_back(test);
            }
        }
    }
    const int n = truth.dials.antialias;
    const auto mayShow = [&](int x, int y) {
        for (const BoxTest& test : tests)
            for (int j = 0; j < n; ++j)
                for (int i = 0; i < n; ++i)
                    if (test.meets(x + (i + 0.5) / n, y + (j + 0.5) / n)) return true;
        return shows(image, x, y);
    };
    std::vector<std::vector<int>> rows(std::size_t(region.height()));
    parallelFor(rows.size(), [&](std::size_t row) {
        for (int x = region.x0; x < region.x1; ++x)
            if (mayShow(x, region.y0 + static_cast<int>(row))) rows[row].push_back(x);
    });
    std::vector<Int2> alongCurve;
    for (std::size_t row = 0; row < rows.size(); ++row)
        for (const int x : rows[row]) alongCurve.push_back(squareCorner({x, region.y0 + static_cast<int>(row)}, edge));
    const Int2 first = squareCorner({region.x0, region.y0}, edge);
    const auto place = [&](const Int2& p) {
        const Int2 at = (p - first) / edge;
        return spread(static_cast<std::uint32_t>(at.x)) | spread(static_cast<std::uint32_t>(at.y)) << 1;
    };
    std::sort(alongCurve.begin(), alongCurve.end(), [&](const Int2& a, const Int2& b) { return place(a) < place(b); });
    alongCurve.erase(std::unique(alongCurve.begin(), alongCurve.end()), alongCurve.end());

    const std::size_t count = alongCurve.size();
    const int bits = count > 1 ? static_cast<int>(std::bit_width(count - 1)) : 0;
    std::vector<Int2> order;
    order.reserve(count);
    for (std::uint64_t i = 0; i < std::uint64_t{1} << bits && order.size() < count; ++i)
        if (const std::uint64_t at = scrambledPoint(i, bits, seed); at < count) order.push_back(alongCurve[at]);
    return order;
}

}  // namespace scrim
