#include "core/trace/tracer.hpp"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "core/trace/alpha_mask.hpp"

namespace penumbra {

namespace {

constexpr unsigned kOpaqueGeometry = 0, kMaskedGeometry = 1;

/// The triangles of alpha-masked materials, in the order of Embree's primitives.
struct MaskedTriangles {
    const Geometry& geometry;
    std::vector<AlphaMask> masks;
    std::vector<std::uint32_t> triangles;  ///< the geometry's
    std::vector<std::uint32_t> maskOf;     ///< index into `masks`
};

glm::vec2 interpolatedUv(const Geometry& geometry, std::uint32_t triangle, float u, float v) {
    const std::uint32_t* corner = &geometry.indices[3 * triangle];
    return (1.0f - u - v) * geometry.uvs[corner[0]] + u * geometry.uvs[corner[1]] +
           v * geometry.uvs[corner[2]];
}

/// Rejects hits where the material is absent; used for first hits and for occlusion alike.
void alphaFilter(const RTCFilterFunctionNArguments* args) {
    const auto& masked = *static_cast<const MaskedTriangles*>(args->geometryUserPtr);
    for (unsigned i = 0; i < args->N; ++i) {
        if (args->valid[i] == 0) continue;
        const unsigned primitive = RTCHitN_primID(args->hit, args->N, i);
        const glm::vec2 uv =
            interpolatedUv(masked.geometry, masked.triangles[primitive],
                           RTCHitN_u(args->hit, args->N, i), RTCHitN_v(args->hit, args->N, i));
        if (!masked.masks[masked.maskOf[primitive]].present(uv)) args->valid[i] = 0;
    }
}

/// Distance from rounding: the greatest coordinate's, in units in the last place.
///
/// Three roundings can put a surface in front of a point that lies on it: the point's own (half an
/// ulp per coordinate), that of the vertices of a neighbouring triangle of the same flat or convex
/// surface (as much again), and the ray-triangle test's, which grows with the triangle. One ulp is
/// not enough for tilted planes, two were for every case of tests/core/trace_test.cpp; 6 leaves
/// room. More would let points in the fold of a crease see past it: at 16 the worst pixels of
/// `arcade` and `foliage` saw a hundredth of the light too much. All of it scales with the
/// coordinates.
constexpr float kOffsetUlps = 6.0f;

}  // namespace

struct Tracer::Impl {
    std::shared_ptr<const Geometry> geometry;
    MaskedTriangles masked;
    std::vector<std::uint32_t> opaqueTriangles;
    Bounds bounds;
    float offset = 0.0f;
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;

    explicit Impl(std::shared_ptr<const Geometry> shape)
        : geometry(std::move(shape)), masked{*geometry, {}, {}, {}} {}
    ~Impl() {
        if (scene) rtcReleaseScene(scene);
        if (device) rtcReleaseDevice(device);
    }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    void check() const {
        const RTCError error = rtcGetDeviceError(device);
        if (error != RTC_ERROR_NONE)
            throw std::runtime_error("Embree error " + std::to_string(error) +
                                     " while building the scene's BVH");
    }

    void attach(RTCBuffer vertices, const std::vector<std::uint32_t>& triangles, unsigned id,
                bool filtered) {
        if (triangles.empty()) return;
        RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        rtcSetGeometryBuildQuality(mesh, RTC_BUILD_QUALITY_HIGH);
        rtcSetGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices, 0,
                             sizeof(glm::vec3), geometry->positions.size());
        auto* indices = static_cast<std::uint32_t*>(
            rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                    3 * sizeof(std::uint32_t), triangles.size()));
        check();
        for (const std::uint32_t triangle : triangles)
            for (int k = 0; k < 3; ++k) *indices++ = geometry->indices[3 * triangle + k];
        if (filtered) {
            rtcSetGeometryUserData(mesh, &masked);
            rtcSetGeometryIntersectFilterFunction(mesh, alphaFilter);
            rtcSetGeometryOccludedFilterFunction(mesh, alphaFilter);
        }
        rtcCommitGeometry(mesh);
        rtcAttachGeometryByID(scene, mesh, id);
        rtcReleaseGeometry(mesh);
    }
};

