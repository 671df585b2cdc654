// SPDX-License-Identifier: Apache-2.0
#include <scrim/verify/verify.h>

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/scene/quality.h>
#include <scrim/verify/moments_reference.h>
#include <scrim/verify/verify_pixels.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>

namespace scrim {
namespace {

constexpr double kLeastAlpha = 1e-3;        // pixels below this count only if they shine
constexpr double kLeastLight = 1e-3;        // relative to the brightest reference
constexpr std::size_t kPixelsPerStep = 16;  // between two reports of progress
constexpr double kOfLimit = 0.05;           // part of a limit that a step of several pixels may take
constexpr double kAnnounceAfter = 0.5;      // seconds after the start of a verification
constexpr double kInfinity = std::numeric_limits<double>::infinity();

double mostLight(const std::array<double, 4>& rgba) {
    return std::max({rgba[0], rgba[1], rgba[2]});
}

double brightestOf(std::span<const VerifiedPixel> pixels) {
    double brightest = 0;
    for (const VerifiedPixel& p : pixels) brightest = std::max(brightest, mostLight(p.reference));
    return brightest;
}

bool isFinite(const std::array<double, 4>& rgba) {
    return std::all_of(rgba.begin(), rgba.end(), [](double v) { return std::isfinite(v); });
}

bool counts(const VerifiedPixel& p, double brightest) {
    return !isFinite(p.rendered) || std::max(p.reference[3], p.rendered[3]) > kLeastAlpha ||
           std::max(mostLight(p.reference), mostLight(p.rendered)) > kLeastLight * brightest;
}

// The contribution of one pixel: to the sum of squared differences, and to the mean that they are relative to.
struct Term {
    double square = 0, mean = 0;
};

// The terms of all pixels whose relative RMSE is computed.
class RelativeError {
  public:
    explicit RelativeError(std::vector<Term> terms) : m_terms(std::move(terms)) {}

    double value() const { return valueOf(m_terms).error; }
    /// The ends of the interval of `confidence`. `scale` multiplies the deviation that holds for
    /// pixels that are few among many.
    std::array<double, 2> interval(double confidence, double scale) const;
    /// The same for a noisy reference whose variance was subtracted from the squares: noise dominates their spread, and
    /// their sum may even be negative. Noise remains where all pixels were examined.
    std::array<double, 2> noisyInterval(double confidence) const;

  private:
    struct Value {
        double error = 0;
        double logError = 0, deviation = 0;  // of the logarithm of the error; 0: unknown
    };
    template <typename Terms>
    static Value valueOf(const Terms& terms);

