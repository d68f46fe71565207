#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/scene/asset.hpp"

namespace penumbra::scene_detail {

/// An asset that is made instead of read: `procedural:landscape:TRIANGLES`.
///
/// A rolling ground of one connected mesh has half of the triangles, 100 tori of one mesh a
/// quarter, and pebbles, each a closed body of eight triangles, all the others. Whatever the count,
/// the same surfaces cover the same 20 m x 20 m about the origin, y up, between -1 m and 3 m: more
/// triangles are a finer ground, finer tori and more and smaller pebbles. No light, no camera.
struct ProceduralAsset {
    static constexpr std::size_t kFewestTriangles = 10'000;

    std::size_t triangles = 0;  ///< at most 7 more than there will be

    /// What a script's `asset` says; nothing where it does not start with "procedural:". Throws
    /// std::invalid_argument with what is wrong.
    static std::optional<ProceduralAsset> parsed(const std::string& text);
    /// Makes it, charging all of it to --max-memory. `file`: what errors name.
    Asset make(const std::filesystem::path& file, const LoadOptions& options) const;
};

}  // namespace penumbra::scene_detail
