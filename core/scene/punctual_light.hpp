#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/scene/area_light.hpp"
#include "core/scene/asset.hpp"
#include "core/scene/geometry.hpp"

namespace penumbra::scene_detail {

/// Which of an asset's lights without extent is the light: the most intense point or spot light
/// (candela), else the most intense directional one (lux, another unit); the first of equals.
std::optional<std::size_t> brightest(const std::vector<AssetLight>& lights);

/// The point light that stands for `light` below the node matrix `world`:
/// - point: where the node is, facing the centre of `bounds`;
/// - spot: where the node is, facing along the node's -Z; its cone is not simulated;
/// - directional: 100 radii of `bounds` from its centre against the node's -Z, so that shadow rays
///   differ by at most 0.6 degrees from parallel.
/// Nothing where the node has no finite place or no direction.
std::optional<AreaLight> placedPunctual(const AssetLight& light, const glm::dmat4& world,
                                        const Bounds& bounds);

/// What was chosen, in words; `count` lights were there to choose from.
std::string describe(const AssetLight& light, std::size_t count);

}  // namespace penumbra::scene_detail