    std::vector<Term> m_terms;
};

// The deviation comes from the delta method: error = sqrt(mean square) / mean.
template <typename Terms>
RelativeError::Value RelativeError::valueOf(const Terms& terms) {
    double s = 0, m = 0, ss = 0, sm = 0, mm = 0;
    const auto n = static_cast<double>(terms.size());
    for (const Term& t : terms) {
        s += t.square;
        m += t.mean;
        ss += t.square * t.square;
        sm += t.square * t.mean;
        mm += t.mean * t.mean;
    }
    if (n == 0 || s <= 0) return {};
    if (!(m > 0) || !std::isfinite(s)) return {kInfinity, kInfinity, 0};
    s /= n;
    m /= n;
    const double error = std::sqrt(s) / m;
    const double variance = ((ss / n / (s * s) - 1) / 4 - (sm / n / (s * m) - 1) + (mm / n / (m * m) - 1)) / n;
    return {error, std::log(error), std::sqrt(std::max(variance, 0.0))};
}

// Bootstrap-t of the logarithm (B. Efron and R. Tibshirani, An Introduction to the Bootstrap, ch. 12). Squared errors
// have long tails, and percentiles of plain resamples would give an upper end that is too low.
std::array<double, 2> RelativeError::interval(double confidence, double scale) const {
    const Value own = valueOf(m_terms);
    if (own.deviation == 0 || scale == 0 || m_terms.size() < 2) return {own.error, own.error};
    constexpr double kWork = 2e7;  // most terms that are drawn
    const auto n = m_terms.size();
    const auto count = std::size_t(std::clamp(kWork / double(n), 200.0, 4000.0));
    std::mt19937_64 random(1);
    std::vector<double> pivots;
    std::vector<Term> drawn(n);
    for (std::size_t b = 0; b < count; ++b) {
        for (Term& term : drawn) term = m_terms[random() % n];
        const Value other = valueOf(drawn);
        if (other.deviation > 0) pivots.push_back((other.logError - own.logError) / other.deviation);
    }
    if (pivots.empty()) return {own.error, own.error};
    std::sort(pivots.begin(), pivots.end());
    const double tail = 0.5 * (1 - confidence);
    const auto at = [&](double part) {
        return pivots[std::size_t(std::clamp(part * double(pivots.size()), 0.0, double(pivots.size() - 1)))];
    };
    const double step = scale * own.deviation;
    return {own.error * std::exp(std::min(-step * at(1 - tail), 0.0)),
            own.error * std::exp(std::max(-step * at(tail), 0.0))};
}

// Bootstrap of the mean square (Efron and Tibshirani, ch. 13), which may have either sign.
std::array<double, 2> RelativeError::noisyInterval(double confidence) const {
    const auto n = m_terms.size();
    double square = 0, mean = 0;
    for (const Term& t : m_terms) {
        square += t.square / double(n);
        mean += t.mean / double(n);
    }
    if (!(mean > 0) || !std::isfinite(square) || n < 2) return interval(confidence, 1);
    constexpr int kCount = 1000;
    std::mt19937_64 random(1);
    std::vector<double> drawn(kCount, 0.0);
    for (double& sum : drawn)
        for (std::size_t i = 0; i < n; ++i) sum += m_terms[random() % n].square / double(n);
    std::sort(drawn.begin(), drawn.end());
    const double tail = 0.5 * (1 - confidence);
    const auto farFrom = [&](double part) { return drawn[std::size_t(part * (kCount - 1))] - square; };
    // Squares have long tails, so each end uses the larger distance that resamples reach on either side.
    const double away = std::max(farFrom(1 - tail), -farFrom(tail));
    return {std::sqrt(std::max(square - away, 0.0)) / mean, std::sqrt(std::max(square, 0.0) + away) / mean};
}

Verification summary(std::span<const VerifiedPixel> pixels, std::size_t candidates, double confidence) {
    Verification v;
    v.looked = pixels.size();
    v.complete = candidates > 0 && pixels.size() == candidates;
    const double brightest = brightestOf(pixels);
    std::vector<Term> colour, alpha;
    double signedSum = 0, mean = 0;
    bool noisy = false;
    for (const VerifiedPixel& p : pixels) {
        if (!counts(p, brightest)) continue;
        noisy = noisy || p.variance != std::array<double, 3>{};
        Term c, a;
        for (std::size_t k = 0; k < 3; ++k) {
            const double e = p.rendered[k] - p.reference[k];
            c.square += (e * e - p.variance[k]) / 3;
            c.mean += p.reference[k] / 3;
            signedSum += e / 3;
        }
        a.square = (p.rendered[3] - p.reference[3]) * (p.rendered[3] - p.reference[3]);
        a.mean = p.reference[3];
        if (!isFinite(p.rendered)) c.square = a.square = kInfinity;
        // If nothing is lit, what shines in the picture is measured relative to opacity.
        if (brightest == 0) c.mean = a.mean;
        mean += c.mean;
        if (c.square >= v.worst) {
            v.worst = c.square;
            v.worstX = p.x;
            v.worstY = p.y;
        }
        colour.push_back(c);
        alpha.push_back(a);
    }
    v.pixels = static_cast<int>(colour.size());
    if (colour.empty()) return v;
    v.mean = mean / v.pixels;
    v.bias = mean > 0 ? signedSum / mean : 0;
    v.worst = mean > 0 ? std::sqrt(v.worst) / v.mean : v.worst > 0 ? kInfinity : 0;
    // The error of a picture that was examined completely is known.
    const double left = candidates > 0 ? 1 - double(pixels.size()) / double(candidates) : 1;
    const RelativeError ofColour(std::move(colour)), ofAlpha(std::move(alpha));
    v.error = ofColour.value();
    v.alphaError = ofAlpha.value();
    const double scale = std::sqrt(left);
    std::array<double, 2> ends = noisy ? ofColour.noisyInterval(confidence) : ofColour.interval(confidence, scale);
    const std::array<double, 2> alphaEnds = ofAlpha.interval(confidence, scale);
    v.alphaUpper = alphaEnds[1];
    if (brightest == 0 && v.alphaError > v.error) {
        v.error = v.alphaError;
        ends = alphaEnds;
    }
    v.lower = ends[0];
    v.upper = ends[1];
    return v;
}

}  // namespace

int verifiedEdge(const ViewScene& truth) {
    return anyScattersFully(truth) ? kScatteringMean : 1;
}

PixelSample samplePixels(const ViewScene& truth, const Image& image, const SampleOptions& options) {
    using Clock = std::chrono::steady_clock;
    const auto start = Clock::now();
    const auto spent = [&] { return std::chrono::duration<double>(Clock::now() - start).count(); };
    PixelSample sample;
    if (options.count <= 0) return sample;
    const int edge = verifiedEdge(truth);
    const std::vector<Int2> order = verificationOrder(truth, image, options.seed, edge);
    sample.candidates = order.size();
    MomentsReference reference(truth);
    const auto wanted = std::size_t(options.count);
    const double prepared = spent();
    bool announced = false;
    std::size_t counted = 0, judged = 0;  // among the first `judged` pixels
    double brightest = 0;
    const std::size_t few = std::min(std::size_t(std::max(threadCount(), 1)), kPixelsPerStep);
    const auto late = [&] { return options.seconds > 0 && spent() > options.seconds; };
    for (std::size_t first = 0, step = 0; first < order.size() && counted < wanted; first += step) {
        // With a limit there are steps of few pixels where one takes long, so that few are lost at the end.
        const double perPixel = (spent() - prepared) / double(std::max<std::size_t>(first, 1));
        const bool slow = options.seconds > 0 && (first == 0 || perPixel * kPixelsPerStep > kOfLimit * options.seconds);
        step = std::min(slow ? few : kPixelsPerStep, order.size() - first);
        for (std::size_t i = first; i < first + step; ++i)
            sample.pixels.push_back({order[i].x, order[i].y, {}, {}, {}, edge});
        const std::span<VerifiedPixel> fresh = std::span(sample.pixels).subspan(first);
        if (!reference.evaluate(fresh, late)) {
            sample.pixels.resize(first);
            sample.outOfTime = true;
            break;
        }
        setRendered(fresh, image);
        if (const double now = std::max(brightest, brightestOf(fresh)); now > brightest) {
            brightest = now;  // pixels that counted relative to the former brightest may no longer count
            counted = judged = 0;
        }
        for (; judged < sample.pixels.size() && counted < wanted; ++judged)
            counted += counts(sample.pixels[judged], brightest) ? 1 : 0;
        sample.pixels.resize(judged);
        const double done = std::max(double(counted) / double(wanted), double(first + step) / double(order.size()));
        // The first pixels are excluded from the estimate, because caches are cold then.
        if (!announced && options.announce && spent() - prepared > kAnnounceAfter) {
            announced = true;
            options.announce(prepared + (spent() - prepared) / done);
        }
        if (options.progress && !options.progress(std::min(done, 1.0)))
            throw Error(ErrorKind::interrupted, "the verification was interrupted");
        if (late() && counted < wanted) {
            sample.outOfTime = sample.pixels.size() < order.size();
            break;
        }
        if (options.enough && options.enough(sample)) break;
    }
    return sample;
}

std::vector<VerifiedPixel> countedPixels(const PixelSample& sample) {
    const double brightest = brightestOf(sample.pixels);
    std::vector<VerifiedPixel> out;
    std::copy_if(sample.pixels.begin(), sample.pixels.end(), std::back_inserter(out),
                 [&](const VerifiedPixel& p) { return counts(p, brightest); });
    return out;
}

PixelSample samplePixels(const ViewScene& truth, const Image& image, int count, unsigned seed,
                         const ProgressSink& progress) {
    SampleOptions options;
    options.count = count;
    options.seed = seed;
    options.progress = progress;
    return samplePixels(truth, image, options);
}

void evaluateReferences(const ViewScene& truth, std::span<VerifiedPixel> pixels, const ProgressSink& progress) {
    MomentsReference reference(truth);
    for (std::size_t first = 0; first < pixels.size(); first += kPixelsPerStep) {
        const std::size_t step = std::min(kPixelsPerStep, pixels.size() - first);
        reference.evaluate(pixels.subspan(first, step));
        if (progress && !progress(double(first + step) / double(pixels.size())))
            throw Error(ErrorKind::interrupted, "the verification was interrupted");
    }
}

void setRendered(std::span<VerifiedPixel> pixels, const Image& image) {
    for (VerifiedPixel& p : pixels) {
        p.rendered = {};
        int count = 0;
        for (int y = p.y; y < p.y + p.edge; ++y)
            for (int x = p.x; x < p.x + p.edge; ++x) {
                if (!image.window.contains(x, y)) continue;
                ++count;
                const float* rgba = image.rgba.data() + image.indexOf(x, y);
                for (std::size_t c = 0; c < 4; ++c) p.rendered[c] += double(rgba[c]);
            }
        for (double& value : p.rendered) value /= std::max(count, 1);
    }
}

Verification summarise(const PixelSample& sample, double confidence) {
    return summary(sample.pixels, sample.candidates, confidence);
}

Verification summarise(std::span<const VerifiedPixel> pixels, double confidence) {
    return summary(pixels, 0, confidence);
}

}  // namespace scrim
