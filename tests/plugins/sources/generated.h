// SPDX-License-Identifier: Apache-2.0
// What all tests of volume sources share: running one, and asking its field for values and sums.
#pragma once

#include "support/expect_error.h"
#include "support/temp_folder.h"
#include "support/vdb_make.h"

#include <scrim/volume/source.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <glm/matrix.hpp>

namespace scrim::test {

using Parameters = std::vector<std::pair<std::string, std::string>>;

/// Runs every voxel above 0: its place in index space and its value.
inline void forVoxels(const SparseField& field, const std::function<void(const Int3&, float)>& visit) {
    for (std::size_t i = 0; i < field.blockCount(); ++i)
        for (int x = 0; x < 8; ++x)
            for (int y = 0; y < 8; ++y)
                for (int z = 0; z < 8; ++z)
                    if (const float v = field.block(i)[blockOffset(x, y, z)]; v > 0)
                        visit(field.blockOrigins[i] + Int3(x, y, z), v);
    for (const ConstantTile& t : field.tiles)
        for (int x = 0; x < t.edge; ++x)
            for (int y = 0; y < t.edge; ++y)
                for (int z = 0; z < t.edge; ++z) visit(t.origin + Int3(x, y, z), t.value);
}

/// The value of a voxel, 0 where there is none.
inline float valueAt(const SparseField& field, const Int3& voxel) {
    for (const ConstantTile& t : field.tiles) {
        const Int3 p = voxel - t.origin;
        if (p.x >= 0 && p.y >= 0 && p.z >= 0 && p.x < t.edge && p.y < t.edge && p.z < t.edge) return t.value;
    }
    for (std::size_t i = 0; i < field.blockCount(); ++i) {
        const Int3 p = voxel - field.blockOrigins[i];
        if (p.x >= 0 && p.y >= 0 && p.z >= 0 && p.x < 8 && p.y < 8 && p.z < 8)
            return field.block(i)[blockOffset(p.x, p.y, p.z)];
    }
    return 0;
}

/// The value of the voxel whose cell holds a place in the world.
inline float valueAt(const SparseField& field, const Vec3& ws) {
    const Vec3 is = transformPoint(glm::inverse(field.wsFromIs), ws);
    return valueAt(field, Int3(static_cast<int>(std::lround(is.x)), static_cast<int>(std::lround(is.y)),
                               static_cast<int>(std::lround(is.z))));
}

/// The integral of the field over the world.
inline double mass(const SparseField& field) {
    const Vec3 x = transformVector(field.wsFromIs, {1, 0, 0}), y = transformVector(field.wsFromIs, {0, 1, 0}),
               z = transformVector(field.wsFromIs, {0, 0, 1});
    const double voxel =
        std::abs(x.x * (y.y * z.z - y.z * z.y) + x.y * (y.z * z.x - y.x * z.z) + x.z * (y.x * z.y - y.y * z.x));
    double sum = 0;
    forVoxels(field, [&](const Int3&, float v) { sum += static_cast<double>(v); });
    return sum * voxel;
}

/// Runs one of the built-in sources.
class BuiltSource : public ::testing::Test {
  protected:
    void SetUp() override { ::setenv("SCRIM_PLUGIN_PATH", SCRIM_BUILT_SOURCES, 1); }
    void TearDown() override { ::unsetenv("SCRIM_PLUGIN_PATH"); }

    static std::vector<SparseField> makeAll(const std::string& source, const Parameters& parameters) {
        return generate(source, parameters, {});
    }
    static SparseField make(const std::string& source, const Parameters& parameters) {
        return makeAll(source, parameters).at(0);
    }
    /// What it says where it must fail, without "source 'NAME': " before it.
    static std::string reason(const std::string& source, const Parameters& parameters) {
        const std::string text = errorOf(ErrorKind::input, [&] { generate(source, parameters, {}); });
        const std::string start = "source '" + source + "': ";
        EXPECT_TRUE(text.starts_with(start)) << text;
        return text.substr(std::min(start.size(), text.size()));
    }

    std::string file(const std::string& name) const { return m_folder.file(name); }
    /// Writes a file and returns its path.
    std::string write(const std::string& name, const std::string& bytes) const {
        writeBytes(file(name), bytes);
        return file(name);
    }

    TempFolder m_folder;
};

/// Runs the source `scan` on a file.
class ScanSource : public BuiltSource {
  protected:
    /// The light that a number from 0 to 255 stands for in sRGB (IEC 61966-2-1).
    static float lightOf(float number) {
        const double part = double(number) / 255;
        return static_cast<float>(part <= 0.04045 ? part / 12.92 : std::pow((part + 0.055) / 1.055, 2.4));
    }
    /// 2 x 3 x 4 colours (n, 2 n, 255 - n) of 255 with n = 1 + x + 2 y + 6 z as light, and their luma in units of
    /// `white` / 255.
    static void expectColours(const std::string& path, float white, const std::string& type) {
        const std::vector<SparseField> grids = makeAll("scan", {{"file", path}});
        ASSERT_EQ(grids.size(), 4u) << path;
        for (std::size_t i = 0; i < 4; ++i)
            EXPECT_EQ(grids[i].name, (std::array{"density", "color.r", "color.g", "color.b"})[i]) << path;
        for (int z = 0; z < 4; ++z)
            for (int y = 0; y < 3; ++y)
                for (int x = 0; x < 2; ++x) {
                    const auto n = static_cast<float>(1 + x + 2 * y + 6 * z);
                    const std::array colour{n / 255, 2 * n / 255, (255 - n) / 255};
                    const float luma = white * (0.2126f * colour[0] + 0.7152f * colour[1] + 0.0722f * colour[2]);
                    EXPECT_NEAR(valueAt(grids[0], Int3(x, y, z)), luma, 1e-5f * white) << path;
                    for (std::size_t c = 0; c < 3; ++c)
                        EXPECT_NEAR(valueAt(grids[c + 1], Int3(x, y, z)), lightOf(255 * colour[c]), 1e-6f)
                            << path << " " << c;
                }
        const std::vector<SparseField> described = makeAll("scan", {{"file", path}, {"describe", "true"}});
        EXPECT_EQ(described.at(1).name.substr(0, 11 + type.size()), "samples of " + type) << path;
    }
    static SparseField read(const std::string& path, Parameters more = {}) {
        more.insert(more.begin(), {"file", path});
        return make("scan", more);
    }
    static std::string refused(const std::string& path, Parameters more = {}) {
        more.insert(more.begin(), {"file", path});
        return reason("scan", more);
    }
};

}  // namespace scrim::test
