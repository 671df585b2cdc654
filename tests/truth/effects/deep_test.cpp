// SPDX-License-Identifier: Apache-2.0
// Deep pictures: flattened they are the flat picture, cut at a depth they are what lies before it, and the flat picture
// and its work know nothing of them.
#include "scenes.h"

#include "support/expect_error.h"
#include "support/temp_folder.h"

#include <scrim/base/error.h>
#include <scrim/image/exr_deep.h>
#include <scrim/verify/reference.h>

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

double largest(const Image& image) {
    return *std::max_element(image.rgba.begin(), image.rgba.end());
}

// The deep picture as OpenImageIO flattens its file.
Image flattened(const Frame& frame, bool half) {
    const TempFolder folder;
    ExrOptions options;
    options.half = half;
    options.displayWindow = frame.image.window;
    writeDeepExr(folder.file("deep.exr"), *frame.deep, options);
    const OIIO::ImageBuf deep(folder.file("deep.exr"));
    const OIIO::ImageBuf flat = OIIO::ImageBufAlgo::flatten(deep);
    EXPECT_FALSE(flat.has_error()) << flat.geterror();
    Image image = emptyImage(frame.image.window);
    const int channels = flat.nchannels();
    std::vector<float> pixel(std::size_t(std::max(channels, 4)));
    for (int y = image.window.y0; y < image.window.y1; ++y)
        for (int x = image.window.x0; x < image.window.x1; ++x) {
            flat.getpixel(x, y, 0, pixel.data(), channels, OIIO::ImageBuf::WrapBlack);
            std::copy_n(pixel.begin(), 4, image.rgba.begin() + std::ptrdiff_t(image.indexOf(x, y)));
        }
    return image;
}

struct Case {
    std::string name;
    std::function<void(ViewScene&)> change;
};
void PrintTo(const Case& c, std::ostream* out) {
    *out << c.name;
}

void perspective(ViewScene& s, const Vec3& eye, double near) {
    s.camera.type = CameraType::perspective;
    s.camera.wsPosition = eye;
    s.camera.wsFromCamera = lookAt(eye, Vec3(0), {0, 1, 0});
    s.camera.fov = 40;
    s.camera.near = near;
}

// Of another renderer: something thin across the smoke, and a wall that leans.
std::shared_ptr<const DepthPicture> veil(const PixelWindow& window) {
    FileDepth file;
    file.width = window.width();
    file.height = window.height();
    file.deep = true;
    for (int i = 0; i < file.width * file.height; ++i) {
        const float wall = 70 + 0.3f * static_cast<float>(i % file.width);
        file.counts.push_back(2);
        file.samples.insert(file.samples.end(), {66, 75, 0.6f, wall, wall, 1});
    }
    return std::make_shared<const DepthPicture>(depthPictureOf(file, {}));
}

std::vector<Case> cases() {
    std::vector<Case> all{
        {"light in front",
         [](ViewScene& s) {
             s.lights = {distantLight({-0.3, -0.5, -1}, 5)};
         }},
        {"light behind",
         [](ViewScene& s) {
             s.lights = {distantLight({0.2, -0.1, 1}, 5)};
         }},
        {"lights on both sides", [](ViewScene&) {}},
        {"no light", [](ViewScene& s) { s.lights.clear(); }},
        {"light across the eye, swept from both sides",
         [](ViewScene& s) {
             s.dials.crossFade = 2;
             s.lights = {distantLight({-1, 0, 0.005}, 5)};
         }},
        {"perspective",
         [](ViewScene& s) {
             perspective(s, {20, 15, 70}, 0);
         }},
        {"eye among the smoke",
         [](ViewScene& s) {
             perspective(s, {3, 2, 9}, 1.3);
         }},
        {"opaque", [](ViewScene& s) { s.volumes[0].medium.densityScale = 30; }},
        {"thin", [](ViewScene& s) { s.volumes[0].medium.densityScale = 1e-4; }},
        {"antialiased", [](ViewScene& s) { s.dials.antialias = 2; }},
        {"antialiased perspective",
         [](ViewScene& s) {
             perspective(s, {20, 15, 70}, 0);
             s.dials.antialias = 3;
         }},
        {"overscan",
         [](ViewScene& s) {
             s.region = {-7, -5, 50, 53};
         }},
        {"crop",
         [](ViewScene& s) {
             s.picture = s.region;
             s.region = {13, 9, 31, 40};
         }},
        {"layers",
         [](ViewScene& s) {
             s.layers = {Layer::light, Layer::ambient, Layer::depth, Layer::transmittance};
         }},
        {"volume held out",
         [](ViewScene& s) {
             s.volumes.push_back(s.volumes.front());
             s.volumes.back().wsFromIs[3] = {6, -5, 4, 1};
             s.volumes.back().holdout = true;
         }},
        {"behind a deep picture",
         [](ViewScene& s) {
             perspective(s, {20, 15, 70}, 0);
             s.dials.antialias = 2;
             s.depths = veil(s.region);
         }},
        {"classified, per view", [](ViewScene& s) {
             Classified look;
             look.transfer = {{0.1, {1, 0.8, 0.6}, 0.0}, {0.4, {1, 0.8, 0.6}, 0.5}, {0.9, {0.2, 0.8, 0.6}, 2}};
             s.volumes[0].classified = std::make_shared<const Classified>(look);
             s.dials.splat = SplatMode::perView;
             s.ambient = Rgb(0.3);
         }}};
    for (const EffectCase& effect : effectCases()) all.push_back({effect.name, effect.add});
    return all;
}

