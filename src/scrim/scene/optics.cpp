// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/optics.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

// Radius, in voxels, of the balls in which space is tested for emptiness: half a block's edge.
constexpr double kEmptyRadius = 4;

// An upper bound on the index-space length of one world unit in any direction.
double longestOf(const Mat4& isFromWs) {
    double longest = 0;
    for (int axis = 0; axis < 3; ++axis) longest = std::max(longest, glm::length(Vec3(isFromWs[axis])));
    return longest * std::sqrt(3.0);
}

}  // namespace

bool scattersOnce(const ViewVolume& volume) {
    return !scattersFully(volume) && !volume.classified && !volume.field->empty() &&
           (!volume.scatter.empty() || volume.medium.albedo != Rgb(0));
}

FieldInWorld::FieldInWorld(const ViewField& view, Kernel kernel, FieldSamplers& samplers)
    : isFromWs(glm::inverse(view.wsFromIs)), isPerWs(longestOf(isFromWs)) {
    std::shared_ptr<const FieldSampler>& shared = samplers[view.field.get()];
    kernel = view.kernel.value_or(kernel);
    if (!shared || shared->kernel() != kernel) shared = std::make_shared<const FieldSampler>(*view.field, kernel);
    field = shared;
}

VolumeOptics::VolumeOptics(const ViewVolume& volume, Kernel kernel, FieldSamplers& samplers) : m_volume(&volume) {
    const auto placed = [&](const ViewField& field) { return FieldInWorld(field, kernel, samplers); };
    if (!volume.field->empty()) {
        m_density = placed(densityOf(volume));
        m_wsFromIs = glm::inverse(Mat3(m_density->isFromWs));
        const Mat3 rows = glm::transpose(Mat3(m_density->isFromWs));
        m_voxels = std::max({glm::length(rows[0]), glm::length(rows[1]), glm::length(rows[2])});
    }
    for (const ViewField& field : volume.scatter) m_scatter.push_back(placed(field));
    for (const ViewEmission& emission : volume.emission) m_emission.push_back(placed(emission.field));
    if (!volume.velocity) return;
    for (const ViewField& part : volume.velocity->parts) m_velocity.emplace_back(part, Kernel::linear, samplers);
    for (const Vec3& way : volume.velocity->wsRange().corners()) m_mostWay = std::max(m_mostWay, glm::length(way));
}

Vec3 VolumeOptics::wayTo(const Vec3& ws) const {
    Vec3 v;
    for (int axis = 0; axis < 3; ++axis)
        v[axis] = m_velocity[std::size_t(2 * axis)].value(ws) - m_velocity[std::size_t(2 * axis + 1)].value(ws);
    return m_volume->velocity->wsPath * v;
}

Rgb VolumeOptics::extinction(const Vec3& ws) const {
    if (!m_density) return Rgb(0);
    if (m_volume->classified) return Rgb(classified(ws).extinction);
    return m_volume->medium.densityScale * density(ws) * m_volume->medium.extinctionTint;
}

double VolumeOptics::mostExtinction(const Vec3& ws) const {
    if (!m_density) return 0;
    return m_volume->classified ? classified(ws).extinction : density(ws) * m_volume->medium.mostExtinction();
}

ClassifiedValue VolumeOptics::classified(const Vec3& ws) const {
    const Classified& look = *m_volume->classified;
    if (!m_volume->wsClip.empty() && depthIn(m_volume->wsClip, ws) < 0) return {};
    ClassifiedValue value = classify(look, density(ws));
    if (value.extinction > 0 && !look.gradientRamp.empty())
        value.extinction *= gradientFactor(look, glm::length(gradient(ws)));
    return value;
}

Vec3 VolumeOptics::shadingGradient(const Vec3& ws, double voxel) const {
    const Vec3 own = gradient(ws);
    if (m_volume->wsClip.empty()) return own;
    return own + cutGradient(*m_volume->classified, voxel) * facing(m_volume->wsClip, ws, voxel);
}

Rgb VolumeOptics::scattering(const Vec3& ws) const {
    if (m_volume->classified) {
        if (!m_density || !m_volume->classified->scatters) return Rgb(0);
        const ClassifiedValue value = classified(ws);
        return value.extinction * value.color * m_volume->classified->albedo;
    }
    const Medium& medium = m_volume->medium;
    if (m_scatter.empty()) return extinction(ws) * medium.albedo;
    const Vec3 from = origin(ws);
    const Rgb value(m_scatter[0].value(from), m_scatter[1].value(from), m_scatter[2].value(from));
    return medium.densityScale * value * medium.extinctionTint;
}

