// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/model/frame.h>

#include <algorithm>

namespace scrim {

RenderWork& RenderWork::operator+=(const RenderWork& o) {
    voxelsFed += o.voxelsFed;
    footprints += o.footprints;
    texelsShaded += o.texelsShaded;
    lightSamples += o.lightSamples;
    pixelSheets += o.pixelSheets;
    layerSamples += o.layerSamples;
    solidRays += o.solidRays;
    caughtRays += o.caughtRays;
    deepSamples += o.deepSamples;
    sheets += o.sheets;
    scatterSweeps += o.scatterSweeps;
    cellDirections += o.cellDirections;
    scatterDirections += o.scatterDirections;
    shade += o.shade;
    // Scattered light is there beside all sweeps, the buffers of one only.
    const std::uint64_t scattered = std::max(bytes.scattered, o.bytes.scattered);
    if (o.bytes.total() - o.bytes.scattered > bytes.total() - bytes.scattered) bytes = o.bytes;
    bytes.scattered = scattered;
    return *this;
}

StageTimes& StageTimes::operator+=(const StageTimes& o) {
    prepare += o.prepare;
    scatter += o.scatter;
    splat += o.splat;
    attenuate += o.attenuate;
    shade += o.shade;
    composite += o.composite;
    return *this;
}

}  // namespace scrim
