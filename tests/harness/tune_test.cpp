// The search on a made-up world of exact costs and errors, and the command on the real one.
#include "harness/study/tune.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/sampling/sampling.hpp"
#include "harness/study/parameter_space.hpp"
#include "tests/core/scene_files.hpp"
#include "tests/support/gl_fixture.hpp"
#include "tests/support/run_files.hpp"

namespace penumbra {
namespace {

double valueOf(const Setting& setting, const std::string& id) {
    const auto method = setting.make();
    const auto& all = method->parameters();
    return (*std::ranges::find(all, id, &Parameter::id))->number();
}

/// pcf in a world where time is 1 + taps/50 + (map_size/1024)^2 ms at full size and the error falls
/// with taps and map size, but is half of that with the Vogel pattern, which no rung of the ladder
/// has. `noise` multiplies times by up to 1 +- noise.
class World {
  public:
    explicit World(double noise = 0.0, std::uint32_t seed = 0) : noise_(noise), seed_(seed) {}
    std::vector<Row> operator()(bool full, const std::vector<Setting>& settings, int repeats) {
        std::vector<Row> rows;
        for (const Setting& s : settings) {
            Row row;
            row.method = s.method;
            row.setting = s.name;
            row.params = s.params;
            row.width = row.height = full ? 128 : 64;
            const double taps = valueOf(s, "taps"), map = valueOf(s, "map_size") / 1024.0;
            const double jitter =
                1.0 + noise_ * (2.0 * toUnitFloat(hash(seed_, calls_++)) - 1.0) / repeats;
            row.buildMs = map * map * jitter;
            row.shadeMs = (1.0 + taps / 50.0) * jitter * (full ? 1.0 : 0.25);
            row.frameMs = *row.buildMs + *row.shadeMs;
            row.frameMsLow = *row.frameMs * (1.0 - noise_);
            row.frameMsHigh = *row.frameMs * (1.0 + noise_);
            row.metrics.rmse = (0.2 / std::sqrt(taps) + 0.01 / map) *
                               (valueOf(s, "pattern") > 0.0 ? 0.5 : 1.0) * (full ? 1.0 : 1.1);
            rows.push_back(row);
        }
        return rows;
    }

