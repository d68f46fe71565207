#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string_view>

#include "core/scene/memory_budget.hpp"

namespace penumbra::scene_detail {

/// Parses the JSON of a glTF file and checks it against what glTF 2.0 says of types, so that
/// nobody after it meets an index that is a string, a matrix of 15 numbers or a missing required
/// member. Nesting and the number of values are bounded before any of it is built. Required
/// extensions that are not supported are refused by name. Throws InputError with JSON pointer.
nlohmann::json parseGltfJson(std::string_view text, const std::filesystem::path& file,
                             MemoryBudget& budget);

}  // namespace penumbra::scene_detail
