// SPDX-License-Identifier: Apache-2.0
#include <scrim/study/study.h>

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/engine/sweep.h>
#include <scrim/scene/quality.h>
#include <scrim/study/convergence_order.h>
#include <scrim/engine/plan/make_plan.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>

#include <fmt/format.h>

namespace scrim {
namespace {

using Clock = std::chrono::steady_clock;

constexpr unsigned kPixelSeed = 1;
// The error's interval is examined after this many pixels.
constexpr std::size_t kPixelsAtATime = 64, kLeastPixels = 128;
// Fractions of the budget: the most that the reference may take, the most that each setting may take, the most that the
// first render of all settings may take, and the time after which no pictures are made.
constexpr double kReferencePart = 0.25, kTrialPart = 0.08, kFirstRoundPart = 0.65, kPicturesPart = 0.8;
// Other kernels need references of their own, and only serve comparison, so fewer pixels suffice.
constexpr std::size_t kOtherKernelPixels = 128;

class Run {
  public:
    Run(const SceneWith& sceneWith, const Dials& base, const StudyOptions& options, const ProgressSink& progress)
        : m_sceneWith(sceneWith), m_base(base), m_options(options), m_progress(progress) {}

    Study study();

  private:
    double spent() const { return std::chrono::duration<double>(Clock::now() - m_start).count(); }
    bool past(double part) const { return m_options.budget > 0 && spent() > part * m_options.budget; }
    void report(double done);
    void goOn() const;

    std::vector<VerifiedPixel> reference(const ViewScene& truth, const Image& image);
    ViewScene truthWith(Dials dials) const;
    Plan planOf(const ViewScene& scene) const;
    void renderBase();
    Image timedRender(const ViewScene& scene, Trial& trial) const;
    bool affordable(double seconds) const;
    double expected(const Dials& dials) const;
    void tryOnce(Trial& trial);
    void tryAll(std::size_t first, double from, double to);
    void repeat();
    void findOrders();
    void drawErrors();

