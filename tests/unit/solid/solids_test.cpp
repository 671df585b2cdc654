// SPDX-License-Identifier: Apache-2.0
#include <scrim/solid/solids.h>

#include "support/expect_error.h"
#include "support/meshes.h"

#include <gtest/gtest.h>

#include <cstddef>

#include <dlfcn.h>

namespace {

// What Embree has given out and not taken back.
int scenes = 0, geometries = 0;
bool outOfMemory = false;

template <typename Function>
Function* embree(const char* name) {
    return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

}  // namespace

// The whole program's Embree, by which a test counts, and plays a machine without memory.
extern "C" {
void* rtcNewScene(void* device) {
    ++scenes;
    return embree<void*(void*)>("rtcNewScene")(device);
}
void rtcReleaseScene(void* scene) {
    --scenes;
    embree<void(void*)>("rtcReleaseScene")(scene);
}
void* rtcNewGeometry(void* device, int type) {
    ++geometries;
    return embree<void*(void*, int)>("rtcNewGeometry")(device, type);
}
void rtcReleaseGeometry(void* geometry) {
    --geometries;
    embree<void(void*)>("rtcReleaseGeometry")(geometry);
}
void* rtcSetNewGeometryBuffer(void* geometry, int type, unsigned slot, int format, std::size_t stride,
                              std::size_t count) {
    if (outOfMemory) return nullptr;
    return embree<void*(void*, int, unsigned, int, std::size_t, std::size_t)>("rtcSetNewGeometryBuffer")(
        geometry, type, slot, format, stride, count);
}
}

namespace scrim::test {
namespace {

TEST(Solids, LeaveNothingBehindWhereThereIsNoMemoryForThem) {
    const auto mesh =
        std::make_shared<const TriangleMesh>(TriangleMesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}});
    const int before = scenes;
    {
        const Solids solids({{.name = "wall", .mesh = mesh}});
        EXPECT_GT(scenes, before);
    }
    EXPECT_EQ(scenes, before);
    outOfMemory = true;
    EXPECT_EQ(errorOf(ErrorKind::memory, [&] { const Solids solids({{.name = "wall", .mesh = mesh}}); }),
              "not enough memory to trace rays to the meshes");
    outOfMemory = false;
    EXPECT_EQ(scenes, before);
    EXPECT_EQ(geometries, 0);
}

}  // namespace
}  // namespace scrim::test
