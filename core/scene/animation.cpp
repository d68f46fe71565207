#include "core/scene/animation.hpp"

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>

namespace penumbra::scene_detail {
namespace {

glm::dquat quaternionOf(const glm::dvec4& v) {
    return glm::normalize(glm::dquat(v.w, v.x, v.y, v.z));
}

glm::dvec4 vectorOf(const glm::dquat& q) {
    return {q.x, q.y, q.z, q.w};
}

}  // namespace

glm::dvec4 Curve::at(double timeS) const {
    const std::size_t stride = interpolation == Interpolation::cubicSpline ? 3 : 1;
    const auto value = [&](std::size_t key) { return values[key * stride + stride / 2]; };
    if (timeS <= times.front()) return value(0);
    if (timeS >= times.back()) return value(times.size() - 1);
    const std::size_t next = static_cast<std::size_t>(
        std::upper_bound(times.begin(), times.end(), timeS) - times.begin());
    const std::size_t key = next - 1;
    if (interpolation == Interpolation::step) return value(key);
    const double span = times[next] - times[key];
    const double t = (timeS - times[key]) / span;
    if (interpolation == Interpolation::cubicSpline) {
        // glTF 2.0 specification, appendix C.5.
        const double t2 = t * t, t3 = t2 * t;
        const glm::dvec4 outTangent = values[3 * key + 2], inTangent = values[3 * next];
        return (2 * t3 - 3 * t2 + 1) * value(key) + span * (t3 - 2 * t2 + t) * outTangent +
               (3 * t2 - 2 * t3) * value(next) + span * (t3 - t2) * inTangent;
    }
    if (quaternion) {
        return vectorOf(glm::slerp(quaternionOf(value(key)), quaternionOf(value(next)), t));
    }
    return glm::mix(value(key), value(next), t);
}

glm::dmat4 Transform::matrix() const {
    const glm::dmat4 turned =
        glm::translate(glm::dmat4(1.0), translation) * glm::mat4_cast(rotation);
    return glm::scale(turned, scale);
}

void Transform::set(NodeProperty property, const glm::dvec4& value) {
    switch (property) {
        case NodeProperty::translation:
            translation = glm::dvec3(value);
            break;
        case NodeProperty::rotation:
            rotation = quaternionOf(value);
            break;
        case NodeProperty::eulerDegrees:
            rotation = glm::dquat(glm::radians(glm::dvec3(value)));
            break;
        case NodeProperty::scale:
            scale = glm::dvec3(value);
            break;
        case NodeProperty::weight:
            break;
    }
}

}  // namespace penumbra::scene_detail
