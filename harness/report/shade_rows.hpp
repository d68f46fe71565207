#pragma once

#include <span>

#include "harness/report/shade.hpp"

namespace penumbra {

/// The pictures of shade.hpp some rows at a time, for those who need no whole image: rows
/// `beginRow` to `endRow` into `rgb`, three values a pixel.

/// Of shadeVisibility().
void shadeRows(const GBuffer& gbuffer, std::span<const float> visibility, const PictureLight& light,
               int beginRow, int endRow, std::span<float> rgb);
/// Of errorMap().
void errorRows(const GBuffer& gbuffer, std::span<const float> visibility,
               const Reference& reference, int beginRow, int endRow, std::span<float> rgb);

}  // namespace penumbra
