// SPDX-License-Identifier: Apache-2.0
#include "support/fields.h"

#include <scrim/scene/quality.h>

#include <scrim/base/parallel.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace scrim::test {

std::shared_ptr<SparseField> makeField(const Int3& lower, const Int3& upper, double voxel,
                                       const std::function<double(const Vec3& is)>& value) {
    auto field = std::make_shared<SparseField>();
    auto values = std::make_shared<std::vector<float>>();
    field->name = "density";
    for (int axis = 0; axis < 3; ++axis) field->wsFromIs[axis][axis] = voxel;
    const Int3 first = lower >> 3, last = upper >> 3;
    for (int x = first.x; x <= last.x; ++x)
        for (int y = first.y; y <= last.y; ++y)
            for (int z = first.z; z <= last.z; ++z) {
                std::array<float, kBlockVoxels> block{};
                for (int i = 0; i < kBlockVoxels; ++i) {
                    const Int3 p = Int3(x, y, z) * 8 + Int3(i >> 6, i >> 3 & 7, i & 7);
                    if (glm::any(glm::lessThan(p, lower)) || glm::any(glm::greaterThan(p, upper))) continue;
                    block[static_cast<std::size_t>(i)] = static_cast<float>(std::max(0.0, value(Vec3(p))));
                }
                const auto filled = std::count_if(block.begin(), block.end(), [](float v) { return v > 0; });
                if (filled == 0) continue;
                field->activeVoxels += static_cast<std::uint64_t>(filled);
                field->maxValue = std::max(field->maxValue, *std::max_element(block.begin(), block.end()));
                field->blockOrigins.push_back(Int3(x, y, z) * 8);
                values->insert(values->end(), block.begin(), block.end());
            }
    field->blockValues = std::shared_ptr<const float>(values, values->data());
    return field;
}

std::shared_ptr<SparseField> boxField(const Int3& lower, const Int3& upper, double voxel) {
    return makeField(lower, upper, voxel, [](const Vec3&) { return 1.0; });
}

std::shared_ptr<SparseField> smokeField(int radius, double voxel) {
    return makeField(Int3(-radius), Int3(radius), voxel, [radius](const Vec3& is) {
        const Vec3 p = is / double(radius);
        double bumps = 0, frequency = 4, amplitude = 0.3;
        for (int octave = 0; octave < 3; ++octave, frequency *= 1.9, amplitude *= 0.6)
            bumps += amplitude * std::sin(frequency * p.x + 1.3 * std::sin(frequency * p.y)) *
                     std::sin(frequency * p.y + octave + 1.1 * std::sin(frequency * p.z)) *
                     std::sin(frequency * p.z + 2 * octave + 1.2 * std::sin(frequency * p.x));
        return std::clamp(1.5 * (0.7 - glm::length(p) + bumps), 0.0, 1.0);
    });
}

ViewScene orthographicScene(std::shared_ptr<const SparseField> field, const Medium& medium, double height,
                            int resolution) {
    ViewScene scene;
    scene.camera.type = CameraType::orthographic;
    scene.camera.height = height;
    scene.camera.resolution = Int2(resolution);
    const Bounds ws = transformed(field->wsFromIs, field->isBounds());
    scene.camera.wsPosition = {0, 0, ws.upper.z + 2 * height};
    scene.region = {0, 0, resolution, resolution};
    scene.volumes.push_back({"volume", field, field->wsFromIs, medium});
    // One to a voxel: boxes of voxels then are whole sheets of whole texels, which closed forms like.
    scene.dials.texel = scene.dials.sheetThickness = 1;
    return scene;
}

Light distantLight(const Vec3& direction, double irradiance) {
    Light light;
    light.name = "light";
    light.wsDirection = glm::normalize(direction);
    light.intensity = Rgb(irradiance);
    return light;
}

Light lamp(const Vec3& wsPosition, double intensity, double radius) {
    Light light;
    light.name = "lamp";
    light.kind = Light::Point{};
    light.wsPosition = wsPosition;
    light.intensity = Rgb(intensity);
    light.point().radius = radius;
    return light;
}

Frame renderScene(const ViewScene& scene) {
    return render(scene, makePlan(scene, threadCount()));
}

std::string nameOf(Kernel kernel) {
    Dials dials;
    dials.kernel = kernel;
    return dialText(dials, "kernel");
}

std::array<double, 4> pixelOf(const Frame& frame, int x, int y) {
    std::array<double, 4> out;
    const float* rgba = frame.image.rgba.data() + frame.image.indexOf(x, y);
    std::copy(rgba, rgba + 4, out.begin());
    return out;
}

}  // namespace scrim::test