Tracer::Tracer(std::shared_ptr<const Geometry> geometry, const std::vector<Material>& materials,
               const std::vector<TextureImage>& images)
    : impl_(std::make_unique<Impl>(std::move(geometry))) {
    Impl& impl = *impl_;
    const Geometry& shape = *impl.geometry;
    for (const Part& part : shape.parts) {
        const Material& material = materials[part.material];
        const auto mask = static_cast<std::uint32_t>(impl.masked.masks.size());
        if (material.masked) impl.masked.masks.emplace_back(material, images);
        for (std::uint32_t i = part.firstIndex; i < part.firstIndex + part.indexCount; i += 3) {
            if (material.masked) {
                impl.masked.triangles.push_back(i / 3);
                impl.masked.maskOf.push_back(mask);
            } else {
                impl.opaqueTriangles.push_back(i / 3);
            }
        }
    }
    impl.bounds = boundsOf(shape.positions);
    double greatest = 0.0;
    if (!impl.bounds.empty()) {
        const glm::dvec3 reach = glm::max(glm::abs(impl.bounds.lo), glm::abs(impl.bounds.hi));
        greatest = std::max({reach.x, reach.y, reach.z});
    }
    impl.offset =
        kOffsetUlps * std::numeric_limits<float>::epsilon() * static_cast<float>(greatest);

    impl.device = rtcNewDevice(nullptr);
    if (!impl.device) throw std::runtime_error("Embree: no device");
    impl.scene = rtcNewScene(impl.device);
    rtcSetSceneFlags(impl.scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(impl.scene, RTC_BUILD_QUALITY_HIGH);
    // Embree reads vertices 16 bytes at a time, so the last one needs room after it.
    const std::size_t bytes = shape.positions.size() * sizeof(glm::vec3);
    RTCBuffer vertices = rtcNewBuffer(impl.device, bytes + 16);
    impl.check();
    std::copy(shape.positions.begin(), shape.positions.end(),
              static_cast<glm::vec3*>(rtcGetBufferData(vertices)));
    impl.attach(vertices, impl.opaqueTriangles, kOpaqueGeometry, false);
    impl.attach(vertices, impl.masked.triangles, kMaskedGeometry, true);
    rtcReleaseBuffer(vertices);
    rtcCommitScene(impl.scene);
    impl.check();
}

Tracer::~Tracer() = default;

const Geometry& Tracer::geometry() const {
    return *impl_->geometry;
}

namespace {

/// Where the ray enters and leaves the box; from > to where it misses.
struct Interval {
    double from, to;
};

Interval clipToBox(const Bounds& box, const glm::dvec3& origin, const glm::dvec3& direction,
                   Interval range) {
    for (int axis = 0; axis < 3; ++axis) {
        if (direction[axis] == 0.0) {
            if (origin[axis] < box.lo[axis] || origin[axis] > box.hi[axis]) return {1.0, 0.0};
            continue;
        }
        const double a = (box.lo[axis] - origin[axis]) / direction[axis];
        const double b = (box.hi[axis] - origin[axis]) / direction[axis];
        range.from = std::max(range.from, std::min(a, b));
        range.to = std::min(range.to, std::max(a, b));
    }
    return range;
}

}  // namespace

SurfaceHit Tracer::firstHit(const glm::dvec3& origin, const glm::dvec3& direction, double tNear,
                            double tFar) const {
    const Impl& impl = *impl_;
    if (impl.bounds.empty()) return {};
    // Start at the scene's (slightly grown) bounds: seen from far away, float would otherwise spend
    // its digits on the way there.
    const glm::dvec3 margin(1e-5 * impl.bounds.radius());
    const Bounds grown{impl.bounds.lo - margin, impl.bounds.hi + margin};
    const Interval range = clipToBox(grown, origin, direction, {tNear, tFar});
    if (range.from > range.to) return {};
    const glm::dvec3 start = origin + range.from * direction;

    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit query{};
    query.ray.org_x = static_cast<float>(start.x);
    query.ray.org_y = static_cast<float>(start.y);
    query.ray.org_z = static_cast<float>(start.z);
    query.ray.dir_x = static_cast<float>(direction.x);
    query.ray.dir_y = static_cast<float>(direction.y);
    query.ray.dir_z = static_cast<float>(direction.z);
    query.ray.tfar = static_cast<float>(range.to - range.from);
    query.ray.mask = ~0u;
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(impl.scene, &context, &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};

    SurfaceHit hit;
    hit.hit = true;
    hit.triangle = query.hit.geomID == kMaskedGeometry ? impl.masked.triangles[query.hit.primID]
                                                       : impl.opaqueTriangles[query.hit.primID];
    const Geometry& shape = *impl.geometry;
    const std::uint32_t* corner = &shape.indices[3 * hit.triangle];
    const glm::dvec3 a(shape.positions[corner[0]]), b(shape.positions[corner[1]]),
        c(shape.positions[corner[2]]);
    const double u = query.hit.u, v = query.hit.v;
    // Interpolated in double the point is on the plane whatever the rounding of u and v; the exact
    // crossing with the plane is also on the ray. It is ill-defined only along the plane.
    hit.position = (1.0 - u - v) * a + u * b + v * c;
    const glm::dvec3 normal = glm::cross(b - a, c - a);
    const double approach = glm::dot(normal, direction);
    if (std::abs(approach) > 1e-4 * glm::length(normal) * glm::length(direction))
        hit.position = origin + glm::dot(normal, a - origin) / approach * direction;

    const glm::dvec3 towardsOrigin = approach > 0.0 ? -normal : normal;
    hit.geometricNormal = glm::vec3(glm::normalize(towardsOrigin));
    const glm::dvec3 shading = (1.0 - u - v) * glm::dvec3(shape.normals[corner[0]]) +
                               u * glm::dvec3(shape.normals[corner[1]]) +
                               v * glm::dvec3(shape.normals[corner[2]]);
    const double length = glm::length(shading);
    hit.shadingNormal = length > 0.0 ? glm::vec3(shading / length) : hit.geometricNormal;
    if (glm::dot(hit.shadingNormal, hit.geometricNormal) < 0.0f)
        hit.shadingNormal = -hit.shadingNormal;
    hit.uv = interpolatedUv(shape, hit.triangle, query.hit.u, query.hit.v);
    hit.material = shape.parts[shape.partOf(hit.triangle)].material;
    return hit;
}

glm::vec3 Tracer::shadowOrigin(const glm::vec3& position, const glm::vec3& geometricNormal) const {
    return position + impl_->offset * geometricNormal;
}

struct Tracer::Stream::Rays {
    std::array<RTCRay, kStreamSize> ray;
};

Tracer::Stream::Stream(const Tracer& tracer) : tracer_(tracer), rays_(std::make_unique<Rays>()) {
    // What is the same for all rays; Embree changes nothing but tfar.
    for (RTCRay& ray : rays_->ray) {
        ray = {};
        ray.mask = ~0u;
    }
}
Tracer::Stream::~Stream() = default;

namespace {

void setSegment(RTCRay& ray, const glm::vec3& origin, const glm::vec3& direction) {
    ray.org_x = origin.x;
    ray.org_y = origin.y;
    ray.org_z = origin.z;
    ray.dir_x = direction.x;
    ray.dir_y = direction.y;
    ray.dir_z = direction.z;
    ray.tfar = 1.0f - 1e-4f;
}

}  // namespace

void Tracer::Stream::add(const glm::vec3& origin, const glm::vec3& target) {
    setSegment(rays_->ray[size_++], origin, target - origin);
}

void Tracer::Stream::addToRectangle(const glm::vec3& origin, const glm::vec3& corner,
                                    const glm::vec3& edgeU, const glm::vec3& edgeV, const float* s,
                                    const float* t, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i)
        setSegment(rays_->ray[size_ + i], origin, corner + s[i] * edgeU + t[i] * edgeV - origin);
    size_ += count;
}

void Tracer::Stream::trace() {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    rtcOccluded1M(tracer_.impl_->scene, &context, rays_->ray.data(), static_cast<unsigned>(size_),
                  sizeof(RTCRay));
}

void Tracer::Stream::readVisible(std::uint8_t* out) const {
    for (std::size_t i = 0; i < size_; ++i) out[i] = rays_->ray[i].tfar >= 0.0f;
}

bool Tracer::Stream::blocked(std::size_t i) const {
    return rays_->ray[i].tfar < 0.0f;
}

}  // namespace penumbra
