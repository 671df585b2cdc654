// SPDX-License-Identifier: Apache-2.0
// What a program that uses the installed library does: makes a field in code, renders it, writes the picture, and
// looks at a pixel. Prints what is wrong and returns 1 where something is.
#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/base/version.h>
#include <scrim/image/exr.h>
#include <scrim/image/exr_read.h>
#include <scrim/engine/sweep.h>
#include <scrim/volume/field_builder.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

namespace {

constexpr int kResolution = 32;

// A box of fog, 16 voxels along each edge, around the origin.
std::shared_ptr<const scrim::SparseField> fog() {
    scrim::FieldBuilder builder("density", scrim::Mat4(1.0));
    const std::vector<float> ones(scrim::kBlockVoxels, 1.0f);
    for (int i = 0; i < 8; ++i) builder.addBlock(scrim::Int3(i >> 2 & 1, i >> 1 & 1, i & 1) * 8 - 8, ones.data());
    return std::make_shared<scrim::SparseField>(builder.finish());
}

scrim::ViewScene scene() {
    scrim::ViewScene out;
    out.camera.type = scrim::CameraType::orthographic;
    out.camera.wsPosition = {0, 0, 50};
    out.camera.height = 24;
    out.camera.resolution = scrim::Int2(kResolution);
    out.region = {0, 0, kResolution, kResolution};
    scrim::Medium medium;
    medium.densityScale = 0.1;
    const auto field = fog();
    out.volumes.push_back({"fog", field, field->wsFromIs, medium});
    out.lights.emplace_back();  // a distant one, along the view
    return out;
}

// Renders to `path`, and compares the middle of what is then in that file with the closed form.
int check(const char* path) {
    const scrim::ViewScene fogScene = scene();
    const scrim::Frame frame = scrim::render(fogScene, scrim::makePlan(fogScene, scrim::threadCount()));
    scrim::ExrOptions options;
    options.displayWindow = {0, 0, kResolution, kResolution};
    scrim::writeExr(path, frame.image, options);
    const scrim::Image image = scrim::readExr(path);

    // Straight through the middle: 16 voxels of extinction 0.1, lit from the front.
    const float* middle = image.rgba.data() + image.indexOf(kResolution / 2, kResolution / 2);
    const double tau = 1.6, alpha = 1 - std::exp(-tau);
    const double red = 0.9 / (8 * std::acos(-1.0)) * (1 - std::exp(-2 * tau));
    if (std::abs(middle[3] - alpha) < 0.01 * alpha && std::abs(middle[0] - red) < 0.01 * red) return 0;
    std::fprintf(stderr, "the pixel in the middle is %g with alpha %g instead of %g with alpha %g\n", double(middle[0]),
                 double(middle[3]), red, alpha);
    return 1;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: consumer OUT.exr\n");
        return 1;
    }
    try {
        std::printf("Scrim %s\n", scrim::scrimVersion().c_str());
        return check(argv[1]);
    } catch (const scrim::Error& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
