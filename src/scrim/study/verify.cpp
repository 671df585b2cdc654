// SPDX-License-Identifier: Apache-2.0
#include <scrim/study/verify.h>

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/study/reference.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace scrim {
namespace {

constexpr double kLeastAlpha = 1e-3;  // pixels of the reference below this do not count
constexpr int kBootstraps = 2000;
constexpr std::size_t kPixelsPerStep = 16;  // between two reports of progress

struct Difference {
    double square = 0;  // mean over R, G, B of the squared difference
    double signedSum = 0;
    double mean = 0;  // of the reference over R, G, B
};

Difference difference(const VerifiedPixel& p) {
    Difference d;
    for (std::size_t c = 0; c < 3; ++c) {
        const double e = p.rendered[c] - p.reference[c];
        d.square += e * e / 3;
        d.signedSum += e / 3;
        d.mean += p.reference[c] / 3;
    }
    return d;
}

double relativeError(double squares, double mean, double count) {
    return mean > 0 ? std::sqrt(squares / count) / (mean / count) : 0.0;
}

}  // namespace

std::vector<VerifiedPixel> drawPixels(const Image& image, int count, unsigned seed) {
    // Candidates: what the picture shows, and a little less, so that pixels it wrongly lost may show up.
    std::vector<VerifiedPixel> pixels;
    const PixelWindow& window = image.window;
    for (int y = window.y0; y < window.y1; ++y)
        for (int x = window.x0; x < window.x1; ++x)
            if (image.rgba[image.indexOf(x, y) + 3] > 0.5 * kLeastAlpha) pixels.push_back({x, y, {}, {}});
    // A seeded shuffle of our own: the standard one may differ between libraries.
    std::mt19937 random(seed);
    const std::size_t wanted = std::min(pixels.size(), static_cast<std::size_t>(std::max(count, 0)));
    for (std::size_t i = 0; i < wanted; ++i) std::swap(pixels[i], pixels[i + random() % (pixels.size() - i)]);
    pixels.resize(wanted);
    setRendered(pixels, image);
    return pixels;
}

void evaluateReferences(const ViewScene& scene, std::span<VerifiedPixel> pixels, const ProgressSink& progress) {
    const Reference reference(scene);
    for (std::size_t first = 0; first < pixels.size(); first += kPixelsPerStep) {
        const std::size_t step = std::min(kPixelsPerStep, pixels.size() - first);
        parallelFor(step, [&](std::size_t i) {
            VerifiedPixel& p = pixels[first + i];
            p.reference = reference.pixel(p.x, p.y);
        });
        if (progress && !progress(double(first + step) / double(pixels.size())))
            throw Error(ErrorKind::interrupted, "the verification was interrupted");
    }
}

void setRendered(std::span<VerifiedPixel> pixels, const Image& image) {
    for (VerifiedPixel& p : pixels) {
        const float* rgba = image.rgba.data() + image.indexOf(p.x, p.y);
        std::copy(rgba, rgba + 4, p.rendered.begin());
    }
}

std::vector<VerifiedPixel> samplePixels(const ViewScene& scene, const Image& image, int count, unsigned seed,
                                        const ProgressSink& progress) {
    std::vector<VerifiedPixel> pixels = drawPixels(image, count, seed);
    evaluateReferences(scene, pixels, progress);
    return pixels;
}

Verification summarise(const std::vector<VerifiedPixel>& pixels) {
    std::vector<Difference> differences;
    Verification v;
    double squares = 0, sum = 0, mean = 0;
    for (const VerifiedPixel& p : pixels) {
        if (p.reference[3] <= kLeastAlpha) continue;
        const Difference d = difference(p);
        if (d.square >= v.worst) {
            v.worst = d.square;
            v.worstX = p.x;
            v.worstY = p.y;
        }
        squares += d.square;
        sum += d.signedSum;
        mean += d.mean;
        differences.push_back(d);
    }
    v.pixels = static_cast<int>(differences.size());
    if (differences.empty() || mean <= 0) {
        v.worst = 0;
        return v;
    }
    const auto n = static_cast<double>(differences.size());
    v.error = relativeError(squares, mean, n);
    v.bias = sum / mean;
    v.worst = std::sqrt(v.worst) / (mean / n);

    std::mt19937 random(1);
    std::vector<double> errors(kBootstraps);
    for (double& e : errors) {
        double s = 0, m = 0;
        for (std::size_t i = 0; i < differences.size(); ++i) {
            const Difference& d = differences[random() % differences.size()];
            s += d.square;
            m += d.mean;
        }
        e = relativeError(s, m, n);
    }
    std::sort(errors.begin(), errors.end());
    v.lower = errors[kBootstraps / 40];
    v.upper = errors[kBootstraps - 1 - kBootstraps / 40];
    return v;
}

}  // namespace scrim
