#include "harness/study/effects_table.hpp"

#include "tests/support/compare_fixture.hpp"
#include "tests/support/fake_methods.hpp"

namespace penumbra {
namespace {

using test::CompareTest;

TEST(PlanVariants, AreAllAndEachSimulatedEffectLeftOut) {
    const auto variants =
        planVariants({Effect::penumbra, Effect::alpha_mask}, EffectSet{Effect::penumbra});
    ASSERT_EQ(variants.size(), 2u);
    EXPECT_EQ(variants[0].name, "all");
    EXPECT_TRUE(variants[0].choice.everyPixel);
    EXPECT_EQ(variants[1].name, "-penumbra");
    EXPECT_EQ(variants[1].choice.leftOut, EffectSet{Effect::penumbra});
}

TEST(EffectsTable, TotalsAndDifferencesAreOfFramesThatWereTimed) {
    const auto cell = [](const char* scene, int frame, const char* plan, double ms, double rmse,
                         double most) {
        return EffectsCell{scene, frame, "pcf", "pcf", plan, "ok", ms, ms, ms, rmse, most, 0.01};
    };
    std::vector<EffectsCell> cells = {
        cell("a", 0, "auto", 2, 0, 0),          cell("a", 0, "all", 8, 0, 0.001),
        cell("a", 0, "-penumbra", 1, 0.3, 0.9), cell("b", 0, "auto", 4, 0, 0),
        cell("b", 0, "all", 4, 0, 0.002),       cell("b", 0, "-penumbra", 2, 0.4, 1),
        cell("c", 0, "auto", 100, 0, 0),        cell("c", 0, "all", 1, 0, 0)};
    cells.back().status = "failed";
    cells.back().frameMs.reset();
    const std::string text = effectsTableMarkdown(cells);
    const auto has = [&](const char* line) { return text.find(line) != std::string::npos; };
    EXPECT_TRUE(has("| pcf | 2 | 12.0 | 6.00 | 0.500 | 0.00200 |\n")) << text;
    // (1 + 2) / (2 + 4), and the root of the mean of 0.3^2 and 0.4^2.
    EXPECT_TRUE(has("| pcf | penumbra | 2 | 0.500 | 0.354 | 1.00 |\n")) << text;
    EXPECT_TRUE(has("| 0 | pcf | auto without penumbra | ok | 1.00 | 0.500 | 0.300 | 0.900 |"))
        << text;
    EXPECT_TRUE(has("| 0 | pcf | all | failed |")) << text;

    const testing::TempFolder folder;
    writeEffectsCsv(folder.path() / "effects.csv", cells);
    EXPECT_EQ(readEffectsCsv(folder.path() / "effects.csv"), cells);
    folder.write("bad.csv", test::readText(folder.path() / "effects.csv") + "a,0,pcf\n");
    EXPECT_THROW(readEffectsCsv(folder.path() / "bad.csv"), InputError);
}

class EffectsTableRun : public CompareTest {};

TEST_F(EffectsTableRun, TimesEveryPlanAndComparesItsImage) {
    CompareOptions o = options("run", {"half_plane"}, {"pcf", "fake_refuses"});
    o.effectsTable = true;
    ASSERT_EQ(compare(o), 0);
    const RunFolder run(path("run"));
    const std::vector<EffectsCell> cells = readEffectsCsv(run.effectsCsv());
    std::vector<std::string> plans;
    for (const EffectsCell& cell : cells) {
        if (cell.setting != "pcf") continue;
        plans.push_back(cell.plan);
        EXPECT_TRUE(cell.frameMs) << cell.plan;
        EXPECT_TRUE(cell.rmse) << cell.plan;
    }
    ASSERT_EQ(plans, (std::vector<std::string>{"auto", "all", "-penumbra", "-self_shadow",
                                               "-thin_casters"}));
    EXPECT_EQ(cells[0].maxToAuto, 0.0);
    EXPECT_LE(*cells[1].maxToAuto, 1.0 / 255.0);
    EXPECT_GT(*cells[2].maxToAuto, 0.2) << "a hard shadow is no soft one";
    EXPECT_GT(*cells[2].rmse, *cells[0].rmse);
    // results.csv is as without the table.
    EXPECT_EQ(rows("run").size(), 2u);
    EXPECT_EQ(row("run", "pcf").metrics.rmse, cells[0].rmse);
    EXPECT_EQ(cells.back().status, "unsupported");
    EXPECT_EQ(test::readText(run.effectsTable()), effectsTableMarkdown(cells));
}

TEST_F(EffectsTableRun, IsARunOfItsOwn) {
    const auto refused = [&](const auto& change) {
        CompareOptions o = options("refused", {"half_plane"}, {"fake_constant"});
        o.effectsTable = true;
        change(o);
        return refusal(o);
    };
    EXPECT_NE(refused([](CompareOptions& o) {
                  o.effects = EffectChoice::parse("all");
              }).find("--effects-table"),
              std::string::npos);
    EXPECT_NE(refused([](CompareOptions& o) { o.resume = true; }).find("--effects-table"),
              std::string::npos);
    EXPECT_NE(refused([](CompareOptions& o) { o.shards = 2; }).find("--effects-table"),
              std::string::npos);
    EXPECT_FALSE(std::filesystem::exists(path("refused")));
}

}  // namespace
}  // namespace penumbra
