#pragma once

#include <cstdint>
#include <string>

namespace penumbra {

/// What an asset may make the loader allocate unless `--max-memory` says otherwise.
inline constexpr std::uint64_t kDefaultMaxMemoryBytes = std::uint64_t{4} << 30;

/// How a scene's asset is read. Names and indices that the asset does not have are an InputError
/// that lists those it has.
struct LoadOptions {
    /// The glTF scene, by index into `scenes` or by name; empty: the asset's default.
    std::string assetScene;
    /// The asset's camera, by its place in the node hierarchy, depth first, or by the name of its
    /// node or lens; it then wins over a script's. Empty: the script's, else the asset's first.
    std::string camera;
    /// Bound on all that reading the asset and placing it in frames may allocate; see
    /// scene_detail::MemoryBudget.
    std::uint64_t maxMemoryBytes = kDefaultMaxMemoryBytes;
};

}  // namespace penumbra
