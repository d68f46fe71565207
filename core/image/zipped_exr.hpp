#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/image/image_channels.hpp"

namespace penumbra {

/// readChannels() of an EXR of zipped lines of floats, as encodeExr() writes them, in a third of
/// the time: OpenEXRCore finds the blocks, libdeflate inflates them. Nothing of any other file, and
/// of one that cannot be read: OpenImageIO knows those, or why not.
std::optional<ImageChannels> readZippedChannels(const std::filesystem::path& path,
                                                const std::vector<std::string>& names);

}  // namespace penumbra
