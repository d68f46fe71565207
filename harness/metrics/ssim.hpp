#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace penumbra {

/// Pixels cut off at each border: half the 11 x 11 window.
constexpr int kSsimRadius = 5;

/// What SSIM needs of one image alone, made once for all comparisons with it.
struct SsimImage {
    int width = 0, height = 0;
    std::vector<float> values;  ///< row-major
    /// E[x] and E[x^2] under the window, for the (width - 10) x (height - 10) pixels that have one.
    std::vector<double> mean, meanOfSquares;
};

/// `values` are finite, width * height of them.
SsimImage prepareSsim(int width, int height, std::vector<float> values);

/// Structural similarity (Wang, Bovik, Sheikh, Simoncelli 2004): Gaussian window 11 x 11,
/// sigma 1.5, L = 1, C1 = 0.01^2, C2 = 0.03^2, variances from E[x^2] - E[x]^2 in double. Mean over
/// the windows whose centre pixel is `counted` (not 0; one entry per pixel); 1 for equal images,
/// may be below 0. Absent where no counted pixel is at least 5 pixels away from every border.
/// Symmetric.
std::optional<double> ssim(const SsimImage& a, const SsimImage& b,
                           std::span<const std::uint8_t> counted);

}  // namespace penumbra
