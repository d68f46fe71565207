#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/scene/memory_budget.hpp"

namespace penumbra::scene_detail {

/// The bytes of a regular file; charged to `budget` before they are read. Throws InputError for
/// `file` at `pointer` with `name` for what cannot be read.
std::vector<unsigned char> readBytes(const std::filesystem::path& path, const std::string& name,
                                     const std::filesystem::path& file, const std::string& pointer,
                                     MemoryBudget& budget);

/// What `uri` of the asset `file` holds: a base64 data URI, or a file in the asset's folder or
/// below. Percent escapes are decoded first, symbolic links are followed before it is checked where
/// the file lies. Absolute paths, "..", schemes (file:, http:), and links that lead out of the
/// folder are refused. Throws InputError for `file` at `pointer`.
std::vector<unsigned char> readUri(const std::string& uri, const std::filesystem::path& file,
                                   const std::string& pointer, MemoryBudget& budget);

}  // namespace penumbra::scene_detail
