// export, score and diff as a user meets them: what they print, exit codes, and one line on stderr
// for whatever they refuse.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/image/image.hpp"
#include "harness/run/row.hpp"
#include "tests/cli/in_process.hpp"
#include "tests/core/scene_files.hpp"
#include "tests/support/run_files.hpp"

namespace penumbra {
namespace {

using Texts = std::vector<std::string>;

class Exchange : public ::testing::Test {
  protected:
    std::string path(const std::string& name) const { return (folder.path() / name).string(); }
    /// A picture of one value in every channel.
    std::string image(const std::string& name, int width, int height, Texts channels,
                      float value = 0.5f) const {
        Image out = Image::withChannels(width, height, std::move(channels));
        std::ranges::fill(out.pixels, value);
        writeExr(folder.path() / name, out);
        return path(name);
    }
    /// `penumbra COMMAND` with a rough reference of half_plane at 32 x 32.
    Texts onFrame(const std::string& command, const Texts& more) const {
        Texts all = {command,          "--scene", "half_plane", "--frame",    "0",
                     "--reference-se", "0.05",    "--cache",    path("cache")};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }
    void expectRefused(const Texts& arguments, const Texts& said) const {
        const auto before = test::filesBelow(folder.path());
        const test::Finished done = test::penumbraInProcess(arguments);
        const std::string command = fmt::format("{}", fmt::join(arguments, " "));
        EXPECT_EQ(done.exitCode, 2) << command << "\n" << done.err;
        EXPECT_EQ(done.out, "") << command;
        EXPECT_EQ(test::lines(done.err).size(), 1u) << command << "\n" << done.err;
        EXPECT_TRUE(done.err.starts_with("penumbra: ")) << command << "\n" << done.err;
        for (const std::string& part : said)
            EXPECT_NE(done.err.find(part), std::string::npos) << command << "\nsaid " << done.err;
        EXPECT_TRUE(test::filesBelow(folder.path()) == before) << command << " wrote something";
    }

    testing::TempFolder folder;
};

TEST_F(Exchange, ScorePrintsARowAsInResultsCsv) {
    const std::string v = image("v.exr", 32, 32, {"visibility"});
    const test::Finished csv = test::penumbra(onFrame("score", {"--image", v, "--name", "flat"}));
    EXPECT_EQ(csv.exitCode, 0) << csv.err;
    const Texts lines = test::lines(csv.out);
    ASSERT_EQ(lines.size(), 2u) << csv.out;
    EXPECT_EQ(lines[0], csvHeader());
    EXPECT_TRUE(lines[1].starts_with("half_plane,0,flat,flat,,32,32,ok,")) << lines[1];
    folder.write("rows.csv", csv.out);
    const Row row = readCsv(folder.path() / "rows.csv").at(0);

    const test::Finished json = test::penumbraInProcess(
        onFrame("score", {"--image", v, "--json", "--frame-ms", "2.5", "--size", "32x32"}));
    EXPECT_EQ(json.exitCode, 0) << json.err;
    const auto object = nlohmann::ordered_json::parse(json.out);
    Texts keys;
    for (const auto& [key, value] : object.items()) keys.push_back(key);
    EXPECT_EQ(fmt::format("{}", fmt::join(keys, ",")), csvHeader());
    EXPECT_EQ(object["setting"], "v");
    EXPECT_EQ(object["frame_ms"], 2.5);
    EXPECT_EQ(object["rmse"], row.metrics.rmse.value());
    EXPECT_EQ(object["scored_pixels"], row.metrics.scoredPixels);
    EXPECT_TRUE(object["flicker"].is_null());
}

TEST_F(Exchange, ExportPrintsItsFiles) {
    const test::Finished done =
        test::penumbra(onFrame("export", {"--size", "32x24", "--out", path("out")}));
    EXPECT_EQ(done.exitCode, 0) << done.err;
    const Texts files = test::lines(done.out);
    ASSERT_EQ(files.size(), 4u) << done.out;
    for (const std::string& file : files) EXPECT_TRUE(std::filesystem::exists(file)) << file;
    EXPECT_EQ(files[0], path("out/half_plane-0000.glb"));
    EXPECT_EQ(readImage(files[3]).height, 24);
}

TEST_F(Exchange, ScoreRefuses) {
    const std::string v = image("v.exr", 32, 32, {"visibility"});
    expectRefused(onFrame("score", {}), {"--image", "--shadowed", "--unshadowed"});
    expectRefused(onFrame("score", {"--shadowed", v}), {"--unshadowed"});
    expectRefused(onFrame("score", {"--image", v, "--shadowed", v, "--unshadowed", v}),
                  {"excludes"});
    expectRefused(onFrame("score", {"--image", v, "--size", "31x32"}),
                  {"the image is 32x32, the frame 31x32: 1 column too many"});
    expectRefused(onFrame("score", {"--image", v, "--size", ""}), {"--size"});
    expectRefused(onFrame("score", {"--image", v, "--frame-ms", "0"}), {"--frame-ms 0"});
    expectRefused(onFrame("score", {"--image", v, "--frame-ms", "nan"}), {"--frame-ms nan"});
    expectRefused(onFrame("score", {"--image", v, "--reference-se", "nan"}), {"--reference-se"});
    expectRefused(onFrame("score", {"--image", v, "--linear", "--srgb"}), {"excludes"});
    expectRefused(onFrame("score", {"--image", path("none.exr")}), {"none.exr: no such file"});
    expectRefused({"score", "--image", v}, {"--scene"});
    expectRefused({"score", "--scene", "nope", "--image", v}, {"'nope'", "half_plane"});
    expectRefused({"score", "--scene", "fence", "--frame", "3", "--image", v}, {"frames 0 to 2"});
    expectRefused(onFrame("score", {"--image", v, "--name", "hard", "--out", path("run")}),
                  {"--name hard: is a method's"});
}

TEST_F(Exchange, ExportRefuses) {
    expectRefused(onFrame("export", {}), {"--out"});
    expectRefused({"export", "--scene", "fence", "--frame", "3", "--out", path("out")},
                  {"frames 0 to 2"});
    expectRefused(
        {"export", "--scene", "foliage_masked", "--reference", "exact", "--out", path("out")},
        {"mask"});
}

TEST_F(Exchange, DiffRefuses) {
    const std::string small = image("small.exr", 3, 2, {"visibility"});
    const std::string other = image("other.exr", 4, 2, {"visibility"});
    const std::string colour = image("colour.exr", 3, 2, {"R", "G", "B"});
    const std::string two = image("two.exr", 3, 2, {"u", "v"});
    const std::string text = folder.write("text.exr", "no image").string();
    expectRefused({"diff", small, other}, {"3 x 2", "4 x 2", "sizes must agree"});
    expectRefused({"diff", small, colour}, {"one channel", "colour"});
    expectRefused({"diff", small, two}, {"2 channels (u, v)", "visibility"});
    expectRefused({"diff", text, small}, {text});
    expectRefused({"diff", small, path("none.exr")}, {"no such file"});
    expectRefused({"diff", small}, {"image"});
    expectRefused({"diff", small, small, "--out", path("none/map.png")}, {"none/map.png"});
    const test::Finished good = test::penumbraInProcess({"diff", small, small, "--json"});
    EXPECT_EQ(good.exitCode, 0) << good.err;
    EXPECT_EQ(nlohmann::json::parse(good.out)["rmse"], 0.0);
}

}  // namespace
}  // namespace penumbra
