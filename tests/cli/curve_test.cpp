// The accuracy-time curve by the real program, small.
#include <nlohmann/json.hpp>
#include <set>

#include "harness/run/settings.hpp"
#include "harness/study/pareto.hpp"
#include "tests/cli/in_process.hpp"
#include "tests/core/scene_files.hpp"
#include "tests/support/run_files.hpp"

namespace penumbra {
namespace {

TEST(Curve, ALadderDrawsItsCurvesAndReportDrawsThemAgain) {
    const testing::TempFolder folder;
    const std::filesystem::path run = folder.path() / "run";
    const test::Finished done =
        test::penumbra({"compare", "--out", run.string(), "--size", "48x48", "--repeats", "2",
                        "--reference-se", "0.05", "--cache", (folder.path() / "cache").string(),
                        "--scene", "half_plane", "contact", "--method", "hard", "pcf", "--ladder"});
    ASSERT_EQ(done.exitCode, 0) << done.err;

    // Every rung of every ladder, in each scene, by the name that it has anywhere else.
    SettingChoice ladders;
    ladders.methods = {"hard", "pcf"};
    ladders.ladder = true;
    std::set<std::string> asked;
    for (const Setting& setting : expandSettings(ladders)) asked.insert(setting.name);
    EXPECT_GE(asked.size(), 2u * 3u);
    const std::vector<Row> rows = readCsv(run / "results.csv");
    for (const char* scene : {"contact", "half_plane"}) {
        std::set<std::string> ran;
        for (const Row& row : rows)
            if (row.scene == scene) ran.insert(row.setting);
        EXPECT_EQ(ran, asked) << scene;
    }
    for (const Row& row : rows) EXPECT_GT(row.shadeFetchesPerPixel.value_or(0.0), 0.0) << row.key();
    const auto record = nlohmann::json::parse(test::readText(run / "run.json"));
    EXPECT_GT(record.at("fetch_throughput").at("nearest_per_s").get<double>(), 0.0);
    EXPECT_GT(record.at("fetch_throughput").at("compare_per_s").get<double>(), 0.0);

    EXPECT_EQ(test::readText(run / "pareto.csv"), paretoCsv(costStudies(rows, "rmse"), "rmse"));
    EXPECT_NE(test::readText(run / "summary.md").find("## What accuracy costs"), std::string::npos);
    const auto before = test::filesBelow(run);
    for (const char* name : {"contact", "half_plane", "suite"})
        for (const char* extension : {".svg", ".png"})
            EXPECT_TRUE(before.contains(std::string("curve/") + name + extension)) << name;

    std::filesystem::remove_all(run / "curve");
    std::filesystem::remove(run / "pareto.csv");
    ASSERT_EQ(test::penumbraInProcess({"report", run.string()}).exitCode, 0);
    EXPECT_TRUE(test::filesBelow(run) == before) << "not what compare wrote";

    ASSERT_EQ(test::penumbraInProcess({"report", run.string(), "--curve-metric", "flip"}).exitCode,
              0);
    EXPECT_EQ(test::readText(run / "pareto.csv"), paretoCsv(costStudies(rows, "flip"), "flip"));
    const test::Finished bad =
        test::penumbraInProcess({"report", run.string(), "--curve-metric", "speed"});
    EXPECT_EQ(bad.exitCode, 2);
    EXPECT_NE(bad.err.find("expected one of rmse, mae"), std::string::npos) << bad.err;
}

TEST(Curve, ASweepHasACurveAndSingleSettingsHaveNone) {
    const testing::TempFolder folder;
    const auto compare = [&](const std::string& name, std::vector<std::string> arguments) {
        const std::filesystem::path run = folder.path() / name;
        arguments.insert(arguments.begin(),
                         {"compare", "--out", run.string(), "--size", "32x32", "--repeats", "1",
                          "--reference-se", "0.05", "--cache", (folder.path() / "cache").string(),
                          "--scene", "half_plane", "--method", "hard", "pcf"});
        const test::Finished done = test::penumbraInProcess(arguments);
        EXPECT_EQ(done.exitCode, 0) << done.err;
        return run;
    };
    const auto swept = compare("swept", {"--sweep", "pcf.taps=9,25", "pcf.map_size=128,256"});
    EXPECT_EQ(readCsv(swept / "results.csv").size(), 1u + 2u * 2u);
    EXPECT_TRUE(std::filesystem::exists(swept / "curve/half_plane.svg"));
    EXPECT_FALSE(std::filesystem::exists(swept / "curve/suite.svg")) << "one scene is no suite";
    const auto plain = compare("plain", {});
    EXPECT_FALSE(std::filesystem::exists(plain / "curve"));
    EXPECT_FALSE(std::filesystem::exists(plain / "pareto.csv"));
    EXPECT_EQ(test::readText(plain / "summary.md").find("What accuracy costs"), std::string::npos);
}

TEST(Curve, AnUnknownMetricIsRefusedBeforeAnythingIsWritten) {
    const testing::TempFolder folder;
    const std::filesystem::path run = folder.path() / "run";
    const test::Finished done =
        test::penumbraInProcess({"compare", "--out", run.string(), "--scene", "half_plane",
                                 "--ladder", "--curve-metric", "frame_ms"});
    EXPECT_EQ(done.exitCode, 2);
    EXPECT_FALSE(std::filesystem::exists(run));
}

}  // namespace
}  // namespace penumbra
