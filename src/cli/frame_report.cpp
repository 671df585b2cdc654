// SPDX-License-Identifier: Apache-2.0
#include "frame_report.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <sys/resource.h>

namespace scrim::cli {
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
            {"sheets", w.sheets},
            {"buffer_bytes", w.bytes.total()},
            {"bytes",
             {{"fields", w.bytes.fields},
              {"shadows", w.bytes.shadows},
              {"shaded", w.bytes.shaded},
              {"picture", w.bytes.picture}}}};
}

Json verificationJson(const Verification& v) {
    return {{"pixels", v.pixels},
            {"pixels_looked_at", v.looked},
            {"complete", v.complete},
            {"error", v.error},
            {"alpha_error", v.alphaError},
            {"lower", v.lower},
            {"upper", v.upper},
            {"bias", v.bias},
            {"worst", v.worst},
            {"worst_pixel", {v.worstX, v.worstY}}};
}

Json reportJson(const FrameReport& r) {
    Json out{{"input", r.input},
             {"frame", r.frame},
             {"file", r.file},
             {"resolution", {r.resolution.x, r.resolution.y}},
             {"seconds",
              {{"load", r.load},
               {"plan", r.plan},
               {"render", r.render},
               {"verify", r.verify},
               {"write", r.write},
               {"total", r.total()}}},
             {"render_seconds",
              {{"prepare", r.stages.prepare},
               {"splat", r.stages.splat},
               {"attenuate", r.stages.attenuate},
               {"shade", r.stages.shade},
               {"composite", r.stages.composite}}},
             {"work", workJson(r.work)},
             {"peak_memory_bytes", r.peakBytes},
             {"threads", r.threads},
             {"plan", Json::parse(r.planJson)}};
    if (r.verification) out["verification"] = verificationJson(*r.verification);
    if (const auto& t = r.tolerance)
        out["tolerance"] = {{"wanted", t->wanted}, {"predicted", t->predicted},
                            {"texel", t->texel},   {"sheet_thickness", t->sheetThickness},
                            {"bound", t->bound},   {"attempts", t->attempts},
                            {"met", t->met}};
    return out;
}

std::string verificationText(const Verification& v) {
    if (v.pixels == 0) return fmt::format("; nothing to verify: {} pixels looked at, nothing in any", v.looked);
    if (v.complete)
        return fmt::format("; error {:.2f} %, of alpha {:.2f} %, at all {} pixels that show something", 100 * v.error,
                           100 * v.alphaError, v.pixels);
    return fmt::format("; error {:.2f} % (95 %: {:.2f} to {:.2f}), of alpha {:.2f} %, at {} pixels", 100 * v.error,
                       100 * v.lower, 100 * v.upper, 100 * v.alphaError, v.pixels);
}

}  // namespace

std::size_t peakResidentBytes() {
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::size_t>(usage.ru_maxrss) * 1024;  // it counts in KiB
}

std::string summaryLine(const FrameReport& r) {
    std::string text =
        fmt::format("frame {}: {} {}x{}, {:.2f} s (load {:.2f}, render {:.2f}, write {:.2f})", r.frame, r.file,
                    r.resolution.x, r.resolution.y, r.total(), r.load, r.plan + r.render, r.write);
    if (r.verification) text += verificationText(*r.verification);
    if (r.tolerance)
        text += fmt::format(
            "; {}below {:.2f} % with 97.5 % confidence; predicted {:.2f} % with texel {} and "
            "sheet_thickness {}{}",
            r.tolerance->met ? "" : fmt::format("MISSED {:g} %, ", 100 * r.tolerance->wanted), 100 * r.tolerance->bound,
            100 * r.tolerance->predicted, r.tolerance->texel, r.tolerance->sheetThickness,
            r.tolerance->attempts > 1 ? fmt::format(", attempt {}", r.tolerance->attempts) : "");
    return text;
}

std::string detailLines(const FrameReport& r) {
    return fmt::format(
        "  plan {:.3f} s, prepare {:.3f}, splat {:.3f}, attenuate {:.3f}, shade {:.3f}, composite {:.3f}, "
        "verify {:.3f}\n"
        "  {} sheets, {} footprints, {} texels shaded, {} light samples, {} pixel sheets\n"
        "  {} threads, {:.1f} MB of buffers, {:.1f} MB resident at most",
        r.plan, r.stages.prepare, r.stages.splat, r.stages.attenuate, r.stages.shade, r.stages.composite, r.verify,
        r.work.sheets, r.work.footprints, r.work.texelsShaded, r.work.lightSamples, r.work.pixelSheets, r.threads,
        double(r.work.bytes.total()) / (1 << 20), double(r.peakBytes) / (1 << 20));
}

std::string workAsJson(const RenderWork& work) {
    return workJson(work).dump();
}

std::string reportsAsJson(const std::vector<FrameReport>& reports) {
    Json all = Json::array();
    for (const FrameReport& report : reports) all.push_back(reportJson(report));
    return all.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace scrim::cli