  private:
    double noise_;
    std::uint32_t seed_, calls_ = 0;
};

TuneResult search(const TuneGoal& goal, World world, std::uint32_t seed = 0) {
    return searchSettings({"pcf"}, goal, 4.0, seed, true,
                          [&](bool full, const std::vector<Setting>& settings, int repeats) {
                              return world(full, settings, repeats);
                          });
}

TEST(TuneSearch, FindsWhatNoRungHasUnderALimitOfError) {
    for (const std::uint32_t seed : {0u, 1u, 2u}) {
        const TuneResult r = search({0.03, {}}, World(), seed);
        ASSERT_TRUE(r.best);
        EXPECT_LE(*r.best->metrics.rmse, 0.03);
        ASSERT_TRUE(r.ladderBest);
        EXPECT_TRUE(r.atLeastAsGood);
        // The least time there is 2 ms (Vogel, taps 22, map 0.55); the best rung takes 4.
        EXPECT_LT(*r.best->frameMs, 0.75 * *r.ladderBest->frameMs) << seed;
    }
}

TEST(TuneSearch, FindsWhatNoRungHasUnderALimitOfTime) {
    for (const std::uint32_t seed : {0u, 1u, 2u}) {
        const TuneResult r = search({{}, 3.0}, World(), seed);
        ASSERT_TRUE(r.best);
        EXPECT_LE(*r.best->frameMs, 3.0);
        ASSERT_TRUE(r.ladderBest);
        EXPECT_LT(*r.best->metrics.rmse, 0.75 * *r.ladderBest->metrics.rmse) << seed;
    }
}

TEST(TuneSearch, WithNoiseItIsStillNoWorseThanTheLadder) {
    for (const std::uint32_t seed : {0u, 1u, 2u, 3u}) {
        EXPECT_TRUE(search({0.03, {}}, World(0.3, seed), seed).atLeastAsGood) << seed;
        const TuneResult r = search({{}, 3.0}, World(0.3, seed), seed);
        ASSERT_TRUE(r.best) << seed;
        EXPECT_LE(*r.best->frameMs, 3.0) << "the measurement binds";
    }
}

/// A search in which the machine is so busy that `factor` times of what a setting takes is measured
/// in the first `batches` final measurements.
TuneResult searchDisturbed(double maxMs, int batches, double factor, std::uint32_t seed) {
    World world;
    return searchSettings({"pcf"}, {{}, maxMs}, 4.0, seed, false,
                          [&](bool full, const std::vector<Setting>& settings, int repeats) {
                              std::vector<Row> rows = world(full, settings, repeats);
                              if (!full || repeats != 9 || batches-- <= 0) return rows;
                              for (Row& row : rows)
                                  for (auto* ms : {&row.frameMs, &row.frameMsLow, &row.frameMsHigh})
                                      **ms *= factor;
                              return rows;
                          });
}

TEST(TuneSearch, WhereAllFinalistsAreDisturbedThoseThatLeaveMoreRoomFollow) {
    constexpr double kMaxMs = 6.0;
    for (const std::uint32_t seed : {0u, 1u, 2u}) {
        // Ten times what the fastest takes, 1 ms at least, is too much for each finalist.
        const TuneResult once = searchDisturbed(kMaxMs, 1, 10.0, seed),
                         twice = searchDisturbed(kMaxMs, 2, 10.0, seed);
        ASSERT_TRUE(once.best) << seed;
        ASSERT_TRUE(twice.best) << seed;
        // The world's small image estimates the full one exactly.
        EXPECT_LE(*once.best->frameMs, 0.7 * kMaxMs) << seed;
        EXPECT_LE(*twice.best->frameMs, 0.4 * kMaxMs) << seed;
        EXPECT_GT(*once.best->frameMs, 0.4 * kMaxMs) << seed << ": gives up no more than it must";
        EXPECT_LE(*once.best->metrics.rmse, *twice.best->metrics.rmse) << seed;
    }
}

TEST(TuneSearch, AMachineThatStaysBusyLeavesTheNearest) {
    const TuneResult r = searchDisturbed(6.0, 99, 10.0, 0);
    EXPECT_FALSE(r.best);
    ASSERT_TRUE(r.nearest);
    EXPECT_EQ(r.nearest->width, 128) << "of the full image";
}

TEST(TuneSearch, TheSameSeedAndTimesGiveTheSameTrials) {
    const auto names = [](const TuneResult& r) {
        std::vector<std::string> all;
        for (const TuneTrial& t : r.trials) all.push_back(t.phase + " " + t.row.setting);
        return all;
    };
    const TuneResult a = search({0.03, {}}, World(0.3, 5), 7),
                     b = search({0.03, {}}, World(0.3, 5), 7);
    EXPECT_EQ(names(a), names(b));
    EXPECT_EQ(a.best->setting, b.best->setting);
    EXPECT_NE(names(a), names(search({0.03, {}}, World(0.3, 5), 8))) << "the seed draws";
}

TEST(TuneSearch, AnImpossibleLimitNamesTheNearest) {
    const TuneResult error = search({1e-6, {}}, World());
    EXPECT_FALSE(error.best);
    ASSERT_TRUE(error.nearest);
    EXPECT_EQ(error.nearest->width, 128) << "of the full image";
    for (const TuneTrial& t : error.trials) {
        if (t.row.width == 128) {
            EXPECT_LE(*error.nearest->metrics.rmse, *t.row.metrics.rmse);
        }
    }
    const TuneResult time = search({{}, 0.5}, World());
    EXPECT_FALSE(time.best);
    EXPECT_TRUE(time.nearest);
}

TEST(ParameterSpace, NeighboursAreValidNearAndDrawnBySeed) {
    for (const MethodInfo& info : methodRegistry()) {
        if (info.make()->parameters().empty()) continue;  // as those that tests register
        const std::vector<Setting> seeds = seedSettings(info.id);
        ASSERT_FALSE(seeds.empty());
        int moved = 0;
        for (std::uint32_t seed = 0; seed < 60; ++seed) {
            const Setting from = seeds[seed % seeds.size()];
            const Setting next = neighbour(from, seed);  // throws where a value is out of range
            EXPECT_EQ(next.name, neighbour(from, seed).name) << info.id;
            moved += next.name != from.name;
            int changed = 0;
            const auto a = from.make(), b = next.make();
            for (std::size_t i = 0; i < a->parameters().size(); ++i)
                changed += a->parameters()[i]->text() != b->parameters()[i]->text();
            EXPECT_LE(changed, 2) << info.id;
        }
        EXPECT_GT(moved, 20) << info.id << ": a search that stands still finds nothing";
    }
}

// What pcf's ladder spans of taps is 9 to 289, of map sizes 512 to 2048.
TEST(ParameterSpace, NumbersStayNearWhatTheLadderSpans) {
    Setting at = settingOf("pcf", {});
    for (std::uint32_t seed = 0; seed < 300; ++seed) {
        at = neighbour(at, seed);
        EXPECT_GE(valueOf(at, "taps"), 4.0);
        EXPECT_LE(valueOf(at, "taps"), 578.0);
        EXPECT_GE(valueOf(at, "map_size"), 256.0);
        EXPECT_LE(valueOf(at, "map_size"), 4096.0);
    }
}

TEST(Tune, ARepeatedSearchReadsTheSameTimes) {
    test::endGlContext();  // tune() makes its own
    const testing::TempFolder folder;
    TuneOptions o;
    o.scene = "half_plane";
    o.methods = {"pcf"};
    o.maxRmse = 0.15;
    o.width = o.height = 64;
    o.referenceSe = 0.05;
    o.cache = folder.path() / "cache";
    o.out = folder.path() / "first";
    ASSERT_EQ(tune(o), 0);
    o.out = folder.path() / "second";
    ASSERT_EQ(tune(o), 0);
    const std::string table = test::readText(folder.path() / "first" / "tune.csv");
    EXPECT_EQ(table, test::readText(folder.path() / "second" / "tune.csv"));
    EXPECT_NE(table.find(",final,"), std::string::npos);
    EXPECT_THROW(tune(o), InputError) << "the folder is in use";

    o.maxRmse = 1e-9;
    o.out = folder.path() / "third";
    EXPECT_EQ(tune(o), 1);
    EXPECT_TRUE(std::filesystem::exists(o.out / "tune.csv"));
}

}  // namespace
}  // namespace penumbra