using Pick = std::tuple<Case, ShadeMode>;
class Deep : public testing::TestWithParam<Pick> {
  protected:
    ViewScene scene() const {
        ViewScene s = plainScene();
        s.dials.shade = std::get<1>(GetParam());
        std::get<0>(GetParam()).change(s);
        return s;
    }
};

// Single floats hold sums of dozens of sheets to 1e-5 of the brightest pixel. Half floats have 11 bits, so that the
// last sample, which makes up for all before it, is off by at most 2^-12 of what it shows.
TEST_P(Deep, FlattensToTheFlatPicture) {
    ViewScene s = scene();
    for (const double tolerance : {0.0, 0.01}) {
        s.deep = ViewDeep{tolerance};
        const Frame frame = renderScene(s);
        ASSERT_TRUE(frame.deep);
        const Image single = flattened(frame, false), half = flattened(frame, true);
        const double scale = std::max(1.0, largest(frame.image));
        double lit = 0;
        for (std::size_t i = 0; i < frame.image.rgba.size(); ++i) {
            const double flat = frame.image.rgba[i];
            lit += flat;
            ASSERT_NEAR(single.rgba[i], flat, 1e-5 * scale) << i << " at tolerance " << tolerance;
            // Below 2^-14 halves are spaced by 6e-8.
            ASSERT_NEAR(half.rgba[i], flat, 1e-3 * std::max(std::abs(flat), 1e-3)) << i << " at " << tolerance;
        }
        EXPECT_GT(lit, 0);
    }
}

TEST_P(Deep, LeavesTheFlatPictureAndItsWorkAlone) {
    ViewScene s = scene();
    const Frame without = renderScene(s);
    s.deep = ViewDeep{};
    Frame with = renderScene(s);
    EXPECT_EQ(without.work.deepSamples, 0u);
    EXPECT_EQ(without.work.bytes.deep, 0u);
    EXPECT_FALSE(without.deep);
    EXPECT_GT(with.work.deepSamples, 0u);
    with.work.deepSamples = 0;
    with.work.bytes = without.work.bytes;
    EXPECT_TRUE(with.work == without.work);
    EXPECT_TRUE(with.image.rgba == without.image.rgba);
    for (std::size_t l = 0; l < with.layers.size(); ++l) EXPECT_TRUE(with.layers[l].data == without.layers[l].data);
}

TEST_P(Deep, IsTidy) {
    ViewScene s = scene();
    s.deep = ViewDeep{0.01};
    const Frame frame = renderScene(s);
    std::size_t clamped = 0, pixelsWithSamples = 0;
    for (const bool half : {false, true})
        for (int y = s.region.y0; y < s.region.y1; ++y)
            for (int x = s.region.x0; x < s.region.x1; ++x) {
                float before = 0;
                const auto samples = deepSamples(frame.deep->curve(x, y), half, clamped);
                pixelsWithSamples += samples.empty() ? 0 : 1;
                for (const DeepSample& sample : samples) {
                    ASSERT_GE(sample.z, before);
                    ASSERT_GT(sample.zBack, sample.z);
                    before = sample.zBack;
                    ASSERT_GE(sample.z, static_cast<float>(s.camera.near));
                    for (const float v : sample.rgba) ASSERT_TRUE(std::isfinite(v) && v >= 0) << v;
                    ASSERT_LE(sample.rgba[3], 1);
                }
            }
    EXPECT_EQ(clamped, 0u);
    EXPECT_GT(pixelsWithSamples, 0u);
}

