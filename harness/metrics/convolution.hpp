#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace penumbra {

/// One-dimensional filters as passes of separable two-dimensional ones. Each writes `count`
/// outputs; `at(k)` is the run of `count` samples that lie k to the right of (or k rows below) the
/// outputs. `taps[k]` is the weight at distance k, on both sides.

/// out[i] = start(x[0]) + sum over k > 0 of taps[k] combine(x[-k], x[0], x[+k]), for all i. Taken
/// in blocks whose sums stay in registers: several times faster than one pass over `out` for each
/// tap.
template <class T, class Shifted, class Start, class Combine>
void filterRun(const std::vector<T>& taps, const Shifted& at, std::size_t count, T* out,
               const Start& start, const Combine& combine) {
    constexpr std::size_t kBlock = 16;
    const T* const centre = at(0);
    std::size_t first = 0;
    for (; first + kBlock <= count; first += kBlock) {
        std::array<T, kBlock> sum;
        for (std::size_t i = 0; i < kBlock; ++i) sum[i] = start(centre[first + i]);
        for (std::size_t k = 1; k < taps.size(); ++k) {
            const T* const left = at(-static_cast<int>(k)) + first;
            const T* const right = at(static_cast<int>(k)) + first;
            for (std::size_t i = 0; i < kBlock; ++i)
                sum[i] += taps[k] * combine(left[i], centre[first + i], right[i]);
        }
        std::copy(sum.begin(), sum.end(), out + first);
    }
    for (std::size_t i = first; i < count; ++i) {
        T sum = start(centre[i]);
        for (std::size_t k = 1; k < taps.size(); ++k) {
            const int shift = static_cast<int>(k);
            sum += taps[k] * combine(at(-shift)[i], centre[i], at(shift)[i]);
        }
        out[i] = sum;
    }
}

/// sum of taps[k] (x[+k] + x[-k]), taps[0] once.
template <class T, class Shifted>
void filterEven(const std::vector<T>& taps, const Shifted& at, std::size_t count, T* out) {
    filterRun(
        taps, at, count, out, [&](T centre) { return taps[0] * centre; },
        [](T left, T, T right) { return left + right; });
}

/// sum of taps[k] (x[+k] - x[-k]): exactly 0 where x is constant. taps[0] does not matter.
template <class T, class Shifted>
void filterOdd(const std::vector<T>& taps, const Shifted& at, std::size_t count, T* out) {
    filterRun(
        taps, at, count, out, [](T) { return T{0}; },
        [](T left, T, T right) { return right - left; });
}

/// sum of taps[k] (x[+k] + x[-k] - 2 x[0]): an even filter whose taps sum to zero, written so that
/// it is exactly 0 where x is constant. taps[0] does not matter.
template <class T, class Shifted>
void filterSecondDifference(const std::vector<T>& taps, const Shifted& at, std::size_t count,
                            T* out) {
    filterRun(
        taps, at, count, out, [](T) { return T{0}; },
        [](T left, T centre, T right) { return (left - centre) + (right - centre); });
}

}  // namespace penumbra