Rgb VolumeOptics::reflected(const Vec3& ws, double voxel, const Vec3& toLight, const Vec3& toEye) const {
    const Classified& look = *m_volume->classified;
    const ClassifiedValue value = classified(ws);
    if (value.extinction == 0) return Rgb(0);
    const Vec3 slope = shadingGradient(ws, voxel);
    const double length = glm::length(slope);
    const Vec3 normal = length > 0 ? -slope / length : Vec3(0);
    const Reflected share = phong(look, normal, normalWeight(look, length, voxel), toLight, toEye);
    return value.extinction / std::numbers::pi * (share.diffuse * value.color + share.specular);
}

Rgb VolumeOptics::emission(const Vec3& ws) const {
    Rgb sum(0);
    for (std::size_t i = 0; i < m_emission.size(); ++i) sum += emissionField(i, ws) * m_volume->emission[i].color;
    return sum;
}

Vec3 VolumeOptics::gradient(const Vec3& ws) const {
    Vec3 difference;
    if (m_velocity.empty())
        difference = m_density->field->difference(transformPoint(m_density->isFromWs, ws));
    else
        for (int axis = 0; axis < 3; ++axis)
            difference[axis] = density(ws + m_wsFromIs[axis]) - density(ws - m_wsFromIs[axis]);
    return glm::transpose(Mat3(m_density->isFromWs)) * (0.5 * difference);
}

double VolumeOptics::emptyDistance(const Vec3& ws) const {
    double distance = std::numeric_limits<double>::infinity();
    const auto isEmpty = [&](const FieldInWorld& f) {
        distance = std::min(distance, kEmptyRadius / f.isPerWs);
        return f.field->emptyAround(transformPoint(f.isFromWs, ws), kEmptyRadius + m_mostWay * f.isPerWs);
    };
    if (m_density && !isEmpty(*m_density)) return 0;
    return std::all_of(m_emission.begin(), m_emission.end(), isEmpty) ? distance : 0;
}

double VolumeOptics::evenAlong(const Vec3& ws, const Vec3& way, double reach) const {
    if (!m_density || !m_emission.empty() || !m_velocity.empty() || !m_volume->wsClip.empty()) return -1;
    if (m_volume->classified && !m_volume->classified->gradientRamp.empty()) return -1;
    return m_density->field->evenAlong(transformPoint(m_density->isFromWs, ws),
                                       transformVector(m_density->isFromWs, way), reach * m_voxels);
}

double emptyDistance(const std::vector<VolumeOptics>& volumes, const Vec3& ws) {
    double distance = std::numeric_limits<double>::infinity();
    for (const VolumeOptics& volume : volumes) {
        distance = std::min(distance, volume.emptyDistance(ws));
        if (distance == 0) break;
    }
    return distance;
}

Rgb opticalDepth(const std::vector<VolumeOptics>& volumes, const Bounds& wsBounds, double step, const Vec3& wsA,
                 const Vec3& wsB, std::optional<std::size_t> light) {
    const double length = glm::distance(wsA, wsB);
    if (length == 0 || volumes.empty()) return Rgb(0);
    const Vec3 direction = (wsB - wsA) / length;
    const auto [begin, end] = wsBounds.clip(wsA, direction, 0, length);
    const double gauss = 0.5 / std::sqrt(3.0);
    Rgb tau(0), before(-1);
    for (double t = begin; t < end;) {
        // Only where the last step met nothing, there may be nothing all around.
        if (const double empty = tau == before || t == begin ? emptyDistance(volumes, wsA + t * direction) : 0;
            empty > 0) {
            t += empty;
            continue;
        }
        const double own = std::min(step, end - t), middle = t + 0.5 * own;
        before = tau;
        for (const double at : {middle - gauss * own, middle + gauss * own})
            for (const VolumeOptics& volume : volumes)
                if (!light || litBy(volume.volume().shadows, *light))
                    tau += 0.5 * own * volume.extinction(wsA + at * direction);
        t += own;
    }
    return tau;
}

double mostDepth(const ViewVolume& volume, double distance) {
    const auto most = double(volume.field->maxValue);
    return distance *
           (volume.classified ? mostExtinction(*volume.classified, most) : most * volume.medium.mostExtinction());
}

}  // namespace scrim
