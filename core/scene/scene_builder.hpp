#pragma once

#include <memory>
#include <optional>

#include "core/scene/asset.hpp"
#include "core/scene/scene.hpp"
#include "core/scene/script.hpp"

namespace penumbra::scene_detail {

/// Puts an asset and, where there is one, its script together: chooses light and camera, evaluates
/// the tracks for every frame and checks the result.
std::shared_ptr<const Scene> buildScene(Asset asset, const std::optional<Script>& script,
                                        const LoadOptions& options = {});

}  // namespace penumbra::scene_detail
