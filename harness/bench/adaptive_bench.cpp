// Adaptive light sampling against regular, by the protocol of Schwaerzler 2009, section 5: frames
// of 1024 x 768, maps of 512 x 512, 2 x 2 comparisons; epsilon is set so that as many maps result
// as in the paper's figures. `paper` is its own algorithm (fig. 1: texture array, eqs 4, 6 and 7;
// fig. 7: linear light, accumulation buffer, eqs 3 and 4, equal weights), `ours` the method's
// defaults. Counters: `maps` reached at `epsilon`; `speed`, the regular frame's time over the
// adaptive one's, medians of turns taken in one sitting; `rmse` and `rmse_regular` against the
// traced reference in every fourth pixel of a row and column; `compare`, the share of the adaptive
// frame that is neither its maps (as `light_sampled` renders as many) nor evaluation; `work` is
// `speed` by processor time.
//
// equal_rmse/<scene> of the standard suite, 512 x 512: `speed` is the processor time of as many
// regular samples (`regular`, interpolated on their own curve) as have the rmse of the method's
// defaults over that of the defaults, both with 2 x 2 comparisons; `_fine` the same of epsilon
// 0.08. `penumbra`: pixels that see some of the light and not all.

#include "harness/bench/adaptive_stage.hpp"
#include "harness/run/suite.hpp"

namespace penumbra::bench {
namespace {

constexpr int kSuitePixels = 512;

void adaptiveAgainstRegular(benchmark::State& state, const Case& c, bool paper) {
    needContext();
    const Stage stage(c.scene, kWidth, kHeight, c.linear ? makeLinear : nullptr);
    const auto [adaptive, regular] = settingsOf(c, paper);
    const double epsilon = c.maps > c.regularMaps ? 0.0 : epsilonFor(stage, adaptive, c.maps);
    Player sparse(stage, "adaptive_light_sampled",
                  with(adaptive, "epsilon", std::to_string(epsilon)));
    Player all(stage, "light_sampled", with(regular, "samples", std::to_string(c.regularMaps)));
    sparse.play();
    Player mapsOnly(stage, "light_sampled",
                    {{"pattern", "owen"}, {"samples", std::to_string(sparse.maps())}});
    for (auto _ : state) {
        sparse.play();
        all.play();
        mapsOnly.play();
    }
    const Sparse truth(stage);
    const double frameMs = median(sparse.frameMs);
    state.counters["maps"] = sparse.maps();
    state.counters["epsilon"] = epsilon;
    state.counters["speed"] = median(all.frameMs) / frameMs;
    state.counters["work"] = all.workMs / sparse.workMs;
    state.counters["rmse"] = truth.rmse(sparse.image());
    state.counters["rmse_regular"] = truth.rmse(all.image());
    state.counters["compare"] = (median(sparse.buildMs) - median(mapsOnly.buildMs)) / frameMs;
}

/// What a setting of the regular method costs and buys.
struct Price {
    double samples, rmse, workMs, buildWorkMs;
};

/// Where `at` lies between `low` and `high`, 0 to 1, by logarithms.
double between(double low, double high, double at) {
    return std::log(at / low) / std::log(high / low);
}

double mix(double low, double high, double t) {
    return low * std::pow(high / low, t);
}

/// Of the regular method at `rmse`, between its settings (cheapest first): the cheapest's where
/// that is as good, and the last pair's slope goes on beyond the dearest.
Price priceAt(const std::vector<Price>& regular, double rmse) {
    std::size_t i = 0;
    while (i < regular.size() && regular[i].rmse > rmse) ++i;
    if (i == 0) return regular[0];
    i = std::min(i, regular.size() - 1);
    const Price &before = regular[i - 1], &after = regular[i];
    const double t = between(before.rmse, after.rmse, rmse);
    return {mix(before.samples, after.samples, t), rmse, mix(before.workMs, after.workMs, t),
            mix(before.buildWorkMs, after.buildWorkMs, t)};
}

/// Work of rendering `maps` maps and no more.
double mapsWorkMs(const std::vector<Price>& regular, double maps) {
    std::size_t i = 1;
    while (i + 1 < regular.size() && regular[i].samples < maps) ++i;
    const Price &before = regular[i - 1], &after = regular[i];
    return mix(before.buildWorkMs, after.buildWorkMs, between(before.samples, after.samples, maps));
}

/// Regular sampling against adaptive at equal rmse: same map size, 2 x 2 comparisons on both sides.
void equalRmse(benchmark::State& state, const std::string& scene) {
    needContext();
    const Stage stage(scene, kSuitePixels);
    const Sparse truth(stage);
    std::vector<Player> regular, adaptive;
    const std::vector<int> counts = {1, 4, 9, 16, 25, 49, 100};
    for (const int count : counts)
        regular.emplace_back(stage, "light_sampled",
                             Assignments{{"samples", std::to_string(count)}, {"pcf", "true"}});
    const std::vector<std::pair<std::string, Assignments>> rungs = {
        {"", {{"pcf", "2x2"}}},
        {"_fine", {{"pcf", "2x2"}, {"epsilon", "0.08"}, {"rim_depth", "3"}}}};
    for (const auto& [name, settings] : rungs)
        adaptive.emplace_back(stage, "adaptive_light_sampled", settings);
    const auto playAll = [&] {
        for (Player& player : regular) player.play();
        for (Player& player : adaptive) player.play();
    };
    playAll();
    for (auto _ : state) playAll();
    std::vector<Price> curve;
    for (std::size_t i = 0; i < regular.size(); ++i)
        curve.push_back({static_cast<double>(counts[i]), truth.rmse(regular[i].image()),
                         regular[i].workMs, regular[i].buildWorkMs});
    for (std::size_t i = 0; i < adaptive.size(); ++i) {
        const Player& player = adaptive[i];
        const double rmse = truth.rmse(player.image());
        const Price same = priceAt(curve, rmse);
        const std::string& rung = rungs[i].first;
        state.counters["maps" + rung] = player.maps();
        state.counters["rmse" + rung] = rmse;
        state.counters["regular" + rung] = same.samples;
        state.counters["speed" + rung] = same.workMs / player.workMs;
        state.counters["compare" + rung] =
            (player.buildWorkMs - mapsWorkMs(curve, player.maps())) / player.workMs;
    }
    state.counters["penumbra"] = truth.penumbra();
}

const auto registered = [] {
    for (const Case& c : paperCases())
        for (const bool paper : {true, false})
            benchmark::RegisterBenchmark(
                ("adaptive_light_sampled/" + c.name + (paper ? "/paper" : "/ours")).c_str(),
                adaptiveAgainstRegular, c, paper)
                ->Iterations(3)
                ->Unit(benchmark::kMillisecond);
    for (const std::string& scene : loadSuite("standard", SceneLibrary::standard()).scenes)
        benchmark::RegisterBenchmark(("adaptive_light_sampled/equal_rmse/" + scene).c_str(),
                                     equalRmse, scene)
            ->Iterations(2)
            ->Unit(benchmark::kMillisecond);
    return 0;
}();

}  // namespace
}  // namespace penumbra::bench
