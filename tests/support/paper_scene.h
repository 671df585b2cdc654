// SPDX-License-Identifier: Apache-2.0
// The scenes of examples/paper, rendered small by the program as a user would, and what tests ask of their pictures:
// how bright it is where a point of the world is seen.
#pragma once

#include <scrim/geometry/camera.h>
#include <scrim/image/image.h>
#include <scrim/scene/scene.h>

#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace scrim::test {

/// "key.path=value", as --set takes them.
using Settings = std::vector<std::string>;

/// Both, `more` last.
Settings operator+(Settings settings, const Settings& more);

/// The scene as the program reads it.
Scene paperScene(const std::string& name, const Settings& settings = {});

struct PaperPicture {
    Image image;           ///< the whole picture, working space
    Camera camera;         ///< that took it
    nlohmann::json stats;  ///< of the program, with the plan; and the verification where it was asked for

    /// Luminance (the mean of R, G and B: no colour matters more here) of pixel (x, y), premultiplied.
    double brightness(int x, int y) const;
    double alpha(int x, int y) const;
    Rgb colour(int x, int y) const;

    /// The pixel that sees `ws`; it need not lie in the picture.
    Int2 pixelOf(const Vec3& ws) const;
    double brightnessAt(const Vec3& ws) const;
    Rgb colourAt(const Vec3& ws) const;

    /// How many pixels hold what `claim` says of (x, y).
    int count(const std::function<bool(int x, int y)>& claim) const;
    double meanBrightness() const;

    double error() const { return stats.at("verification").at("error").get<double>(); }
    std::size_t sweeps() const { return stats.at("plan").at("groups").size(); }
};

/// Edge of the pictures unless `settings` say otherwise.
inline constexpr int kPaperResolution = 128;

/// Renders the scene; compares `verify` pixels with brute force. Fails the test where the program does.
PaperPicture renderPaper(const std::string& name, const Settings& settings = {}, int verify = 0);

}  // namespace scrim::test
