// SPDX-License-Identifier: Apache-2.0
// The inner loops alone, on data that fits the caches: what a stage costs per core and unit of its work.
#include <scrim/base/parallel.h>
#include <scrim/engine/splat/plane_stack.h>
#include <scrim/engine/composite/composite_tile.h>
#include <scrim/engine/splat/splatter.h>

#include <benchmark/benchmark.h>

#include <vector>

#include <glm/geometric.hpp>

namespace scrim {
namespace {

// 12^3 full blocks.
SparseField cube() {
    SparseField field;
    auto values = std::make_shared<std::vector<float>>();
    constexpr int kBlocks = 12;
    for (int i = 0; i < kBlocks * kBlocks * kBlocks; ++i) {
        field.blockOrigins.push_back(Int3(i / (kBlocks * kBlocks), i / kBlocks % kBlocks, i % kBlocks) * kBlockEdge);
        for (int v = 0; v < kBlockVoxels; ++v) values->push_back(0.5f + 0.001f * static_cast<float>(v));
    }
    field.blockValues = std::shared_ptr<const float>(values, values->data());
    field.activeVoxels = values->size();
    return field;
}

// One sheet and one texel a voxel, along an axis that is aligned with nothing.
void splatHere(benchmark::State& state) {
    const SparseField field = cube();
    Sheets sheets;
    sheets.ssFromWs = sweepRotation(glm::normalize(Vec3(1, 1.3, 0.8)), {0, 1, 0});
    Bounds ss;
    for (const Vec3& corner : Bounds{Vec3(-3), Vec3(99)}.corners()) ss.include(sheets.ssFromWs * corner);
    sheets.ssOrigin = glm::floor(ss.lower) - 2.0;
    sheets.width = (static_cast<int>(ss.upper.x - sheets.ssOrigin.x) + 20) / 16 * 16;
    sheets.height = (static_cast<int>(ss.upper.y - sheets.ssOrigin.y) + 20) / 16 * 16;
    sheets.count = static_cast<int>(ss.upper.z - sheets.ssOrigin.z) + 1;
    const FieldSplatter splatter(field, sheets.tsFrom(Mat4(1.0)), static_cast<Kernel>(state.range(0)), 16, 1.0f);
    constexpr int kBatch = 8;
    PlaneStack planes(kBatch, sheets.width, sheets.height, 1);
    for (auto _ : state)
        for (int first = 0; first < sheets.count; first += kBatch) {
            const int count = std::min(kBatch, sheets.count - first);
            for (int p = 0; p < count; ++p) planes.begin(p);
            benchmark::DoNotOptimize(splatter.splat(first, first + count, planes, 0));
            for (int p = 0; p < count; ++p) planes.finish(p);
        }
    state.counters["per_voxel"] =
        benchmark::Counter(static_cast<double>(field.activeVoxels),
                           benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
void splat(benchmark::State& state) {
    TaskArena(1).run([&] { splatHere(state); });
}
BENCHMARK(splat)->ArgName("kernel")->DenseRange(0, 2)->Unit(benchmark::kMillisecond);

// A tile of a shadow buffer; step 1 is a distant light, others a point light.
void attenuate(benchmark::State& state) {
    std::vector<float> extinction(64 * 64, 0.1f), tau(256), entry(256);
    AttenuateTile tile{};
    tile.extinction = {extinction.data(), 64, 64};
    tile.u = 10.3f;
    tile.v = 11.7f;
    tile.step = static_cast<float>(state.range(0)) / 10;
    tile.path = 1;
    tile.tau = tau.data();
    tile.tauStride = 16;
    tile.entry = entry.data();
    tile.entryStride = 16;
    for (auto _ : state) {
        attenuateTile(tile);
        benchmark::ClobberMemory();
    }
    state.counters["per_sample"] =
        benchmark::Counter(256, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(attenuate)->ArgName("tenths_of_a_texel")->Arg(10)->Arg(9);

void composite(benchmark::State& state) {
    constexpr int kSheets = 8, kSize = 64;
    std::vector<float> texels(kSize * kSize * 4 * kSheets, 0.001f), states(1024, 0.0f);
    RayTile rays{};
    for (int k = 0; k < kTileSize; ++k) {
        rays.u[k] = 10.2f + 0.6f * static_cast<float>(k % 16);
        rays.v[k] = 12.4f + 0.6f * static_cast<float>(k / 16);
        rays.stepU[k] = 0.7f;
        rays.stepV[k] = 0.3f;
    }
    const float* planes[kSheets];
    float steps[kSheets];
    for (int s = 0; s < kSheets; ++s) {
        planes[s] = texels.data() + s * kSize * kSize * 4;
        steps[s] = static_cast<float>(s);
    }
    for (auto _ : state) {
        compositeTile(rays, {planes, steps, kSheets, kSize, kSize}, state.range(0) != 0, states.data());
        benchmark::ClobberMemory();
    }
    state.counters["per_pixel_sheet"] = benchmark::Counter(
        256.0 * kSheets, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(composite)->ArgName("front_to_back")->Arg(1)->Arg(0);

}  // namespace
}  // namespace scrim

BENCHMARK_MAIN();
