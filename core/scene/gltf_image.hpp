#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "core/scene/material.hpp"
#include "core/scene/memory_budget.hpp"

namespace penumbra::scene_detail {

/// Decodes a PNG or JPEG, told apart by their content, to 8-bit RGBA. What the file says about
/// colour spaces is ignored (glTF 2.0 specification, section 3.8.2). Size, memory and work are
/// checked before anything of that size is allocated, and the decoders print nothing. Errors are
/// InputError naming `file` and `pointer`.
TextureImage decodeImage(std::span<const unsigned char> encoded, const std::filesystem::path& file,
                         const std::string& pointer, MemoryBudget& budget);

}  // namespace penumbra::scene_detail
