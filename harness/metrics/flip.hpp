#pragma once

#include <glm/glm.hpp>
#include <numbers>
#include <vector>

#include "core/image/image.hpp"

namespace penumbra {

/// LDR-FLIP (Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom, Fairchild 2020, "FLIP: A
/// Difference Evaluator for Alternating Images"): the difference an observer sees who flips between
/// two images on a display. Constants as in NVIDIA's implementation.

/// The default observer: 0.7 m from a 0.7 m wide display of 3840 pixels.
constexpr double kFlipPixelsPerDegree = 0.7 * 3840 / 0.7 * std::numbers::pi / 180;

/// One image as the observer sees it, made once for all comparisons with it.
struct FlipImage {
    int width = 0, height = 0;
    std::vector<glm::vec3> colour;  ///< CIELAB with Hunt adjustment, after the eye's blur
    std::vector<float> edges;       ///< magnitude of the first derivative of luminance
    std::vector<float> points;      ///< magnitude of the second derivative
};

/// `linearRgb` has three channels, finite; it is clamped to [0,1] as a display does. FLIP is
/// defined on sRGB-encoded images and begins by decoding them: linear input skips both. Borders
/// replicate.
FlipImage prepareFlip(const Image& linearRgb);

/// FLIP per pixel in [0,1], 0 for equal images. Symmetric.
std::vector<float> flipErrors(const FlipImage& a, const FlipImage& b);

/// colour^(1 - feature): what is seen of a colour difference in [0,1] where features differ by
/// `feature` in [0,1]. No colour difference is no difference, also at feature 1 (0^0).
float combineFlip(float colour, float feature);

}  // namespace penumbra
