// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/model/frame.h>

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
    scatterDirections += o.scatterDirections;
    shade += o.shade;
    if (o.bytes.total() > bytes.total()) bytes = o.bytes;
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
