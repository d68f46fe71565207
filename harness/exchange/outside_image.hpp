#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/frame/gbuffer.hpp"
#include "harness/metrics/diff.hpp"

namespace penumbra {

/// Another renderer's visibility of one frame, as its files say it.
struct OutsideImage {
    std::string name;  ///< of its files, for messages
    int width = 0, height = 0;
    std::vector<float> visibility;  ///< row-major, top row first; NaN where the files give none
    /// 1 where the other renderer has a surface, or, from an unshadowed image, a lit one. Empty if
    /// the files do not say, or that it is so everywhere.
    std::vector<std::uint8_t> covered;
    bool coverageIsLit = false;      ///< `covered` comes from the unshadowed image
    std::vector<std::string> notes;  ///< what was assumed of the files
    /// Pixels without an unshadowed value to divide by (0, negative or not finite).
    std::vector<std::uint8_t> masked;
};

/// A visibility image: one channel, or colours whose channels agree. Throws InputError.
OutsideImage readVisibility(const std::filesystem::path& path, Transfer transfer);

/// Visibility as the ratio of the luminances of two pictures, with shadows and without. Nothing is
/// clamped. Throws InputError, also for pictures of different sizes.
OutsideImage readRatio(const std::filesystem::path& shadowed,
                       const std::filesystem::path& unshadowed, Transfer transfer);

/// Throws InputError, which says by how much, where the image is not of the frame's size.
void requireSize(const OutsideImage& image, int width, int height);

}  // namespace penumbra
