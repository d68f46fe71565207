#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "core/frame/gbuffer.hpp"
#include "core/scene/area_light.hpp"
#include "core/scene/geometry.hpp"

namespace penumbra {

/// The points that are asked about, in clusters small enough for bounds to say something: those of
/// one square of pixels that lie on one plane, or the others of such a square.
class Receivers {
  public:
    struct Cluster {
        Bounds box;                          ///< in the light's LightSpace; box.lo.z > 0
        std::uint32_t first = 0, count = 0;  ///< of points()
        /// All points lie on one plane that the whole light is above.
        bool flat = false;
        glm::dvec3 normal{0.0};  ///< of that plane, unit
        double planeM = 0.0;     ///< the least dot(normal, point)
    };
    struct Sample {
        glm::vec3 position, normal;
    };

    explicit Receivers(const AreaLight& light) : light_(light) {}

    /// Adds the scored and horizon pixels, as far as they are in front of the light. Parallel; the
    /// result does not depend on the number of threads.
    void add(const GBuffer& gbuffer);

    const AreaLight& light() const { return light_; }
    const std::vector<Cluster>& clusters() const { return clusters_; }
    std::span<const glm::vec3> points(const Cluster& cluster) const {
        return {points_.data() + cluster.first, cluster.count};
    }
    /// Some of all points, evenly: at most kSamples, all of them where they are fewer.
    std::vector<Sample> samples() const;
    /// Whether some see part of the light below their horizon.
    bool sawHorizon() const { return sawHorizon_; }

    static constexpr std::size_t kSamples = 4096;

  private:
    AreaLight light_;
    std::vector<Cluster> clusters_;
    std::vector<glm::vec3> points_;
    bool sawHorizon_ = false;
    std::vector<Sample> samples_;  ///< of every G-buffer, at most kSamples each
};

}  // namespace penumbra
