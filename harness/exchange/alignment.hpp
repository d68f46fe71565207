#pragma once

#include <optional>
#include <string>

#include "harness/exchange/outside_image.hpp"
#include "harness/reference/reference.hpp"

namespace penumbra {

/// How far, in pixels, an image is moved to find out whether it is displaced.
constexpr int kMostShift = 16;

/// An image that shows a frame from elsewhere (another camera, rows bottom first, half a pixel or
/// some pixels off) gets numbers that say nothing about its shadows. Both functions below name such
/// a displacement in words and are empty for an image that lies where it should.

/// Compares where the image has a surface with where the frame has one (or one that faces the
/// light, OutsideImage::coverageIsLit). Images that carry no coverage cannot be judged by it.
/// Allowed is a quarter of what a displacement by one pixel changes: an image that is half a pixel
/// off changes half of it, other rules for edges and other filters of alpha masks change single
/// pixels of the outline.
std::optional<std::string> coverageDisplacement(const OutsideImage& image, const GBuffer& gbuffer);

/// Compares visibility with the reference. Displaced is an image that fits several times better
/// elsewhere: see kFitsElsewhere in alignment.cpp for the bound and its reason.
std::optional<std::string> visibilityDisplacement(const OutsideImage& image, const GBuffer& gbuffer,
                                                  const Reference& reference);

}  // namespace penumbra
