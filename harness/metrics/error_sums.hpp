#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace penumbra {

/// Running sums over the errors of one class of pixels. Doubles: a float sum over a million pixels
/// loses the low errors behind the large ones.
struct ErrorSums {
    double sum = 0, sumAbs = 0, sumSquares = 0;
    std::size_t count = 0;

    void add(double error) {
        sum += error;
        sumAbs += std::abs(error);
        sumSquares += error * error;
        ++count;
    }
    std::optional<double> mean(double total) const {
        return count ? std::optional(total / static_cast<double>(count)) : std::nullopt;
    }
    std::optional<double> rms() const {
        return count ? std::optional(std::sqrt(sumSquares / static_cast<double>(count)))
                     : std::nullopt;
    }
};

/// Nearest rank: the ceil(0.99 n)-th smallest value. Reorders `values`, which must not be empty.
double percentile99(std::vector<double>& values);

/// Mean over the pixels whose `counted` is not 0; absent if there are none.
std::optional<double> meanWhere(std::span<const float> values,
                                std::span<const std::uint8_t> counted);

}  // namespace penumbra
