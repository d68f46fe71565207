#pragma once

#include <glm/glm.hpp>
#include <optional>

#include "core/scene/area_light.hpp"
#include "core/scene/asset.hpp"
#include "core/scene/camera.hpp"
#include "core/scene/geometry.hpp"

namespace penumbra::scene_detail {

/// A rectangle that faces `target`, `size` metres wide and high, its height as close to `up` as
/// possible. Default up: -Z where it faces within 60 degrees of the vertical, else +Y. Nothing
/// when target == position or up lies along the direction.
std::optional<AreaLight> lightFacing(const glm::dvec3& position, const glm::dvec3& target,
                                     const std::optional<glm::dvec3>& up, const glm::dvec2& size);

/// A perspective camera. Default up: +Y, or -Z where it looks straight up or down. Nothing when
/// target == position or up lies along the direction.
std::optional<Camera> cameraFacing(const glm::dvec3& position, const glm::dvec3& target,
                                   const std::optional<glm::dvec3>& up, double fovYRad);

/// `lens` with the pose of a node: its axes without scale, so that a mirroring or stretching node
/// does not distort the image.
Camera cameraOfNode(const Camera& lens, const glm::dmat4& world);

/// A square light for an asset of these bounds: side 0.5 radius, at 3 radii from the centre towards
/// (0.45, 1, 0.35), facing the centre.
AreaLight lightForBounds(const Bounds& bounds);

/// A camera that sees the bounding sphere with a margin: 40 degrees, from (0.6, 0.55, 1).
Camera cameraForBounds(const Bounds& bounds);

/// A horizontal square below the bounds, facing up: 6 radii wide, or less where one of its corners
/// would lie more than 60 degrees off the normal of `light`, but never less than 2.
struct GroundPlate {
    glm::dvec3 centre;
    double widthM;

    AssetPrimitive primitive(int material) const;  ///< around the origin, to be moved to `centre`
};
GroundPlate groundFor(const Bounds& bounds, const AreaLight& light);

/// Measures whether an asset stands on something of its own: up-facing, nearly horizontal triangles
/// near the bottom of its bounds that cover at least half of its footprint.
class FloorMeter {
  public:
    explicit FloorMeter(const Bounds& bounds) : bounds_(bounds) {}
    /// Corners in world space, counter-clockwise seen from the front.
    void add(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c);
    bool hasFloor() const;

  private:
    Bounds bounds_;
    double coveredM2_ = 0.0;
};

}  // namespace penumbra::scene_detail
