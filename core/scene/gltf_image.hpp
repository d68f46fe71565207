#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "core/scene/material.hpp"

namespace penumbra::scene_detail {

/// Greatest number of texels of one image; beyond it no GL implementation takes a texture anyway.
inline constexpr long long kMaxImageTexels = 16384LL * 16384LL;

/// Decodes a PNG or JPEG to 8-bit RGBA. The size is checked before anything is allocated. Errors
/// are InputError naming `file` and `pointer`.
TextureImage decodeImage(std::span<const unsigned char> encoded, const std::filesystem::path& file,
                         const std::string& pointer);

}  // namespace penumbra::scene_detail