    const SceneWith& m_sceneWith;
    const Dials m_base;
    const StudyOptions& m_options;
    const ProgressSink& m_progress;
    const Clock::time_point m_start = Clock::now();
    Study m_study;
    std::map<Kernel, std::vector<VerifiedPixel>> m_truth;
    double m_shown = 0;          // the last progress reported
    double m_scale = 1;          // ratio of measured to expected time
    double m_referenceTime = 0;  // seconds per pixel
};

void Run::report(double done) {
    m_shown = m_options.budget > 0 ? std::min(1.0, spent() / m_options.budget) : done;
    goOn();
}

void Run::goOn() const {
    if (m_progress && !m_progress(m_shown)) throw Error(ErrorKind::interrupted, "the study was interrupted");
}

Image Run::timedRender(const ViewScene& scene, Trial& trial) const {
    const auto begin = Clock::now();
    Frame frame = render(scene, planOf(scene));
    trial.seconds.push_back(std::chrono::duration<double>(Clock::now() - begin).count());
    trial.work = frame.work;
    return std::move(frame.image);
}

// Draws pixels of `image` and evaluates their references until the error is known well enough or time is up.
std::vector<VerifiedPixel> Run::reference(const ViewScene& truth, const Image& image) {
    SampleOptions options;
    options.count = m_options.mostPixels;
    options.seed = kPixelSeed;
    options.progress = [this](double done) {
        report(0.1 * done);
        return true;
    };
    options.enough = [this](const PixelSample& sample) {
        if (past(kReferencePart)) return true;
        if (sample.pixels.size() < kLeastPixels || sample.pixels.size() % kPixelsAtATime != 0) return false;
        const Verification v = summarise(sample);
        return v.pixels > 0 && v.upper - v.lower < 2 * m_options.intervalWanted * v.error;
    };
    return samplePixels(truth, image, options).pixels;
}

ViewScene Run::truthWith(Dials dials) const {
    dials.lod = 0;
    return m_options.truth ? m_options.truth(dials) : m_sceneWith(dials);
}

Plan Run::planOf(const ViewScene& scene) const {
    return makePlan(scene, threadCount(), [this](double) {
        goOn();
        return true;
    });
}

void Run::renderBase() {
    Trial& trial = m_study.trials.front();
    const Image image = timedRender(m_sceneWith(m_base), trial);
    const double before = spent();
    std::vector<VerifiedPixel> pixels = reference(truthWith(m_base), image);
    const Verification v = summarise(pixels);
    if (v.pixels == 0) throw Error(ErrorKind::render, "there is nothing to study: the picture is empty");
    m_referenceTime = (spent() - before) / double(pixels.size());
    m_study.meanReference = v.mean;
    m_study.pixels = v.pixels;
    m_truth[m_base.kernel] = std::move(pixels);
    trial.seconds.clear();  // the first render maps memory pages that later renders reuse, so its time does not count
}

bool Run::affordable(double seconds) const {
    return m_options.budget == 0 ||
           (seconds < kTrialPart * m_options.budget && spent() + seconds < kFirstRoundPart * m_options.budget);
}

double Run::expected(const Dials& dials) const {
    const ViewScene scene = m_sceneWith(dials);
    return expectedSeconds(scene, planOf(scene), threadCount());
}

void Run::tryOnce(Trial& trial) {
    const double expectedTime = expected(trial.dials);
    std::vector<VerifiedPixel>& truth = m_truth[trial.dials.kernel];
    const std::size_t missing = truth.empty() ? std::min(m_truth[m_base.kernel].size(), kOtherKernelPixels) : 0;
    const double seconds = expectedTime * m_scale + double(missing) * m_referenceTime;
    if (&trial != &m_study.trials.front() && !affordable(seconds)) {
        trial.skipped = fmt::format("it would take about {:.2g} s, more than the budget has left for it", seconds);
        m_study.outOfTime = true;
        return;
    }
    const Image image = timedRender(m_sceneWith(trial.dials), trial);
    m_scale = trial.seconds.back() / expectedTime;
    if (missing > 0) {
        truth = m_truth[m_base.kernel];
        truth.resize(missing);
        evaluateReferences(truthWith(trial.dials), truth);
    }
    trial.seen = truth;
    setRendered(trial.seen, image);
    trial.error = summarise(trial.seen);
    trial.run = true;
}

// Tries the fastest settings first, so that a budget leaves out as few as possible, and settings
// with other kernels, which need references of their own, last.
void Run::tryAll(std::size_t first, double from, double to) {
    std::vector<Trial>& trials = m_study.trials;
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = first; i < trials.size(); ++i) {
        const double last = trials[i].dials.kernel == m_base.kernel ? 0 : 1e9;
        order.emplace_back(last + expected(trials[i].dials), i);
    }
    std::sort(order.begin(), order.end());
    double done = 0;
    for (const auto& [time, i] : order) {
        tryOnce(trials[i]);
        report(from + (to - from) * ++done / double(order.size()));
    }
}

// Repeats the renders round after round, so that a machine whose speed drifts does not bend the curves.
void Run::repeat() {
    for (int round = 1; round < m_options.repeats; ++round) {
        double done = 0;
        for (Trial& trial : m_study.trials) {
            ++done;
            if (!trial.run) continue;
            if (m_options.budget > 0 && spent() + trial.time() > 0.97 * m_options.budget) {
                m_study.outOfTime = true;
                continue;  // a faster setting may still fit
            }
            timedRender(m_sceneWith(trial.dials), trial);
            report(0.5 + 0.45 * (round - 1 + done / double(m_study.trials.size())) / (m_options.repeats - 1));
        }
    }
}

// RMS distance from the finest picture over the first `counted` reference pixels that show
// something. It does not contain the error of other dials.
double distance(const Trial& a, const Trial& b, int counted) {
    double squares = 0;
    for (std::size_t i = 0; i < a.seen.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c) squares += std::pow(a.seen[i].rendered[c] - b.seen[i].rendered[c], 2);
    return std::sqrt(squares / (3.0 * counted));
}

void Run::findOrders() {
    for (DialSweep& sweep : m_study.sweeps) {
        if (sweep.sizes.empty() || sweep.dial == "lod") continue;  // lod changes in whole levels
        std::vector<DialDistance> distances;
        const Trial* finest = nullptr;
        double finestSize = 0;
        sweep.distances.assign(sweep.trials.size(), 0);
        for (std::size_t i = 0; i < sweep.trials.size(); ++i) {
            const Trial& trial = m_study.trials[sweep.trials[i]];
            if (!trial.run) continue;
            if (!finest) {
                finest = &trial;
                finestSize = sweep.sizes[i];
            }
            sweep.distances[i] = distance(trial, *finest, m_study.pixels) / m_study.meanReference;
            distances.push_back({sweep.sizes[i], sweep.distances[i]});
        }
        sweep.order = convergenceOrder(distances, finestSize);
    }
}

// Error pictures show the difference from the most accurate picture, since the reference only covers single pixels.
void Run::drawErrors() {
    m_study.best = m_study.front.back();
    if (past(kPicturesPart)) return;
    const auto rendered = [&](std::size_t trial) {
        const ViewScene scene = m_sceneWith(m_study.trials[trial].dials);
        return render(scene, planOf(scene)).image;
    };
    m_study.picture = rendered(m_study.best);
    report(0.5);
    for (const auto& [name, trial] : m_study.presets) {
        if (!m_study.trials[trial].run || trial == m_study.best || past(kPicturesPart)) continue;
        if (static_cast<int>(m_study.errorPictures.size()) == m_options.mostPictures) break;
        Image difference = rendered(trial);
        for (std::size_t i = 0; i < difference.rgba.size(); ++i)
            difference.rgba[i] = i % 4 == 3 ? m_study.picture.rgba[i] : difference.rgba[i] - m_study.picture.rgba[i];
        m_study.errorPictures.push_back({name, trial, std::move(difference)});
    }
}

Study Run::study() {
    m_study.threads = threadCount();
    const ViewScene base = m_sceneWith(m_base);
    m_study.sweeps = dialSweeps(anyScattersFully(base));
    addTrial(m_study.trials, "the scene's own", m_base);
    renderBase();
    for (const std::string& name : presetNames())
        m_study.presets.emplace_back(
            name, addTrial(m_study.trials, name, m_options.preset ? m_options.preset(name) : *presetDials(name)));
    addSweeps(m_study.trials, m_study.sweeps, m_base);
    addJoint(m_study.trials, m_base);
    tryAll(0, 0.1, 0.35);
    const std::size_t joined = m_study.trials.size();
    addNeighbours(m_study.trials, m_study.sweeps, markFront(m_study.trials, m_base.kernel));
    tryAll(joined, 0.35, 0.5);
    m_study.front = markFront(m_study.trials, m_base.kernel);
    findOrders();
    drawErrors();
    repeat();
    shareTimes(m_study.trials);
    m_study.front = markFront(m_study.trials, m_base.kernel);
    m_study.spent = spent();
    report(1);
    return std::move(m_study);
}

// The index of `base` in a sweep, if it is part of it.
std::optional<std::size_t> placeOfBase(const DialSweep& sweep) {
    const auto at = std::find(sweep.trials.begin(), sweep.trials.end(), std::size_t{0});
    if (at == sweep.trials.end()) return std::nullopt;
    return std::size_t(at - sweep.trials.begin());
}

constexpr double kSameError = 1.05;  // with some hundred pixels, smaller changes are noise

std::string verdictOn(const Trial& base, const Trial* finer, const Trial* coarser) {
    const auto error = [&](const Trial& t) { return t.error.error / std::max(base.error.error, 1e-12); };
    const auto change = [&](const Trial& t) {
        if (t.work == base.work) return fmt::format("error x{:.2f}, the same work", error(t));
        const bool differs = isSlower(t, base) || isSlower(base, t);
        return fmt::format("error x{:.2f}, {}", error(t),
                           differs ? fmt::format("time x{:.2f}", t.time() / base.time()) : "about the same time");
    };
    const bool pays = finer && error(*finer) < 1 / kSameError;
    const bool wasted = coarser && error(*coarser) < kSameError && isSlower(base, *coarser);
    std::string text = pays ? "finer pays" : wasted ? "coarser would do" : "as it should be";
    if (finer) text += "; finer: " + change(*finer);
    if (coarser) text += "; coarser: " + change(*coarser);
    return text;
}

}  // namespace

