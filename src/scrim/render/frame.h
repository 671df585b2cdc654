// SPDX-License-Identifier: Apache-2.0
// What a render yields: the picture, and counts of the work it took.
#pragma once

#include <scrim/image/image.h>

#include <cstdint>

namespace scrim {

/// Counts of work done, not of time: equal scenes give equal numbers on every machine.
struct RenderWork {
    std::uint64_t voxelsFed = 0;   ///< voxels of value > 0, once a sweep and field
    std::uint64_t footprints = 0;  ///< voxel and sheet pairs splatted
    std::uint64_t texelsShaded = 0;
    std::uint64_t lightSamples = 0;  ///< cells of shadow buffers walked
    std::uint64_t lightLookups = 0;  ///< light and sample pairs shaded
    std::uint64_t slideLookups = 0;  ///< those of lights with a slide
    std::uint64_t pixelSheets = 0;   ///< pixel and sheet pairs composited
    std::uint64_t sheets = 0;
    std::uint64_t bufferBytes = 0;  ///< address space of the largest sweep's buffers

    RenderWork& operator+=(const RenderWork& o) {
        voxelsFed += o.voxelsFed;
        footprints += o.footprints;
        texelsShaded += o.texelsShaded;
        lightSamples += o.lightSamples;
        lightLookups += o.lightLookups;
        slideLookups += o.slideLookups;
        pixelSheets += o.pixelSheets;
        sheets += o.sheets;
        bufferBytes = bufferBytes > o.bufferBytes ? bufferBytes : o.bufferBytes;
        return *this;
    }
};

/// Seconds spent in each stage, wall clock.
struct StageTimes {
    double prepare = 0, splat = 0, attenuate = 0, shade = 0, composite = 0;
};

struct Frame {
    Image image;  ///< premultiplied, scene-linear, working space
    RenderWork work;
    StageTimes times;
};

}  // namespace scrim
