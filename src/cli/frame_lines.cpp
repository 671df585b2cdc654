// SPDX-License-Identifier: Apache-2.0
#include "frame_lines.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cstdint>

namespace scrim::cli {
namespace {

using Json = nlohmann::ordered_json;

}  // namespace

std::string summaryLine(const ShotReport& r) {
    return fmt::format("frame {}: {} {}x{}, {}", r.frame, r.file, r.resolution.x, r.resolution.y, summaryOf(r));
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
