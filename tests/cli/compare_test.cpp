// The main job by the real program, small.
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "core/image/image.hpp"
#include "tests/core/scene_files.hpp"
#include "tests/support/run_files.hpp"

namespace penumbra {
namespace {

using Texts = std::vector<std::string>;
using nlohmann::json;

class Compare : public ::testing::Test {
  protected:
    std::filesystem::path path(const std::string& name) const { return folder.path() / name; }

    /// `penumbra compare` at 64x64 with a rough reference, into `run`.
    Texts command(const std::string& run, const Texts& arguments) const {
        Texts all = {"compare",   "--out", path(run).string(), "--size", "64x64",
                     "--repeats", "2",     "--reference-se",   "0.05"};
        if (std::ranges::find(arguments, "--cache") == arguments.end())
            all.insert(all.end(), {"--cache", path("cache").string()});
        all.insert(all.end(), arguments.begin(), arguments.end());
        return all;
    }
    test::Finished compare(const std::string& run, const Texts& arguments) const {
        test::Finished done = test::penumbra(command(run, arguments));
        EXPECT_EQ(done.exitCode, 0) << done.err;
        const Texts lines = test::lines(done.out);
        EXPECT_EQ(lines.empty() ? "" : lines.back(), path(run).string());
        return done;
    }
    static std::set<std::string> channels(const std::filesystem::path& exr) {
        const Image image = readImage(exr);
        EXPECT_EQ(image.width, 64) << exr;
        EXPECT_EQ(image.height, 64) << exr;
        return {image.channels.begin(), image.channels.end()};
    }

