// SPDX-License-Identifier: Apache-2.0
// Colour management: which spaces and views there are, and converting colours and pictures between them.
// OpenColorIO stays behind this header, so that the rest of Scrim deals in names and numbers only. One class,
// because every question is answered by the one config that was opened.
#pragma once

#include <scrim/geometry/spaces.h>
#include <scrim/image/image.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace scrim {

/// A picture ready for a display: 8-bit RGBA, rows from top to bottom, 4 bytes a pixel. Colour is
/// display-encoded and already composited over black; alpha is the picture's own coverage and must not be
/// applied again.
struct DisplayImage {
    PixelWindow window;
    std::vector<std::uint8_t> rgba;
};

/// An opened OpenColorIO config. Cheap to copy; its const members may be called from any number of threads.
/// Names of spaces, displays and views are matched without regard to letter case. All errors are Errors of
/// kind `input`, for a missing look-up file too.
class ColourConfig {
  public:
    /// The config in `ocioFile` (from --ocio); where that is empty the one $OCIO names; where that is unset
    /// or empty Scrim's own ACES config. Throws where a config cannot be read or has no scene_linear role:
    /// Scrim never falls back to raw values.
    static ColourConfig open(const std::string& ocioFile);

    /// Where the config comes from: its path, or "scrim-aces".
    const std::string& name() const;

    /// The space renders are computed in: the config's scene_linear role.
    const std::string& workingSpace() const;

    /// True where `resolve(name)` would succeed.
    bool hasSpace(const std::string& name) const;

    /// The active spaces of the config in its order, the scene-referred ones first.
    std::vector<std::string> spaceNames() const;

    /// The config's own name of the space `name` stands for: a space, a role, an alias, or any other name of
    /// a space known to Scrim (known_spaces.h) that the config has under one of its names. Throws otherwise.
    std::string resolve(const std::string& name) const;

    /// `colour`, given in `space`, in the working space.
    Rgb toWorking(const Rgb& colour, const std::string& space) const;

    /// The same for all colours at once, as a matrix. Throws where `space` is not linear.
    Mat3 workingFrom(const std::string& space) const;

    /// Converts the colour of `image` in place and in parallel. Alpha is left alone, and so is
    /// premultiplication: a linear conversion commutes with it; one to or from an encoded space is applied to
    /// the premultiplied values as they are, that is, to the picture over black.
    void convert(Image& image, const std::string& fromSpace, const std::string& toSpace) const;

    /// `working` (premultiplied, in the working space) through a view of a display: the transform is applied
    /// to the premultiplied colour, clamped to [0, 1] and rounded to 8 bits, by a pattern that stands still, so
    /// that the mean of neighbours is right and slow gradients show no bands; NaN becomes 0. In parallel. An
    /// empty `display` or `view` stands for the default. Throws on an unknown one.
    DisplayImage displayImage(const Image& working, const std::string& display, const std::string& view) const;

    /// The active displays, and the active views of one; the defaults are the config's.
    std::vector<std::string> displays() const;
    std::vector<std::string> views(const std::string& display) const;
    std::string defaultDisplay() const;
    std::string defaultView(const std::string& display) const;

    /// The Color Interop Forum's identifier ("lin_ap1_scene" for ACEScg) of the space, judged by its name and
    /// aliases in the config; "data" for data; empty where it is not known. Throws on an unknown space.
    std::string interopId(const std::string& space) const;

    /// True where `space` is ACES2065-1, the only space an ACES container may hold.
    bool isAces2065(const std::string& space) const;

  private:
    struct Opened;
    explicit ColourConfig(std::shared_ptr<const Opened> opened);
    std::string resolvedDisplay(const std::string& display) const;
    std::string resolvedView(const std::string& display, const std::string& view) const;

    std::shared_ptr<const Opened> m_opened;
};

}  // namespace scrim
