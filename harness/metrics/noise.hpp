#pragma once

#include <optional>
#include <span>

#include "core/frame/gbuffer.hpp"
#include "harness/reference/reference.hpp"

namespace penumbra {

/// Half the width of noise()'s window, in pixels.
constexpr int kNoiseRadius = 2;

/// High-frequency energy of the error inside penumbrae: the root mean square, over scored penumbra
/// pixels, of error minus its mean over the 5 x 5 window around the pixel. Error is visibility -
/// reference; the window's mean is over its scored pixels, the centre among them; non-finite pixels
/// are in neither. Pixels with nobody else in their window are left out, since alone they would
/// always count as noiseless. Absent if no pixel is left.
///
/// White noise of standard deviation s gives s sqrt(24/25). Sees grain, dither and banding up to
/// about five pixels wide, and the steps of shadow-map texels; blind to smooth error of any size
/// and to blotches wider than the window. The reference's own noise is part of it.
std::optional<double> noise(std::span<const float> visibility, const Reference& reference,
                            const GBuffer& gbuffer, std::span<const LightClass> classes);

}  // namespace penumbra