Study runStudy(const SceneWith& sceneWith, const Dials& base, const StudyOptions& options,
               const ProgressSink& progress) {
    return Run(sceneWith, base, options, progress).study();
}

std::vector<Recommendation> recommendations(const Study& study) {
    std::vector<Recommendation> all;
    for (const double tolerance : {0.05, 0.02, 0.01, 0.005, 0.002})
        all.push_back({tolerance, cheapestWithin(study.trials, study.trials.front().dials.kernel, tolerance)});
    return all;
}

std::vector<DialWorth> worthOfDials(const Study& study) {
    const auto at = [&](const DialSweep& sweep, std::size_t place) -> std::optional<std::size_t> {
        if (place >= sweep.trials.size() || !study.trials[sweep.trials[place]].run) return std::nullopt;
        return sweep.trials[place];
    };
    const auto trial = [&](const std::optional<std::size_t>& place) { return place ? &study.trials[*place] : nullptr; };
    std::vector<DialWorth> all;
    for (const DialSweep& sweep : study.sweeps) {
        const std::optional<std::size_t> base = placeOfBase(sweep);
        if (!base || sweep.dial == "kernel") continue;
        DialWorth worth{sweep.dial, *base > 0 ? at(sweep, *base - 1) : std::nullopt, at(sweep, *base + 1), {}};
        if (!worth.finer && !worth.coarser) continue;
        worth.verdict = verdictOn(study.trials.front(), trial(worth.finer), trial(worth.coarser));
        all.push_back(std::move(worth));
    }
    return all;
}

}  // namespace scrim
