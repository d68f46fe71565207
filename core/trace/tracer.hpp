#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <vector>

#include "core/scene/geometry.hpp"
#include "core/scene/material.hpp"

namespace penumbra {

/// The surface a camera ray meets first.
struct SurfaceHit {
    bool hit = false;
    std::uint32_t triangle = 0;
    glm::dvec3 position{
        0.0};  ///< on the triangle's plane, in double: rounding it to float is its only error
    glm::vec3 geometricNormal{0.0f};  ///< unit, towards the ray's origin
    glm::vec3 shadingNormal{0.0f};    ///< unit, interpolated, on the geometric normal's side
    glm::vec2 uv{0.0f};
    int material = 0;
};

/// A segment from `origin` to `target`, both relative to Scene::origin.
struct ShadowSegment {
    glm::vec3 origin, target;
};

/// Rays against one frame's geometry. Alpha-masked materials let a ray pass where their texture's
/// alpha is below the cutoff. The one tracer for the G-buffer, the reference, `ray_traced` and
/// analysis. All calls are const and thread-safe; parallelism is the caller's (TBB).
class Tracer {
  public:
    /// Builds the BVH on all threads of the current TBB arena. Keeps references to nothing but the
    /// shared geometry; materials and images must outlive it.
    Tracer(std::shared_ptr<const Geometry> geometry, const std::vector<Material>& materials,
           const std::vector<TextureImage>& images);
    ~Tracer();
    Tracer(const Tracer&) = delete;
    Tracer& operator=(const Tracer&) = delete;

    const Geometry& geometry() const;

    SurfaceHit firstHit(const glm::dvec3& origin, const glm::dvec3& direction, double tNear,
                        double tFar) const;

    /// How many rays one occlusion stream holds.
    static constexpr std::size_t kStreamSize = 256;

    /// A stream of shadow rays, filled ray by ray and traced at once. Reused for speed: ray setup
    /// and traversal touch the same 12 KiB. One per thread.
    class Stream;

    /// Origin of shadow rays that leave the surface at `position`: moved along the unit
    /// `geometricNormal` towards `towards` by the least distance that clears the rounding of
    /// positions at the geometry's extent, so that no surface shadows itself and the result is the
    /// same at any scale (METHODS.md R3).
    glm::vec3 shadowOrigin(const glm::vec3& position, const glm::vec3& geometricNormal) const;

  private:
    friend class Stream;
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Traces up to kStreamSize segments that start at shadowOrigin()s. A segment is blocked by any
/// surface strictly between its ends; the last 1e-4 of it does not count, so that what lies in the
/// light's own plane does not occlude.
class Tracer::Stream {
  public:
    explicit Stream(const Tracer& tracer);
    ~Stream();
    Stream(const Stream&) = delete;
    Stream& operator=(const Stream&) = delete;

    void clear() { size_ = 0; }
    std::size_t size() const { return size_; }
    bool full() const { return size_ == kStreamSize; }
    void add(const glm::vec3& origin, const glm::vec3& target);
    /// Adds `count` segments from `origin` to corner + s[i] edgeU + t[i] edgeV, as many add() calls
    /// would, at half their cost.
    void addToRectangle(const glm::vec3& origin, const glm::vec3& corner, const glm::vec3& edgeU,
                        const glm::vec3& edgeV, const float* s, const float* t, std::size_t count);
    /// Traces all rays added since clear(); afterwards blocked(i) tells of the i-th added.
    void trace();
    bool blocked(std::size_t i) const;
    /// out[i] = 1 where the i-th added segment is free, 0 where it is blocked; size() entries.
    void readVisible(std::uint8_t* out) const;

  private:
    const Tracer& tracer_;
    struct Rays;
    std::unique_ptr<Rays> rays_;
    std::size_t size_ = 0;
};

}  // namespace penumbra
