#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "core/scene/material.hpp"
#include "core/scene/memory_budget.hpp"

namespace penumbra::scene_detail {

/// Decodes a PNG or JPEG to 8-bit RGBA. The size is checked and charged before anything is
/// allocated. Errors are InputError naming `file` and `pointer`.
TextureImage decodeImage(std::span<const unsigned char> encoded, const std::filesystem::path& file,
                         const std::string& pointer, MemoryBudget& budget);

}  // namespace penumbra::scene_detail
