#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace penumbra {

struct ImageChannels {
    int width = 0, height = 0;
    std::vector<std::vector<float>> values;  ///< of each channel width * height, top row first
};

/// The channels `names`, in this order, of what readImage() (core/image/image.hpp) reads; of an EXR
/// as writeExr() makes them in a third of its time. Throws InputError as it does, also if the image
/// lacks one of them.
ImageChannels readChannels(const std::filesystem::path& path,
                           const std::vector<std::string>& names);

}  // namespace penumbra
