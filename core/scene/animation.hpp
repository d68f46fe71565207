#pragma once

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <vector>

namespace penumbra::scene_detail {

enum class Interpolation { linear, step, cubicSpline };

/// A keyframed value of up to four components. Before the first and after the last key it holds
/// the value of that key.
struct Curve {
    std::vector<double> times;       ///< seconds, strictly increasing, at least one
    std::vector<glm::dvec4> values;  ///< one per time; cubicSpline: in-tangent, value, out-tangent
    Interpolation interpolation = Interpolation::linear;
    bool quaternion = false;  ///< interpolated on the sphere, (x, y, z, w)

    glm::dvec4 at(double timeS) const;
};

enum class NodeProperty {
    translation,
    rotation,      ///< quaternion (x, y, z, w)
    eulerDegrees,  ///< about X, then Y, then Z
    scale,
    weight  ///< of one morph target; no part of a Transform
};

/// A curve that drives one property of one node.
struct NodeTrack {
    int node = 0;
    NodeProperty property = NodeProperty::translation;
    Curve curve;
    int target = 0;  ///< which morph target, of `weight`
};

struct Transform {
    glm::dvec3 translation{0.0};
    glm::dquat rotation{1, 0, 0, 0};
    glm::dvec3 scale{1.0};

    glm::dmat4 matrix() const;
    void set(NodeProperty property, const glm::dvec4& value);
};

}  // namespace penumbra::scene_detail
