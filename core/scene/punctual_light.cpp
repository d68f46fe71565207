#include "core/scene/punctual_light.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <tuple>

#include "core/scene/input_text.hpp"
#include "core/scene/placement.hpp"
#include "core/scene/supported_input.hpp"

namespace penumbra::scene_detail {
namespace {

constexpr double kDirectionalRadii = 100.0;

}  // namespace

std::optional<std::size_t> brightest(const std::vector<AssetLight>& lights) {
    std::optional<std::size_t> best;
    const auto rank = [&](std::size_t i) {
        return std::tuple(lights[i].kind != AssetLight::Kind::directional, lights[i].intensity);
    };
    for (std::size_t i = 0; i < lights.size(); ++i) {
        if (!best || rank(i) > rank(*best)) best = i;
    }
    return best;
}

std::optional<AreaLight> placedPunctual(const AssetLight& light, const glm::dmat4& world,
                                        const Bounds& bounds) {
    glm::dvec3 position(world[3]);
    const glm::dvec3 backwards(world[2]);
    const double length = glm::length(backwards);
    if (!(glm::length(position) < kMaxExtentM)) return std::nullopt;
    glm::dvec3 target = bounds.centre();
    if (light.kind != AssetLight::Kind::point) {
        if (!(length > 0.0 && std::isfinite(length))) return std::nullopt;
        const double reach = bounds.radius();
        if (light.kind == AssetLight::Kind::directional) {
            position = target + kDirectionalRadii * reach / length * backwards;
        } else {
            target = position - reach / length * backwards;
        }
    } else if (position == target) {
        target.y -= bounds.radius();
    }
    return lightFacing(position, target, std::nullopt, glm::dvec2(0.0));
}

std::string describe(const AssetLight& light, std::size_t count) {
    static constexpr std::array<const char*, 3> kHow = {
        "point light", "spot light, as a point light without its cone",
        "directional light, as a point light 100 radii away"};
    return oneLine(
        fmt::format("light: '{}', the {}{}", light.name, kHow[static_cast<std::size_t>(light.kind)],
                    count > 1 ? fmt::format("; {} others do not shine", count - 1) : ""));
}

}  // namespace penumbra::scene_detail
