// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/spectrum.h>

#include <scrim/base/error.h>

#include <fmt/format.h>

#include <glm/matrix.hpp>

namespace scrim {
namespace {

/// The CIE's colour-matching functions of the 1931 observer (publication 15), every 10 nm. Spectra of blackbodies are
/// smooth, so chromaticities are accurate to 1e-4. (The fit by Gaussians of Wyman, Sloan and Shirley, JCGT 2013, is off
/// by 0.005 at 1500 K, and by 0.011 at 1000 K, where fire glows.)
constexpr Vec3 kObserver[] = {
    {0.001368, 0.000039, 0.006450}, {0.004243, 0.000120, 0.020050}, {0.014310, 0.000396, 0.067850},
    {0.043510, 0.001210, 0.207400}, {0.134380, 0.004000, 0.645600}, {0.283900, 0.011600, 1.385600},
    {0.348280, 0.023000, 1.747060}, {0.336200, 0.038000, 1.772110}, {0.290800, 0.060000, 1.669200},
    {0.195360, 0.090980, 1.287640}, {0.095640, 0.139020, 0.812950}, {0.032010, 0.208020, 0.465180},
    {0.004900, 0.323000, 0.272000}, {0.009300, 0.503000, 0.158200}, {0.063270, 0.710000, 0.078250},
    {0.165500, 0.862000, 0.042160}, {0.290400, 0.954000, 0.020300}, {0.433450, 0.994950, 0.008750},
    {0.594500, 0.995000, 0.003900}, {0.762100, 0.952000, 0.002100}, {0.916300, 0.870000, 0.001650},
    {1.026300, 0.757000, 0.001100}, {1.062200, 0.631000, 0.000800}, {1.002600, 0.503000, 0.000340},
    {0.854450, 0.381000, 0.000190}, {0.642400, 0.265000, 0.000050}, {0.447900, 0.175000, 0.000020},
    {0.283500, 0.107000, 0.000000}, {0.164900, 0.061000, 0.000000}, {0.087400, 0.032000, 0.000000},
    {0.046770, 0.017000, 0.000000}, {0.022700, 0.008210, 0.000000}, {0.011359, 0.004102, 0.000000},
    {0.005790, 0.002091, 0.000000}, {0.002899, 0.001047, 0.000000}, {0.001440, 0.000520, 0.000000},
    {0.000690, 0.000249, 0.000000}, {0.000332, 0.000120, 0.000000}, {0.000166, 0.000060, 0.000000},
    {0.000083, 0.000030, 0.000000}, {0.000042, 0.000015, 0.000000},
};

/// IEC 61966-2-1, computed from its primaries and its white (0.3127, 0.3290).
Mat3 rec709FromXyz() {
    return glm::transpose(Mat3(3.2409699419, -1.5373831776, -0.4986107603,  //
                               -0.9692436363, 1.8759675015, 0.0415550574,   //
                               0.0556300797, -0.2039769589, 1.0569715142));
}

/// SMPTE ST 2065-1's primaries and white, with Bradford's adaptation.
Mat3 ap0FromRec709() {
    return glm::transpose(Mat3(0.4396329819, 0.3829886982, 0.1773783199,  //
                               0.0897764430, 0.8134394287, 0.0967841283,  //
                               0.0175411704, 0.1115465533, 0.8709122763));
}

Mat3 workingFromRec709(const ColourConfig& config) {
    if (config.hasSpace("lin_rec709")) return config.workingFrom("lin_rec709");
    for (const char* ap0 : {"ACES2065-1", "aces_interchange"})  // a space and a role
        if (config.hasSpace(ap0)) return config.workingFrom(ap0) * ap0FromRec709();
    throw Error(ErrorKind::input,
                fmt::format("the OpenColorIO config '{}' has neither linear Rec.709 nor ACES2065-1; "
                            "expected one of them, from which the colours of black bodies and skies come",
                            config.name()));
}

}  // namespace

std::span<const Vec3> observer() {
    return kObserver;
}

Mat3 workingFromXyz(const ColourConfig& config) {
    return workingFromRec709(config) * rec709FromXyz();
}

}  // namespace scrim