    testing::TempFolder folder;
};

TEST_F(Compare, WritesTheRunFolder) {
    compare("run", {"--scene", "half_plane", "--method", "hard", "pcf"});

    const json record = json::parse(test::readText(path("run/run.json")));
    EXPECT_EQ(record.at("finished"), true);
    EXPECT_EQ(record.at("width"), 64);
    EXPECT_EQ(record.at("scenes").at(0).at("id"), "half_plane");
    EXPECT_EQ(record.at("settings").size(), 2u);
    EXPECT_NE(record.at("command").get<std::string>().find("penumbra compare --out "),
              std::string::npos);
    for (const char* field : {"renderer", "gl_version", "context", "cpu", "threads", "build",
                              "compiler", "version", "commit", "started"})
        EXPECT_FALSE(record.at("provenance").at(field).get<std::string>().empty()) << field;

    const std::string csv = test::readText(path("run/results.csv"));
    EXPECT_TRUE(csv.starts_with(
        "scene,frame,method,setting,params,width,height,status,message,frame_ms,frame_ms_low,"
        "frame_ms_high,frame_ms_mad,repeats,unstable,build_ms,shade_ms,prepare_ms,draw_calls,"
        "triangles,fragments,maps,light_texels,texture_mib,rmse,mae,bias,p99,max_error,ssim,flip,"
        "rmse_lit,rmse_penumbra,rmse_umbra,leak_rate,false_shadow_rate,noise,flicker,"
        "scored_pixels,horizon_pixels,nonfinite,out_of_range,reference_se,effects_simulated,"
        "effects_skipped,effects_missing,renderer,threads,commit"))
        << csv;
    const std::vector<Row> rows = readCsv(path("run/results.csv"));
    ASSERT_EQ(rows.size(), 2u);
    EXPECT_EQ(rows[0].setting, "hard");
    EXPECT_EQ(rows[1].setting, "pcf");
    for (const Row& row : rows) {
        EXPECT_EQ(row.status, "ok");
        EXPECT_EQ(row.repeats, 2);
        EXPECT_GT(row.frameMs.value_or(0.0), 0.0);
        EXPECT_LE(row.frameMsLow, row.frameMs);
        EXPECT_GE(row.frameMsHigh, row.frameMs);
        EXPECT_GT(row.metrics.rmse.value_or(0.0), 0.0);
        EXPECT_EQ(row.metrics.scoredPixels, 64u * 64u);
        EXPECT_EQ(row.renderer, record.at("provenance").at("renderer"));
    }

    const std::string summary = test::readText(path("run/summary.md"));
    EXPECT_NE(summary.find("half_plane"), std::string::npos);
    EXPECT_NE(summary.find("pcf"), std::string::npos);
    const Image grid = readImage(path("run/grid/half_plane.png"));
    EXPECT_GE(grid.width, 3 * 64) << "the reference and two methods side by side";

    const std::filesystem::path images = path("run/images/half_plane/0000");
    const std::set<std::string> gbuffer = channels(images / "gbuffer.exr");
    for (const char* name : {"P.X", "P.Y", "P.Z", "N.X", "N.Y", "N.Z", "mask"})
        EXPECT_TRUE(gbuffer.contains(name)) << name;
    EXPECT_EQ(channels(images / "reference.exr"),
              (std::set<std::string>{"visibility", "standard_error", "rays", "irradiance",
                                     "irradiance_unshadowed"}));
    for (const char* setting : {"hard.exr", "pcf.exr"})
        EXPECT_EQ(channels(images / setting), (std::set<std::string>{"visibility", "error"}));
    const auto v = readImage(images / "pcf.exr").channel("visibility");
    const auto error = readImage(images / "pcf.exr").channel("error");
    const auto truth = readImage(images / "reference.exr").channel("visibility");
    for (std::size_t i = 0; i < v.size(); ++i) ASSERT_EQ(error[i], v[i] - truth[i]) << i;
}

TEST_F(Compare, TheSameCommandGivesTheSameImagesOnAnyNumberOfThreads) {
    // Separate caches: the references are traced each time.
    const auto run = [&](const std::string& name, const std::string& threads) {
        compare(name, {"--scene", "foliage_masked", "two_layers", "--set", "ray_traced.rays=4",
                       "--method", "hard", "pcf", "ray_traced", "--threads", threads, "--cache",
                       path("cache_" + name).string()});
    };
    run("first", "2");
    run("second", "2");
    run("single", "1");
    EXPECT_EQ(test::untimedRows(path("first")).size(), 4u * 3u);
    EXPECT_EQ(test::untimedRows(path("first")), test::untimedRows(path("second")));
    test::expectSameFiles(path("first/images"), path("second/images"));
    test::expectSameFiles(path("first/images"), path("single/images"));
}

TEST_F(Compare, ABareAssetGetsWhatItLacks) {
    const auto bare = folder.write("bare.glb", testing::triangleFile().glb());
    const test::Finished done = compare("run", {"--scene", bare.string(), "--method", "hard"});
    for (const char* chosen : {"bare: light:", "bare: camera:", "bare: ground"})
        EXPECT_NE(done.err.find(chosen), std::string::npos) << chosen << " not in\n" << done.err;
    const json record = json::parse(test::readText(path("run/run.json")));
    EXPECT_EQ(record.at("scenes").at(0).at("id"), "bare");
    EXPECT_GE(record.at("scenes").at(0).at("chosen").size(), 3u);
    EXPECT_GT(readCsv(path("run/results.csv")).at(0).metrics.scoredPixels, 0u);
}

TEST_F(Compare, ARealModelByItsPath) {
    const char* engine =
        "/usr/share/assimp/models/glTF2/2CylinderEngine-glTF-Binary/2CylinderEngine.glb";
    if (!std::filesystem::exists(engine)) GTEST_SKIP() << "needs Debian's assimp-testmodels";
    compare("run", {"--scene", engine});
    for (const Row& row : readCsv(path("run/results.csv"))) {
        EXPECT_EQ(row.scene, "2CylinderEngine");
        EXPECT_EQ(row.status, "ok") << row.setting << ": " << row.message;
        EXPECT_EQ(row.metrics.nonfinite, 0u) << row.setting;
        EXPECT_GT(row.metrics.scoredPixels, 500u) << row.setting;
    }
}

TEST_F(Compare, ACacheThatCannotBeWrittenStopsNothing) {
    const auto file = folder.write("file", "in the way");
    const test::Finished done = compare(
        "run", {"--scene", "half_plane", "--method", "hard", "--cache", (file / "in").string()});
    EXPECT_NE(done.err.find("not cached"), std::string::npos) << done.err;
}

TEST_F(Compare, ReportAndMergeRebuildTheArtefacts) {
    compare("a", {"--scene", "half_plane", "--method", "hard", "pcf", "--shard", "1/2"});
    compare("b", {"--scene", "half_plane", "--method", "hard", "pcf", "--shard", "2/2"});
    const test::Finished merged =
        test::penumbra({"merge", path("both").string(), path("a").string(), path("b").string()});
    EXPECT_EQ(merged.exitCode, 0) << merged.err;
    EXPECT_EQ(readCsv(path("both/results.csv")).size(), 2u);

    const auto before = test::filesBelow(path("both"));
    std::filesystem::remove_all(path("both/grid"));
    std::filesystem::remove(path("both/summary.md"));
    EXPECT_EQ(test::penumbra({"report", path("both").string()}).exitCode, 0);
    EXPECT_TRUE(test::filesBelow(path("both")) == before);
}

TEST_F(Compare, ARunThatIsKilledIsFinishedByResume) {
    const Texts scenes = {"--scene", "half_plane", "layers",   "contact", "butterfly",
                          "spinner", "fence",      "--method", "hard",    "pcf"};
    test::Program running(test::penumbraCommand(command("run", scenes)));
    // As soon as the first rows are there, with nine frames still to come.
    const auto giveUp = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (test::lines(test::readText(path("run/results.csv"))).size() < 3 &&
           std::chrono::steady_clock::now() < giveUp)
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    running.kill();
    EXPECT_EQ(running.wait().exitCode, -SIGKILL) << "it had ended by itself";

    const std::vector<Row> left = readCsv(path("run/results.csv"));
    EXPECT_GE(left.size(), 2u);
    EXPECT_EQ(json::parse(test::readText(path("run/run.json"))).at("finished"), false);

    Texts again = scenes;
    again.push_back("--resume");
    compare("run", again);
    EXPECT_EQ(json::parse(test::readText(path("run/run.json"))).at("finished"), true);
    const std::vector<Row> rows = readCsv(path("run/results.csv"));
    EXPECT_EQ(rows.size(), 2u * (4u + 2u * 3u));
    std::set<std::string> keys;
    for (const Row& row : rows) {
        EXPECT_EQ(row.status, "ok") << row.key() << ": " << row.message;
        keys.insert(row.key());
        EXPECT_TRUE(std::filesystem::exists(path("run/images") / row.scene / "0000" /
                                            (row.setting + ".exr")))
            << row.key();
    }
    EXPECT_EQ(keys.size(), rows.size());
    for (const Row& row : left) {
        const auto kept = std::ranges::find(rows, row.key(), &Row::key);
        ASSERT_NE(kept, rows.end()) << row.key();
        EXPECT_EQ(kept->frameMs, row.frameMs) << row.key() << " was done again";
    }
    for (const auto& [name, bytes] : test::filesBelow(path("run")))
        EXPECT_EQ(name.find(".tmp"), std::string::npos) << name;
}

}  // namespace
}  // namespace penumbra
