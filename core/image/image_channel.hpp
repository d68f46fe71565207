#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace penumbra {

struct ImageChannel {
    int width = 0, height = 0;
    std::vector<float> values;  ///< width * height, top row first
};

/// One channel of what readImage() (core/image/image.hpp) reads, in less time than all of them.
/// Throws InputError as it does, also if the image has no channel `name`.
ImageChannel readChannel(const std::filesystem::path& path, const std::string& name);

}  // namespace penumbra
