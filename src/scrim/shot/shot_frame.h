// SPDX-License-Identifier: Apache-2.0
// A rendered frame: its picture, its layers, its cost, and its files.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/geometry/spaces.h>
#include <scrim/image/image.h>
#include <scrim/scene/scene.h>

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace scrim {

/// A picture beside the beauty, with the same window.
struct ShotLayer {
    std::string name;  ///< "light.key", "ambient", "depth"
    /// Names as in the file: "light.key.R", ...; for depth "Z" and "depth.mean", for motion "motion.u" and "motion.v".
    std::vector<std::string> channels;
    std::vector<float> data;  ///< channels.size() floats a pixel, interleaved, rows from top to bottom
};

/// Seconds of wall clock time.
struct ShotTimes {
    double load = 0, plan = 0, render = 0, verify = 0, write = 0;  ///< `plan` includes all pilots
    /// Parts of `render`.
    double prepare = 0, scatter = 0, splat = 0, attenuate = 0, shade = 0, composite = 0;

    double total() const { return load + plan + render + verify + write; }
};

/// A pixel that was compared with the brute-force reference: premultiplied RGBA in the working space.
struct ExaminedPixel {
    int x = 0, y = 0;  ///< in the display window
    std::array<double, 4> rendered{}, reference{};
};

/// A comparison with the brute-force reference. Errors are relative RMSE over R, G and B.
struct VerificationReport {
    int pixels = 0;          ///< pixels that counted because they show something
    std::size_t looked = 0;  ///< pixels that were evaluated
    bool complete = false;   ///< no pixel was left out, so the error is exact
    bool outOfTime = false;  ///< RenderOptions::verifyLimit ended it early
    double error = 0;
    double lower = 0, upper = 0;  ///< 95 % confidence interval of `error`
    double alphaError = 0;
    double mean = 0;             ///< of the reference over R, G and B, which errors of colour are relative to
    double bias = 0;             ///< mean difference over mean reference
    double worst = 0;            ///< RMS difference of one pixel over the mean reference
    int worstX = 0, worstY = 0;  ///< that pixel
    int edge = 1;  ///< what is called a pixel here is the mean over a square of `edge` x `edge` pixels, see its corner
    /// Root mean square and largest difference of layers of caught shadows, whose values lie in [0,
    /// 1], where solids show; 0 where none do.
    double caughtError = 0, caughtWorst = 0;
    int caughtValues = 0;
    std::vector<ExaminedPixel> examined;  ///< those that counted, in the order in which they were drawn
};

/// The outcome of a tolerance.
struct ToleranceReport {
    double wanted = 0;
    double predicted = 0;  ///< predicted error of the setting that was rendered last
    double texel = 0, sheetThickness = 0;
    double bound = 0;  ///< the error is below this with a confidence of 97.5 %
    int attempts = 0;  ///< number of settings that were rendered
    bool met = false;
};

/// The convergence of multiply scattered light.
struct ScatteringReport {
    double wanted = 0;      ///< the dial scatter_error
    double error = 0;       ///< what further sweeps would change, relative: an estimate
    bool converged = true;  ///< `error` is at most `wanted`
};

struct ShotReport {
    std::string input;  ///< the shot's path
    std::string file;   ///< path of the picture: the last one written, or else the scene's
    int frame = 1;
    Int2 resolution{0};
    int threads = 0;
    ShotTimes seconds;
    std::string planJson;       ///< the plan that was rendered, as one JSON object
    std::string workJson;       ///< counts of work as one JSON object; the same in every run
    std::size_t peakBytes = 0;  ///< peak memory of the process so far
    std::optional<VerificationReport> verification;
    std::optional<ToleranceReport> tolerance;
    std::optional<ScatteringReport> scattering;  ///< none where light scatters once at most
};

/// Times and accuracy in words: "0.21 s (load 0.05, render 0.12, write 0.04); error 0.31 %, ...".
std::string summaryOf(const ShotReport& report);

/// `report` as one JSON object, with the summary, too.
std::string reportAsJson(const ShotReport& report);

/// Movable. Its const members may be called from several threads at once.
class ShotFrame {
  public:
    /// True if MissingPolicy::skip left the frame out; there is no picture then.
    bool skipped() const;

    /// The picture: premultiplied, scene-linear, in the working space. It covers the picture with
    /// its overscan, or the crop.
    const Image& image() const;

    /// The names of the layers that the scene asks for, in its order; one for each light or volume:
    /// "light.key". Layers are in the working space, except for depth (world units along the
    /// viewing axis) and motion (pixels per frame, to the right and up).
    std::vector<std::string> layerNames() const;
    /// Throws Error(usage), which lists the names, where there is no such layer.
    const ShotLayer& layer(const std::string& name) const;

    const ShotReport& report() const;

    /// Writes picture and layers as one OpenEXR file with all metadata, in the colour space and type of the scene's
    /// output. "####" in `path` stands for the frame, as in scenes; "" stands for the scene's own output files, each
    /// with its own layers. A file appears completely or not at all. Throws Error: usage, output.
    void write(const std::string& path = "", const MessageSink& messages = {});

    /// True if the scene asks for a deep picture.
    bool hasDeep() const;

    /// Writes the deep picture: an OpenEXR file of volume samples with the same metadata, in the
    /// type that the scene's output states for it. `path` is as in `write`; "" stands for the
    /// scene's own deep file. Throws Error(usage) where there is no deep picture.
    void writeDeep(const std::string& path = "", const MessageSink& messages = {});

    /// The picture that previews are laid over, stretched to the display window, in the working
    /// space. Without pixels where the scene's preview has none.
    Image backplate() const;

    /// Writes the picture as a display shows it, as PNG or in the format of the extension. ""
    /// stands for the scene's own preview file.
    void preview(const std::string& path = "");

    struct Content;
    explicit ShotFrame(std::unique_ptr<Content> content);
    ShotFrame(ShotFrame&&) noexcept;
    ShotFrame& operator=(ShotFrame&&) noexcept;
    ~ShotFrame();

  private:
    std::string pathOf(const std::string& path, const std::string& fromScene, const std::string& what) const;
    void requirePicture() const;

    std::unique_ptr<Content> m_content;
};

}  // namespace scrim
