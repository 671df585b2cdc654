// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/colour.h>

#include <scrim/base/error.h>
#include <scrim/base/letter_case.h>
#include <scrim/base/parallel.h>
#include <scrim/image/aces_config.h>
#include <scrim/image/colour_ring.h>
#include <scrim/image/known_spaces.h>

#include <OpenColorIO/OpenColorIO.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <new>
#include <sstream>
#include <string_view>

namespace OCIO = OCIO_NAMESPACE;

namespace scrim {

struct ColourConfig::Opened {
    OCIO::ConstConfigRcPtr config;
    std::string name;
    std::string workingSpace;

    /// The config's name in error messages.
    std::string described() const { return fmt::format("the OpenColorIO config '{}'", name); }

    /// What converts colours. Throws an Error of kind `input`.
    OCIO::ConstCPUProcessorRcPtr conversion(const std::string& from, const std::string& to,
                                            OCIO::OptimizationFlags flags = OCIO::OPTIMIZATION_DEFAULT) const;
    OCIO::ConstCPUProcessorRcPtr view(const std::string& display, const std::string& view) const;

  private:
    OCIO::ConstCPUProcessorRcPtr processor(const std::string& what, const OCIO::ConstTransformRcPtr& transform,
                                           OCIO::OptimizationFlags flags) const;
};

namespace {

/// Pixels converted per task: some 2 ms at about 0.1 us per pixel. Independent of the number of threads.
constexpr std::size_t kPixelsPerTask = 16384;

/// Runs `call` and turns OpenColorIO's exceptions into an Error that begins with `what`.
template <typename Call>
auto translated(const std::string& what, const Call& call) {
    try {
        return call();
    } catch (const OCIO::Exception& exception) {
        // OpenColorIO wraps exceptions of any type.
        if (std::string_view(exception.what()).find("bad_alloc") != std::string_view::npos) throw std::bad_alloc();
        throw Error(ErrorKind::input, fmt::format("{}: {}", what, shortened(exception.what())));
    }
}

/// Applies `processor` to the colour of `count` RGBA pixels, without touching alpha.
void applyToColour(const OCIO::CPUProcessor& processor, float* rgba, std::size_t count) {
    constexpr std::ptrdiff_t kChannelBytes = sizeof(float);
    constexpr std::ptrdiff_t kPixelBytes = 4 * kChannelBytes;
    const auto width = static_cast<long>(count);
    OCIO::PackedImageDesc pixels(rgba, width, 1, 3, OCIO::BIT_DEPTH_F32, kChannelBytes, kPixelBytes,
                                 width * kPixelBytes);
    processor.apply(pixels);
}

/// Calls `task(first, count)` in parallel for runs of pixels that cover [0, pixelCount).
void forPixelRuns(std::size_t pixelCount, const std::function<void(std::size_t, std::size_t)>& task) {
    parallelFor((pixelCount + kPixelsPerTask - 1) / kPixelsPerTask, [&](std::size_t run) {
        const std::size_t first = run * kPixelsPerTask;
        task(first, std::min(kPixelsPerTask, pixelCount - first));
    });
}

std::uint8_t toByte(float value) {
    if (!(value > 0.0f)) return 0;  // also NaN
    return static_cast<std::uint8_t>(std::lround(std::min(value, 1.0f) * 255.0f));
}

/// A dither value in [0, 1). Values are spread evenly over the neighbours of every pixel without a visible pattern: an
/// additive recurrence on the plastic number (Roberts 2018, "The unreasonable effectiveness of quasirandom sequences").
/// It depends on the position alone, so the pattern is the same in all frames and crops fit together.
double ditherAt(int x, int y) {
    constexpr double kX = 0.7548776662466927, kY = 0.5698402909980532;
    const double v = kX * x + kY * y;
    return v - std::floor(v);
}

/// Rounds up in a fraction of neighbouring pixels that makes their mean right. A value within 1/512
/// of a byte is not dithered.
std::uint8_t toDitheredByte(float value, double dither) {
    constexpr double kKept = 1.0 / 512;
    if (!(value > 0.0f)) return 0;  // also NaN
    const double steps = double(std::min(value, 1.0f)) * 255;
    return static_cast<std::uint8_t>(std::floor(steps + kKept + (1 - 2 * kKept) * dither));
}

OCIO::ConstConfigRcPtr readConfig(const std::string& file, bool fromEnvironment) {
    const std::string origin = fromEnvironment ? " (named by $OCIO)" : "";
    return translated(fmt::format("cannot read the OpenColorIO config '{}'{}", file, origin),
                      [&] { return OCIO::Config::CreateFromFile(file.c_str()); });
}

/// The entry of `names` that equals `name` up to letter case. Throws an Error that lists them where there is none.
std::string chosen(const std::vector<std::string>& names, const std::string& name, const std::string& problem) {
    for (const std::string& candidate : names)
        if (equalIgnoringCase(candidate, name)) return candidate;
    throw Error(ErrorKind::input, fmt::format("{}; expected {}", problem, choices(names)));
}

}  // namespace

OCIO::ConstCPUProcessorRcPtr ColourConfig::Opened::processor(const std::string& what,
                                                             const OCIO::ConstTransformRcPtr& transform,
                                                             OCIO::OptimizationFlags flags) const {
    return translated(what, [&] {
        refuseRing(*config, described(), transform);
        return config->getProcessor(transform)->getOptimizedCPUProcessor(flags);
    });
}

OCIO::ConstCPUProcessorRcPtr ColourConfig::Opened::conversion(const std::string& from, const std::string& to,
                                                              OCIO::OptimizationFlags flags) const {
    const auto transform = OCIO::ColorSpaceTransform::Create();
    transform->setSrc(from.c_str());
    transform->setDst(to.c_str());
    return processor(fmt::format("cannot convert from '{}' to '{}'", from, to), transform, flags);
}

OCIO::ConstCPUProcessorRcPtr ColourConfig::Opened::view(const std::string& display, const std::string& view) const {
    const auto transform = OCIO::DisplayViewTransform::Create();
    transform->setSrc(workingSpace.c_str());
    transform->setDisplay(display.c_str());
    transform->setView(view.c_str());
    return processor(fmt::format("cannot make the view '{}' of display '{}'", view, display), transform,
                     OCIO::OPTIMIZATION_DEFAULT);
}

ColourConfig::ColourConfig(std::shared_ptr<const Opened> opened) : m_opened(std::move(opened)) {}

ColourConfig ColourConfig::open(const std::string& ocioFile) {
    auto opened = std::make_shared<Opened>();
    const char* environment = std::getenv("OCIO");
    const bool fromEnvironment = ocioFile.empty() && environment != nullptr && *environment != '\0';
    const std::string file = fromEnvironment ? environment : ocioFile;
    if (file.empty()) {
        opened->name = "scrim-aces";
        opened->config = translated("cannot build " + opened->described(), [] {
            std::istringstream text(acesConfigText());
            return OCIO::Config::CreateFromStream(text);
        });
    } else {
        opened->name = file;
        opened->config = readConfig(file, fromEnvironment);
    }

    const OCIO::ConstColorSpaceRcPtr working = opened->config->getColorSpace(OCIO::ROLE_SCENE_LINEAR);
    if (!working)
        throw Error(ErrorKind::input,
                    fmt::format("{} has no role 'scene_linear', which names the working space", opened->described()));
    opened->workingSpace = working->getName();
    return ColourConfig(std::move(opened));
}

const std::string& ColourConfig::name() const {
    return m_opened->name;
}

const std::string& ColourConfig::workingSpace() const {
    return m_opened->workingSpace;
}

std::vector<std::string> ColourConfig::spaceNames() const {
    const OCIO::Config& config = *m_opened->config;
    const auto active = OCIO::COLORSPACE_ACTIVE;
    std::vector<std::string> names;
    for (const auto reference : {OCIO::SEARCH_REFERENCE_SPACE_SCENE, OCIO::SEARCH_REFERENCE_SPACE_DISPLAY})
        for (int i = 0; i < config.getNumColorSpaces(reference, active); ++i)
            names.emplace_back(config.getColorSpaceNameByIndex(reference, active, i));
    return names;
}

namespace {

/// The config's name of the space that `name` means; empty where there is none.
std::string findSpace(const OCIO::Config& config, const std::string& name) {
    if (const OCIO::ConstColorSpaceRcPtr space = config.getColorSpace(name.c_str())) return space->getName();
    if (const KnownSpace* known = findKnownSpace(name))
        for (const std::string_view other : known->names)
            if (const auto space = config.getColorSpace(std::string(other).c_str())) return space->getName();
    return {};
}

}  // namespace

bool ColourConfig::hasSpace(const std::string& name) const {
    return !findSpace(*m_opened->config, name).empty();
}

std::string ColourConfig::resolve(const std::string& name) const {
    std::string found = findSpace(*m_opened->config, name);
    if (found.empty())
        throw Error(ErrorKind::input, fmt::format("unknown colour space '{}' in {}; expected {}", shortened(name),
                                                  m_opened->described(), choices(spaceNames())));
    return found;
}

Rgb ColourConfig::toWorking(const Rgb& colour, const std::string& space) const {
    const std::string from = resolve(space);
    if (from == workingSpace()) return colour;
    float rgb[3] = {static_cast<float>(colour.r), static_cast<float>(colour.g), static_cast<float>(colour.b)};
    m_opened->conversion(from, workingSpace(), OCIO::OPTIMIZATION_LOSSLESS)->applyRGB(rgb);
    return {rgb[0], rgb[1], rgb[2]};
}

Mat3 ColourConfig::workingFrom(const std::string& space) const {
    const Mat3 matrix(toWorking({1, 0, 0}, space), toWorking({0, 1, 0}, space), toWorking({0, 0, 1}, space));
    // Encodings often preserve 0 and 1, so other values are tested. Single precision causes far smaller deviations.
    constexpr double kRounding = 1e-4;
    const Rgb probe(0.25, 0.5, 0.125);
    for (const double scale : {1.0, 16.0}) {
        const Rgb found = toWorking(scale * probe, space), expected = matrix * (scale * probe);
        for (int c = 0; c < 3; ++c)
            if (!(std::abs(found[c] - expected[c]) <= kRounding * scale))
                throw Error(ErrorKind::input, fmt::format("the colour space '{}' is not linear; expected one that a "
                                                          "matrix takes to '{}'",
                                                          resolve(space), workingSpace()));
    }
    return matrix;
}

void ColourConfig::convert(Image& image, const std::string& fromSpace, const std::string& toSpace) const {
    const std::string from = resolve(fromSpace);
    const std::string to = resolve(toSpace);
    if (from == to) return;
    const auto processor = m_opened->conversion(from, to);
    if (processor->isNoOp()) return;
    forPixelRuns(image.window.pixelCount(), [&](std::size_t first, std::size_t count) {
        applyToColour(*processor, image.rgba.data() + 4 * first, count);
    });
}

void ColourConfig::requireView(const std::string& display, const std::string& view) const {
    const std::string toDisplay = resolvedDisplay(display);
    m_opened->view(toDisplay, resolvedView(toDisplay, view));
}

void ColourConfig::requireConversion(const std::string& toSpace) const {
    if (const std::string to = resolve(toSpace); to != workingSpace()) m_opened->conversion(workingSpace(), to);
}

Image ColourConfig::displayed(const Image& working, const std::string& display, const std::string& view) const {
    const std::string toDisplay = resolvedDisplay(display);
    const auto processor = m_opened->view(toDisplay, resolvedView(toDisplay, view));
    Image out = working;
    forPixelRuns(out.window.pixelCount(), [&](std::size_t first, std::size_t count) {
        applyToColour(*processor, out.rgba.data() + 4 * first, count);
    });
    return out;
}

DisplayImage ColourConfig::displayImage(const Image& working, const std::string& display,
                                        const std::string& view) const {
    const Image shown = displayed(working, display, view);
    DisplayImage out{working.window, std::vector<std::uint8_t>(working.rgba.size())};
    forPixelRuns(working.window.pixelCount(), [&](std::size_t first, std::size_t count) {
        for (std::size_t at = first; at < first + count; ++at) {
            const std::size_t width = std::size_t(working.window.width());
            const double dither = ditherAt(working.window.x0 + static_cast<int>(at % width),
                                           working.window.y0 + static_cast<int>(at / width));
            for (std::size_t c = 0; c < 3; ++c) out.rgba[4 * at + c] = toDitheredByte(shown.rgba[4 * at + c], dither);
            out.rgba[4 * at + 3] = toByte(shown.rgba[4 * at + 3]);
        }
    });
    return out;
}

std::vector<std::string> ColourConfig::displays() const {
    const OCIO::Config& config = *m_opened->config;
    std::vector<std::string> names;
    for (int i = 0; i < config.getNumDisplays(); ++i) names.emplace_back(config.getDisplay(i));
    return names;
}

std::vector<std::string> ColourConfig::views(const std::string& display) const {
    const OCIO::Config& config = *m_opened->config;
    const std::string of = resolvedDisplay(display);
    std::vector<std::string> names;
    for (int i = 0; i < config.getNumViews(of.c_str()); ++i) names.emplace_back(config.getView(of.c_str(), i));
    return names;
}

std::string ColourConfig::defaultDisplay() const {
    return m_opened->config->getDefaultDisplay();
}

std::string ColourConfig::defaultView(const std::string& display) const {
    return m_opened->config->getDefaultView(resolvedDisplay(display).c_str());
}

std::string ColourConfig::resolvedDisplay(const std::string& display) const {
    return chosen(displays(), display.empty() ? defaultDisplay() : display,
                  fmt::format("unknown display '{}' in {}", shortened(display), m_opened->described()));
}

std::string ColourConfig::resolvedView(const std::string& display, const std::string& view) const {
    return chosen(
        views(display), view.empty() ? defaultView(display) : view,
        fmt::format("unknown view '{}' of display '{}' in {}", shortened(view), display, m_opened->described()));
}

std::string ColourConfig::interopId(const std::string& space) const {
    const OCIO::ConstColorSpaceRcPtr found = m_opened->config->getColorSpace(resolve(space).c_str());
    if (found->isData()) return "data";
    if (const KnownSpace* known = findKnownSpace(found->getName())) return std::string(known->interopId);
    for (std::size_t i = 0; i < found->getNumAliases(); ++i)
        if (const KnownSpace* known = findKnownSpace(found->getAlias(i))) return std::string(known->interopId);
    return {};
}

bool ColourConfig::isLinear(const std::string& space) const {
    constexpr float kGrey = 0.2f, kAlike = 1e-3f;
    Image image = emptyImage({0, 0, 2, 1});
    for (std::size_t c = 0; c < 3; ++c) {
        image.rgba[c] = kGrey;
        image.rgba[4 + c] = 2 * kGrey;
    }
    image.rgba[3] = image.rgba[7] = 1;
    convert(image, workingSpace(), space);
    for (std::size_t c = 0; c < 3; ++c)
        if (std::abs(image.rgba[4 + c] - 2 * image.rgba[c]) > kAlike * std::abs(image.rgba[4 + c])) return false;
    return true;
}

bool ColourConfig::isAces2065(const std::string& space) const {
    return interopId(space) == "lin_ap0_scene";
}

}  // namespace scrim
