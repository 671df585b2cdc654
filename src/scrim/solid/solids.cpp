// SPDX-License-Identifier: Apache-2.0
#include <scrim/solid/solids.h>

#include <scrim/base/error.h>
#include <scrim/base/system_error.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <set>
#include <utility>

#include <embree3/rtcore.h>
#include <fmt/format.h>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kRoles = 3;

/// Memory where memory is limited, else `kind`: Embree does not always report that memory was insufficient.
ErrorKind unlessLimited(ErrorKind kind) {
    constexpr std::size_t kEnough = std::size_t{1} << 30;
    return limitsMemory(kEnough) ? ErrorKind::memory : kind;
}

// Embree's device for the whole process, which shares its threads' memory. Only single rays are traced with it.
RTCDevice device() {
    static const RTCDevice one = rtcNewDevice(nullptr);
    if (one == nullptr)
        throw Error(unlessLimited(ErrorKind::render), "Embree, which traces rays to meshes, cannot be started");
    return one;
}

}  // namespace

struct Solids::Traced {
    Bounds wsBounds;
    Vec3 wsMiddle{0};  // floats are relative to this point
    std::vector<Vec3> wsPoints;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<const Solid*> solidOf;  // for each triangle
    struct Release {
        void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
    };
    std::unique_ptr<RTCSceneTy, Release> scene;  // released also where the constructor throws

    Traced(const std::vector<Solid>& solids, SolidRole role) {
        for (const Solid& solid : solids)
            if (solid.has(role)) append(solid);
        if (triangles.empty()) return;
        wsMiddle = wsBounds.center();
        build();
    }
    Traced(const Traced&) = delete;
    Traced& operator=(const Traced&) = delete;

    void append(const Solid& solid) {
        const auto first = static_cast<std::uint32_t>(wsPoints.size());
        if (wsPoints.size() + solid.mesh->points.size() > std::numeric_limits<std::uint32_t>::max())
            throw Error(ErrorKind::memory, "the meshes have too many points");
        for (const Vec3& p : solid.mesh->points) {
            wsPoints.push_back(transformPoint(solid.wsFromMesh, p));
            wsBounds.include(wsPoints.back());
        }
        for (const auto& t : solid.mesh->triangles) triangles.push_back({first + t[0], first + t[1], first + t[2]});
        solidOf.resize(triangles.size(), &solid);
    }

    void build() {
        scene.reset(rtcNewScene(device()));
        rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);  // rays must not slip through between two triangles
        RTCGeometry geometry = rtcNewGeometry(device(), RTC_GEOMETRY_TYPE_TRIANGLE);
        auto* points = static_cast<float*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), wsPoints.size()));
        auto* corners = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), triangles.size()));
        if (points == nullptr || corners == nullptr) {
            rtcReleaseGeometry(geometry);
            throw Error(ErrorKind::memory, "not enough memory to trace rays to the meshes");
        }
        for (std::size_t i = 0; i < wsPoints.size(); ++i)
            for (int axis = 0; axis < 3; ++axis)
                points[3 * i + axis] = static_cast<float>(wsPoints[i][axis] - wsMiddle[axis]);
        for (std::size_t i = 0; i < triangles.size(); ++i)
            for (std::size_t k = 0; k < 3; ++k) corners[3 * i + k] = triangles[i][k];
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene.get(), geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene.get());
        if (const RTCError error = rtcGetDeviceError(device()); error != RTC_ERROR_NONE)
            throw Error(error == RTC_ERROR_OUT_OF_MEMORY ? ErrorKind::memory : unlessLimited(ErrorKind::render),
                        fmt::format("Embree could not take the meshes (error {})", static_cast<int>(error)));
    }

    Vec3 normal(std::uint32_t triangle) const {
        const auto& t = triangles[triangle];
        return glm::cross(wsPoints[t[1]] - wsPoints[t[0]], wsPoints[t[2]] - wsPoints[t[0]]);
    }
};

Solids::Solids(std::vector<Solid> solids) : m_solids(std::move(solids)) {
    const auto sameSolids = [&](SolidRole a, SolidRole b) {
        return std::all_of(m_solids.begin(), m_solids.end(), [&](const Solid& s) { return s.has(a) == s.has(b); });
    };
    for (int i = 0; i < kRoles; ++i) {
        const auto role = static_cast<SolidRole>(i);
        for (int known = 0; known < i && m_traced.size() == std::size_t(i); ++known)
            if (sameSolids(static_cast<SolidRole>(known), role)) m_traced.push_back(m_traced[std::size_t(known)]);
        if (m_traced.size() == std::size_t(i)) m_traced.push_back(std::make_shared<const Traced>(m_solids, role));
    }
}

Solids::~Solids() = default;

bool Solids::any(SolidRole role) const {
    return of(role).scene != nullptr;
}

bool Solids::anySendsBack() const {
    return std::ranges::any_of(m_solids, [](const Solid& solid) { return solid.sendsBack(); });
}

const Bounds& Solids::wsBounds(SolidRole role) const {
    return of(role).wsBounds;
}

SolidHit Solids::trace(SolidRole role, const Vec3& wsOrigin, const Vec3& wsDirection, double begin, double end) const {
    const Traced& traced = of(role);
    if (traced.scene == nullptr) return {kInfinity};
    const double length = glm::length(wsDirection);
    // The ray is started at the box, where floats are precise; an eye may be far away.
    const double slack = 1e-6 * (glm::length(traced.wsBounds.size()) + 1e-30) / length;
    const auto [enter, leave] = traced.wsBounds.clip(wsOrigin, wsDirection, -kInfinity, kInfinity);
    const double from = std::max(begin, enter - slack), to = std::min(end, leave + slack);
    if (!(from <= to)) return {kInfinity};
    const Vec3 start = wsOrigin + from * wsDirection - traced.wsMiddle, unit = wsDirection / length;
    RTCRayHit query{};
    query.ray.org_x = static_cast<float>(start.x);
    query.ray.org_y = static_cast<float>(start.y);
    query.ray.org_z = static_cast<float>(start.z);
    query.ray.dir_x = static_cast<float>(unit.x);
    query.ray.dir_y = static_cast<float>(unit.y);
    query.ray.dir_z = static_cast<float>(unit.z);
    query.ray.tnear = 0;
    query.ray.tfar = static_cast<float>((to - from) * length);
    query.ray.mask = ~0U;
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(traced.scene.get(), &context, &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {kInfinity};
    const double near = from + static_cast<double>(query.ray.tfar) / length;
    const Vec3 normal = traced.normal(query.hit.primID);
    const Vec3& corner = traced.wsPoints[traced.triangles[query.hit.primID][0]];
    const double exact = glm::dot(normal, corner - wsOrigin) / glm::dot(normal, wsDirection);
    // On a sliver of a triangle, or almost along one, its plane is less precise than the float, or useless.
    const double doubt = 1e-4 * (glm::length(traced.wsBounds.size()) + 1e-30) / length;
    const bool sure = std::abs(exact - near) < doubt;
    return {sure ? exact : near, normal, traced.solidOf[query.hit.primID]};
}

std::size_t Solids::bytes() const {
    std::size_t sum = 0;
    constexpr std::size_t kTreeBytes = 100;  // bytes for each triangle in Embree's tree, about
    for (const auto& traced : std::set(m_traced.begin(), m_traced.end()))
        sum += traced->wsPoints.size() * (sizeof(Vec3) + 3 * sizeof(float)) +
               traced->triangles.size() * (2 * sizeof(traced->triangles[0]) + kTreeBytes);
    return sum;
}

}  // namespace scrim
