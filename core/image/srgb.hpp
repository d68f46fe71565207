#pragma once

#include <cstdint>
#include <span>

namespace penumbra {

/// srgb8() of core/image/image.hpp of each value; both are equally long.
void srgb8(std::span<const float> linear, std::span<std::uint8_t> bytes);
/// The linear value that a byte stands for: srgb8() gives the byte back.
float linearOf(std::uint8_t srgb);

}  // namespace penumbra
