#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "harness/report/grid.hpp"

namespace penumbra {

/// Images in a page, as its scripts decode them (page/planes.js): numbers, not pictures, so that a
/// reader can ask for the value at a pixel. A page at file:// may not read pixels of other files.
///
/// A plane is one 16-bit number per pixel: predicted from its neighbours by the median of LOCO-I
/// (Weinberger, Seroussi & Sapiro 2000, section III.A), the residuals folded to 0, -1, 1, -2, …,
/// all their low bytes before all their high bytes, deflated without a header, in base64.
std::string packedPlane(std::span<const std::uint16_t> values, int width);

/// So much of a unit of V is one step of a visibility plane: below the reference's standard error.
inline constexpr double kPlaneVisibility = 1e-3;
/// One step of a plane of standard errors.
inline constexpr double kPlaneStandardError = 1e-5;
/// What V = 0 is in a visibility plane; 0 says that V is not finite.
inline constexpr int kPlaneZero = 32768;

/// Every how many pixels, in both directions, the page's images are sampled so that
/// `pixels` of visibility in all keep the page below 30 MB.
int pageStride(double pixels);

/// The data elements of one frame, sampled every `stride` pixels from the first on. `sceneIndex`
/// and `rows` give their ids: `reference-S-F`, `standard-error-S-F`, `class-S-F` (the index in
/// {background, lit, penumbra, umbra, horizon, facing away}), `red-S-F`, `green-S-F` and
/// `blue-S-F` (sRGB of the frame without shadows), and `visibility-R` of the R-th row.
std::string pageImages(const GridFrame& frame, std::size_t sceneIndex, std::span<const Row> rows,
                       int stride);

}  // namespace penumbra