INSTANTIATE_TEST_SUITE_P(Scenes, Deep,
                         testing::Combine(testing::ValuesIn(cases()),
                                          testing::Values(ShadeMode::texel, ShadeMode::pixel)),
                         [](const testing::TestParamInfo<Pick>& one) {
                             std::string name = std::get<0>(one.param).name;
                             std::erase_if(name, [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); });
                             return name + (std::get<1>(one.param) == ShadeMode::pixel ? "AtPixels" : "AtTexels");
                         });

// ---- cuts

// Five depths between where the smoke begins and where it ends.
std::vector<double> fiveDepths(const DeepImage& deep) {
    double begin = 1e30, end = 0;
    for (const DeepImage::Row& row : deep.rows)
        for (const DeepPiece& piece : row.pieces) {
            begin = std::min(begin, double(piece.begin));
            end = std::max(end, double(piece.end));
        }
    std::vector<double> depths;
    for (int i = 1; i <= 5; ++i) depths.push_back(begin + (end - begin) * i / 6);
    return depths;
}

// The curve with one sample a pixel.
DeepCurve one(std::span<const DeepPiece> curve) {
    if (curve.empty()) return {};
    return {{curve.front().begin, curve.back().end, curve.back().shown}};
}

// Every fourth pixel either way.
std::vector<Int2> somePixels(const ViewScene& scene) {
    std::vector<Int2> pixels;
    for (int y = scene.region.y0 + 1; y < scene.region.y1; y += 4)
        for (int x = scene.region.x0 + 1; x < scene.region.x1; x += 4) pixels.emplace_back(x, y);
    return pixels;
}

// What the reference's rays show that end at `depth`.
std::vector<std::array<double, 4>> truthBefore(const ViewScene& scene, double depth) {
    ReferenceOptions options;
    options.far = depth;
    const Reference reference(scene, options);
    std::vector<std::array<double, 4>> truth;
    for (const Int2& pixel : somePixels(scene)) truth.push_back(reference.pixel(pixel.x, pixel.y));
    return truth;
}

struct Errors {
    double colour = 0, alpha = 0;  ///< RMS over pixels, of the RMS of the whole picture
    double largest() const { return std::max(colour, alpha); }
};

Errors errorsOf(const std::vector<std::array<double, 4>>& found, const std::vector<std::array<double, 4>>& truth,
                const std::vector<std::array<double, 4>>& whole) {
    double colour = 0, alpha = 0, allColour = 0, allAlpha = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
            colour += std::pow(found[i][c] - truth[i][c], 2);
            allColour += std::pow(whole[i][c], 2);
        }
        alpha += std::pow(found[i][3] - truth[i][3], 2);
        allAlpha += std::pow(whole[i][3], 2);
    }
    return {std::sqrt(colour / allColour), std::sqrt(alpha / allAlpha)};
}

class DeepCut : public testing::TestWithParam<Case> {};

// The sheets' own error in these scenes, of texels and sheets a voxel thick, is about 1 % ("standard"). To it comes
// where in a sheet things are, which no sheet knows: within one the curve is the straight line between its ends, which
// is off by Delta^2 / 8 times the curve's bend. Bumps of smoke are about 5 sheets wide and hold less than a third of
// what is shown, so that the bend is at most (pi / 5)^2 / 3 and the cut off by 1.6 % in the worst of places, a third of
// that in the mean. Merging may take 1 % in the worst, and a third of that in the mean. Together less than 2 %.
constexpr double kCut = 0.02;

TEST_P(DeepCut, ShowsWhatTheReferenceShowsBeforeIt) {
    ViewScene s = plainScene();
    GetParam().change(s);
    s.deep = ViewDeep{0.01};
    const Frame frame = renderScene(s);
    const auto whole = truthBefore(s, std::numeric_limits<double>::infinity());
    for (const double depth : fiveDepths(*frame.deep)) {
        std::vector<std::array<double, 4>> found, ofOne;
        for (const Int2& pixel : somePixels(s)) {
            const auto curve = frame.deep->curve(pixel.x, pixel.y);
            found.push_back(shownBefore(curve, depth));
            ofOne.push_back(shownBefore(one(curve), depth));
        }
        const auto truth = truthBefore(s, depth);
        const Errors errors = errorsOf(found, truth, whole);
        EXPECT_LT(errors.colour, kCut) << "at " << depth;
        EXPECT_LT(errors.alpha, kCut) << "at " << depth;
        EXPECT_GT(errorsOf(ofOne, truth, whole).largest(), kCut) << "one sample a pixel passes at " << depth;
    }
}

