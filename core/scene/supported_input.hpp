#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace penumbra {

/// One thing that an input file may hold or demand: the loader decides by this table and
/// `penumbra list inputs` prints it.
struct SupportedInput {
    enum class Kind {
        read,     ///< an extension whose content is read
        ignored,  ///< an extension that changes nothing a shadow depends on
        refused,  ///< an extension that is refused where an asset requires it
        limit     ///< a bound; beyond it the file is refused
    };
    const char* id;
    Kind kind;
    const char* doc;

    /// "read", "ignored", "refused" or "limit".
    std::string_view kindName() const;
};

std::span<const SupportedInput> supportedInputs();

/// The entry of a glTF extension, null for one that is not in the table.
const SupportedInput* findExtension(std::string_view name);

namespace scene_detail {

// The limits that do not depend on --max-memory; the table's texts state them.
inline constexpr int kMaxJsonDepth = 100;               ///< tinygltf recurses through `extras`
inline constexpr std::uint64_t kMaxIndex = 2147483647;  ///< tinygltf counts in int
inline constexpr std::size_t kMaxTriangles = 100'000'000;
/// Of one image; beyond it no GL implementation takes a texture anyway.
inline constexpr long long kMaxImageTexels = 16384LL * 16384LL;
inline constexpr double kMaxExtentM = 1e15;  ///< squares of it still fit in a float

}  // namespace scene_detail

}  // namespace penumbra
