#include "core/frame/light_centre.hpp"

namespace penumbra {

std::optional<bool> centreSeen(const Frame& frame, std::size_t i, double edgeM) {
    const AreaLight& light = frame.light;
    const glm::dvec3 point(frame.gbuffer.position[i]), normal(frame.gbuffer.geometricNormal[i]);
    constexpr int kReach = 2;
    Tracer::Stream rays(frame.tracer);
    for (int y = -kReach; y <= kReach; ++y)
        for (int x = -kReach; x <= kReach; ++x) {
            const glm::dvec3 sideways =
                edgeM / kReach *
                (static_cast<double>(x) * light.axisU + static_cast<double>(y) * light.axisV);
            const glm::dvec3 direction = point + sideways - light.centre;
            const double t = glm::dot(normal, point - light.centre) / glm::dot(normal, direction);
            if (!(t > 0.5 && t < 2.0)) return std::nullopt;  // the surface is all but edge-on
            const glm::vec3 beside(light.centre + t * direction);
            rays.add(frame.tracer.shadowOrigin(beside, glm::vec3(normal)), glm::vec3(light.centre));
        }
    rays.trace();
    for (std::size_t k = 1; k < rays.size(); ++k)
        if (rays.blocked(k) != rays.blocked(0)) return std::nullopt;
    return !rays.blocked(0);
}

}  // namespace penumbra