INSTANTIATE_TEST_SUITE_P(Scenes, DeepCut,
                         testing::Values(Case{"front",
                                              [](ViewScene& s) {
                                                  s.lights = {distantLight({-0.3, -0.5, -1}, 5)};
                                              }},
                                         Case{"behind",
                                              [](ViewScene& s) {
                                                  s.lights = {distantLight({0.2, -0.1, 1}, 5)};
                                              }},
                                         Case{"both", [](ViewScene&) {}},
                                         Case{"perspective",
                                              [](ViewScene& s) {
                                                  perspective(s, {20, 15, 70}, 0);
                                              }},
                                         Case{"antialiased", [](ViewScene& s) { s.dials.antialias = 2; }},
                                         Case{"emission",
                                              [](ViewScene& s) {
                                                  s.volumes.front().emission = {{flameField(), {0.4, 0.2, 0.05}}};
                                              }}),
                         [](const testing::TestParamInfo<Case>& one) { return one.param.name; });

// ---- what must not change it

bool sameCurves(const DeepImage& a, const DeepImage& b) {
    const auto same = [](const DeepPiece& p, const DeepPiece& q) {
        return p.begin == q.begin && p.end == q.end && p.shown == q.shown;
    };
    for (std::size_t r = 0; r < a.rows.size(); ++r)
        if (a.rows[r].first != b.rows[r].first ||
            !std::equal(a.rows[r].pieces.begin(), a.rows[r].pieces.end(), b.rows[r].pieces.begin(), same))
            return false;
    return a.rows.size() == b.rows.size();
}

TEST(DeepPicture, IsTheSameForAnyThreadsAndBatches) {
    for (const double tolerance : {0.0, 0.02}) {
        ViewScene s = plainScene();
        s.deep = ViewDeep{tolerance};
        const auto with = [&](int threads) { return *render(s, makePlan(s, threads)).deep; };
        const DeepImage first = with(1);
        EXPECT_TRUE(sameCurves(first, with(4)));
        Plan plan = makePlan(s, 2);
        for (GroupPlan& group : plan.groups) group.batchSheets = 3;
        EXPECT_TRUE(sameCurves(first, *render(s, plan).deep));
    }
}

TEST(DeepPicture, LargerTolerancesTakeFewerSamples) {
    ViewScene s = plainScene();
    std::vector<std::size_t> counts;
    for (const double tolerance : {0.0, 0.001, 0.01, 0.1}) {
        s.deep = ViewDeep{tolerance};
        counts.push_back(renderScene(s).deep->pieceCount());
    }
    for (std::size_t i = 1; i < counts.size(); ++i) EXPECT_LT(counts[i], counts[i - 1]);
    EXPECT_LT(3 * counts[2], counts[0]);
}

TEST(DeepPicture, HasNoSamplesWhereNothingIs) {
    ViewScene s = plainScene();
    s.deep = ViewDeep{};
    s.volumes[0].field = std::make_shared<SparseField>();
    const Frame frame = renderScene(s);
    ASSERT_TRUE(frame.deep);
    EXPECT_EQ(frame.deep->pieceCount(), 0u);
    EXPECT_EQ(flattened(frame, true).rgba, frame.image.rgba);
}

TEST(DeepPicture, KeepsToTheMemoryLimit) {
    ViewScene s = plainScene();
    const std::size_t flat = makePlan(s, 1).bytes;
    s.deep = ViewDeep{0};
    EXPECT_GT(makePlan(s, 1).bytes, flat);
    EXPECT_GE(makePlan(s, 1).deepBytes, renderScene(s).work.bytes.deep);
    s.memoryLimit = flat + 100'000;
    EXPECT_LE(makePlan(s, 1).bytes, s.memoryLimit);
    EXPECT_EQ(errorOf(ErrorKind::memory, [&] { renderScene(s); }).substr(0, 45),
              "the deep picture's samples need more than the");
    s.deep = ViewDeep{0.3};
    s.memoryLimit = flat + 4'000'000;
    EXPECT_GT(renderScene(s).deep->pieceCount(), 0u) << "merging makes room";
}

}  // namespace
}  // namespace scrim::test
