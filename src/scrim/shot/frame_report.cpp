// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/frame_report.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <sys/resource.h>

namespace scrim {
namespace {

using Json = nlohmann::ordered_json;

Json workJson(const RenderWork& w) {
    return {{"voxels_fed", w.voxelsFed},
            {"footprints", w.footprints},
            {"texels_shaded", w.texelsShaded},
            {"samples_shaded", w.shade.samples},
            {"light_samples", w.lightSamples},
            {"light_lookups", w.shade.lightLookups},
            {"slide_lookups", w.shade.slideLookups},
            {"phase_evaluations", w.shade.phases},
            {"octaves", w.shade.octaves},
            {"gradients", w.shade.gradients},
            {"emissions", w.shade.emissions},
            {"ambients", w.shade.ambients},
            {"exponentials", w.shade.exponentials},
            {"pixel_sheets", w.pixelSheets},
            {"layer_samples", w.layerSamples},
            {"solid_rays", w.solidRays},
            {"caught_rays", w.caughtRays},
            {"deep_samples", w.deepSamples},
            {"sheets", w.sheets},
            {"scatter_sweeps", w.scatterSweeps},
            {"light_cell_directions", w.cellDirections},
            {"scatter_cell_directions", w.scatterDirections},
            {"scattered_samples", w.shade.scattered},
            {"buffer_bytes", w.bytes.total()},
            {"bytes",
             {{"fields", w.bytes.fields},
              {"shadows", w.bytes.shadows},
              {"shaded", w.bytes.shaded},
              {"picture", w.bytes.picture},
              {"deep", w.bytes.deep},
              {"scattered", w.bytes.scattered}}}};
}

Json verificationJson(const VerificationReport& v) {
    return {{"pixels", v.pixels},
            {"pixels_looked_at", v.looked},
            {"complete", v.complete},
            {"error", v.error},
            {"alpha_error", v.alphaError},
            {"lower", v.lower},
            {"upper", v.upper},
            {"mean", v.mean},
            {"bias", v.bias},
            {"worst", v.worst},
            {"worst_pixel", {v.worstX, v.worstY}},
            {"pixel_edge", v.edge},
            {"caught_values", v.caughtValues},
            {"caught_error", v.caughtError},
            {"caught_worst", v.caughtWorst}};
}

Json secondsJson(const ShotTimes& s) {
    return {{"load", s.load},     {"plan", s.plan},   {"render", s.render},
            {"verify", s.verify}, {"write", s.write}, {"total", s.total()}};
}

Json stagesJson(const ShotTimes& s) {
    return {{"prepare", s.prepare},     {"scatter", s.scatter}, {"splat", s.splat},
            {"attenuate", s.attenuate}, {"shade", s.shade},     {"composite", s.composite}};
}

void eraseThreads(Json& json) {
    if (json.is_object())
        for (const char* name : {"batch_sheets", "buffer_bytes", "bytes", "deep_bytes"}) json.erase(name);
    if (json.is_structured())
        for (Json& value : json) eraseThreads(value);
}

// How far layers of caught shadows are off; empty where none was examined.
std::string caughtText(const VerificationReport& v) {
    if (v.caughtValues == 0) return "";
    return fmt::format("; caught shadows differ by {:.4f}, at most {:.4f}, in {} values", v.caughtError, v.caughtWorst,
                       v.caughtValues);
}

std::string verificationText(const VerificationReport& v) {
    constexpr int kFewest = 3;  // two resamples of two pixels are no distribution
    const std::string pixels = v.edge > 1 ? fmt::format("means over {0} x {0} pixels", v.edge) : "pixels";
    if (v.pixels == 0 && v.outOfTime)
        return fmt::format("; not verified: time ran out before any {} that are not empty were examined", pixels);
    if (v.pixels == 0)
        return fmt::format("; nothing to verify: all {} {} that were examined are empty", v.looked, pixels);
    // A noisy reference leaves the error uncertain, even where all pixels were examined.
    if (v.complete && v.lower == v.upper)
        return fmt::format("; error {:.2f} %, of alpha {:.2f} %, at all {} {} that are not empty", 100 * v.error,
                           100 * v.alphaError, v.pixels, pixels);
    if (v.pixels < kFewest && v.outOfTime)
        return fmt::format("; error {:.2f} %, of alpha {:.2f} %, at {} {}, too few to tell that of the picture",
                           100 * v.error, 100 * v.alphaError, v.pixels, pixels);
    return fmt::format("; error {:.2f} % (95 %: {:.2f} to {:.2f}), of alpha {:.2f} %, at {}{} {}", 100 * v.error,
                       100 * v.lower, 100 * v.upper, 100 * v.alphaError, v.complete ? "all " : "", v.pixels, pixels);
}

/// What the picture was promised to be, and with which dials it is.
std::string toleranceText(const ToleranceReport& t) {
    return fmt::format(
        "; {}below {:.2f} % with 97.5 % confidence; predicted {:.2f} % with texel {} and sheet_thickness {}{}",
        t.met ? "" : fmt::format("MISSED {:g} %, ", 100 * t.wanted), 100 * t.bound, 100 * t.predicted, t.texel,
        t.sheetThickness, t.attempts > 1 ? fmt::format(", attempt {}", t.attempts) : "");
}

/// `text` as JSON; null where it is empty, as in a skipped frame.
Json parsed(const std::string& text) {
    return text.empty() ? Json() : Json::parse(text);
}

}  // namespace

VerificationReport reportOf(const Verification& v, const PixelSample& sample) {
    VerificationReport report;
    report.pixels = v.pixels;
    report.looked = v.looked;
    report.complete = v.complete;
    report.outOfTime = sample.outOfTime;
    report.error = v.error;
    report.lower = v.lower;
    report.upper = v.upper;
    report.alphaError = v.alphaError;
    report.mean = v.mean;
    report.bias = v.bias;
    report.worst = v.worst;
    report.worstX = v.worstX;
    report.worstY = v.worstY;
    if (!sample.pixels.empty()) report.edge = sample.pixels.front().edge;
    for (const VerifiedPixel& p : countedPixels(sample)) report.examined.push_back({p.x, p.y, p.rendered, p.reference});
    return report;
}

std::string workAsJson(const RenderWork& work) {
    return workJson(work).dump();
}

std::string summaryOf(const ShotReport& r) {
    const ShotTimes& s = r.seconds;
    return fmt::format("{:.2f} s (load {:.2f}, render {:.2f}, write {:.2f}){}{}", s.total(), s.load, s.plan + s.render,
                       s.write, r.verification ? verificationText(*r.verification) + caughtText(*r.verification) : "",
                       r.tolerance ? toleranceText(*r.tolerance) : "");
}

std::string reportAsJson(const ShotReport& r) {
    Json out{{"input", r.input},
             {"frame", r.frame},
             {"file", r.file},
             {"summary", summaryOf(r)},
             {"resolution", {r.resolution.x, r.resolution.y}},
             {"seconds", secondsJson(r.seconds)},
             {"render_seconds", stagesJson(r.seconds)},
             {"work", parsed(r.workJson)},
             {"peak_memory_bytes", r.peakBytes},
             {"threads", r.threads},
             {"plan", parsed(r.planJson)}};
    if (r.verification) out["verification"] = verificationJson(*r.verification);
    if (const auto& t = r.tolerance)
        out["tolerance"] = {{"wanted", t->wanted}, {"predicted", t->predicted},
                            {"texel", t->texel},   {"sheet_thickness", t->sheetThickness},
                            {"bound", t->bound},   {"attempts", t->attempts},
                            {"met", t->met}};
    if (const auto& s = r.scattering)
        out["scattering"] = {{"wanted", s->wanted}, {"error", s->error}, {"converged", s->converged}};
    return out.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string withoutThreads(const std::string& json) {
    Json all = parsed(json);
    eraseThreads(all);
    return all.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::size_t peakResidentBytes() {
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return std::size_t(usage.ru_maxrss) * 1024;  // ru_maxrss counts in KiB
}

}  // namespace scrim
