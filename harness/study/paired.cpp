#include "harness/study/paired.hpp"

#include <utility>

namespace penumbra {

PairedVerdict verdictOf(const MedianInterval& speedup) {
    return speedup.low > 1.0    ? PairedVerdict::faster
           : speedup.high < 1.0 ? PairedVerdict::slower
                                : PairedVerdict::indistinguishable;
}

PairedTiming judgePairs(const std::vector<PairSample>& pairs) {
    std::vector<double> ratios;
    for (const PairSample& pair : pairs) ratios.push_back(pair.bMs / pair.aMs);
    const MedianInterval speedup = signTestInterval(std::move(ratios));
    return {speedup, pairs.size(), verdictOf(speedup)};
}

PairedResult measurePaired(const Frame& frame, CellOptions options, const Setting& a,
                           const Setting& b, const TextureTarget& target) {
    PairedResult result;
    SettingRun runA(a), runB(b);
    std::size_t timed = 0;
    options.sampled = [&](std::size_t run, const SettingRun::Sample& sample) {
        const bool isA = run == 0;
        if (timed++ % 2 == 0) result.pairs.push_back({isA, 0.0, 0.0});
        PairSample& pair = result.pairs.back();
        (isA ? pair.aMs : pair.bMs) = sample.buildMs + sample.shadeMs;
    };
    runCells(frame, options, {&runA, &runB}, target,
             [&](std::size_t run, Row&& row, const std::vector<float>& visibility) {
                 const bool isA = run == 0;
                 (isA ? result.a : result.b) = std::move(row);
                 (isA ? result.visibilityA : result.visibilityB) = visibility;
             });
    if (!result.ok()) result.pairs.clear();
    return result;
}

}  // namespace penumbra
