// SPDX-License-Identifier: Apache-2.0
#include "frame_lines.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cstdint>

namespace scrim::cli {
namespace {

using Json = nlohmann::ordered_json;

std::string verificationText(const VerificationReport& v) {
    if (v.pixels == 0) return fmt::format("; nothing to verify: all {} pixels that were examined are empty", v.looked);
    if (v.complete)
        return fmt::format("; error {:.2f} %, of alpha {:.2f} %, at all {} pixels that are not empty", 100 * v.error,
                           100 * v.alphaError, v.pixels);
    return fmt::format("; error {:.2f} % (95 %: {:.2f} to {:.2f}), of alpha {:.2f} %, at {} pixels", 100 * v.error,
                       100 * v.lower, 100 * v.upper, 100 * v.alphaError, v.pixels);
}

}  // namespace

std::string summaryLine(const ShotReport& r) {
    const ShotTimes& s = r.seconds;
    std::string text =
        fmt::format("frame {}: {} {}x{}, {:.2f} s (load {:.2f}, render {:.2f}, write {:.2f})", r.frame, r.file,
                    r.resolution.x, r.resolution.y, s.total(), s.load, s.plan + s.render, s.write);
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

std::string detailLines(const ShotReport& r) {
    const ShotTimes& s = r.seconds;
    const Json work = Json::parse(r.workJson);
    const auto count = [&work](const char* name) { return work.at(name).get<std::uint64_t>(); };
    return fmt::format(
        "  plan {:.3f} s, prepare {:.3f}, scatter {:.3f}, splat {:.3f}, attenuate {:.3f}, shade {:.3f}, composite "
        "{:.3f}, verify {:.3f}\n"
        "  {} sheets, {} footprints, {} texels shaded, {} light samples, {} pixel sheets\n"
        "  {} threads, {:.1f} MB of buffers, {:.1f} MB resident at most",
        s.plan, s.prepare, s.scatter, s.splat, s.attenuate, s.shade, s.composite, s.verify, count("sheets"),
        count("footprints"), count("texels_shaded"), count("light_samples"), count("pixel_sheets"), r.threads,
        double(count("buffer_bytes")) / (1 << 20), double(r.peakBytes) / (1 << 20));
}

}  // namespace scrim::cli
