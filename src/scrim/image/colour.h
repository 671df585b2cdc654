// SPDX-License-Identifier: Apache-2.0
// Colour management: which spaces and views exist, and conversion of colours and pictures between
// them. OpenColorIO stays behind this header, so that the rest of Scrim uses names and numbers
// only. There is one class, because the one opened config answers every question.
#pragma once

#include <scrim/geometry/spaces.h>
#include <scrim/image/image.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace scrim {

/// A picture ready for a display: 8-bit RGBA, rows from top to bottom, 4 bytes per pixel. Colour is display-encoded and
/// already composited over black; alpha is the picture's own coverage and must not be applied again.
struct DisplayImage {
    PixelWindow window;
    std::vector<std::uint8_t> rgba;
};

/// An opened OpenColorIO config. It is cheap to copy, and its const members may be called from any
/// number of threads. Names of spaces, displays and views are matched without regard to letter
/// case. All errors are Errors of kind `input`, also for a missing look-up file.
class ColourConfig {
  public:
    /// Opens the config in `ocioFile` (from --ocio); if that is empty, the one that $OCIO names; if
    /// that is unset or empty, Scrim's own ACES config. Throws where a config cannot be read or has
    /// no scene_linear role: Scrim never falls back to raw values.
    static ColourConfig open(const std::string& ocioFile);

    /// The origin of the config: its path, or "scrim-aces".
    const std::string& name() const;

    /// The space in which renders are computed: the config's scene_linear role.
    const std::string& workingSpace() const;

    /// True if `resolve(name)` would succeed.
    bool hasSpace(const std::string& name) const;

    /// The config's active spaces in its order, the scene-referred ones first.
    std::vector<std::string> spaceNames() const;

    /// The config's own name of the space that `name` means: a space, a role, an alias, or any other name of a space
    /// known to Scrim (known_spaces.h) that the config has under one of its names. Throws for any other name.
    std::string resolve(const std::string& name) const;

    /// Converts `colour` from `space` to the working space.
    Rgb toWorking(const Rgb& colour, const std::string& space) const;

    /// The same conversion for all colours as a matrix. Throws where `space` is not linear.
    Mat3 workingFrom(const std::string& space) const;

    /// Converts the colour of `image` in place and in parallel. Alpha stays unchanged, and colours
    /// stay premultiplied: a linear conversion commutes with that, and one to or from an encoded
    /// space is applied to the premultiplied values, that is, to the picture over black.
    void convert(Image& image, const std::string& fromSpace, const std::string& toSpace) const;

    /// Shows `working` (premultiplied, in the working space) through a view of a display. The transform is applied to
    /// the premultiplied colour, which is then clamped to [0, 1] and rounded to 8 bits. A fixed dither pattern keeps
    /// the mean of neighbouring pixels right, so that slow gradients show no bands. NaN becomes 0. Runs in parallel. An
    /// empty `display` or `view` stands for the default. Throws for an unknown one.
    DisplayImage displayImage(const Image& working, const std::string& display, const std::string& view) const;

    /// The same without clamping and rounding: display-encoded floats, for look-up tables. Alpha stays unchanged.
    Image displayed(const Image& working, const std::string& display, const std::string& view) const;

    /// Throw what `displayImage` and `convert` from the working space would throw: for use before a render.
    void requireView(const std::string& display, const std::string& view) const;
    void requireConversion(const std::string& toSpace) const;

    /// The active displays, the active views of a display, and the config's defaults.
    std::vector<std::string> displays() const;
    std::vector<std::string> views(const std::string& display) const;
    std::string defaultDisplay() const;
    std::string defaultView(const std::string& display) const;

    /// The Color Interop Forum's identifier of the space ("lin_ap1_scene" for ACEScg), judged by its name and aliases
    /// in the config; "data" for data; empty where it is not known. Throws for an unknown space.
    std::string interopId(const std::string& space) const;

    /// True if twice the value stands for twice the light: for scene-linear spaces and for data,
    /// not for what is encoded for displays or as logarithms. Throws for an unknown space.
    bool isLinear(const std::string& space) const;

    /// True if `space` is ACES2065-1, the only space that an ACES container may hold.
    bool isAces2065(const std::string& space) const;

  private:
    struct Opened;
    explicit ColourConfig(std::shared_ptr<const Opened> opened);
    std::string resolvedDisplay(const std::string& display) const;
    std::string resolvedView(const std::string& display, const std::string& view) const;

    std::shared_ptr<const Opened> m_opened;
};

}  // namespace scrim
