#include "harness/exchange/score.hpp"

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/image/image.hpp"
#include "harness/exchange/alignment.hpp"
#include "tests/support/compare_fixture.hpp"

namespace penumbra {
namespace {

using std::filesystem::exists;

/// Scores images against a run that made some.
class ScoreImage : public test::CompareTest {
  protected:
    /// Options that fit the runs of this fixture.
    ScoreOptions scoring(const std::filesystem::path& image,
                         const std::string& scene = "half_plane", int frame = 0) const {
        const CompareOptions like = options("run", {scene}, {});
        ScoreOptions o;
        o.scene = scene;
        o.frame = frame;
        o.image = image;
        o.truth = like;
        o.command = "a test";
        return o;
    }
    Row scored(const ScoreOptions& o) {
        notes.clear();
        return scoreImage(o, [&](const std::string& text) { notes += text + "\n"; });
    }
    std::string refusal(const ScoreOptions& o) {
        try {
            scored(o);
        } catch (const InputError& e) {
            return e.what();
        }
        return "";
    }
    void makeRun(std::vector<std::string> scenes, std::vector<std::string> methods) {
        ASSERT_EQ(compare(options("run", std::move(scenes), std::move(methods))), 0);
    }
    std::filesystem::path imageOf(const std::string& setting,
                                  const std::string& scene = "half_plane", int frame = 0) const {
        return RunFolder(path("run")).setting(scene, frame, setting);
    }
    std::filesystem::path write(const std::string& name, const Image& image) const {
        writeExr(folder.path() / name, image);
        return folder.path() / name;
    }

    std::string notes;
};

TEST_F(ScoreImage, ARunsOwnImagesGetExactlyTheirRowsMetrics) {
    makeRun({"half_plane"}, {"hard", "pcf", "ray_traced"});
    for (const char* setting : {"hard", "pcf", "ray_traced"}) {
        const Row given = row("run", setting), got = scored(scoring(imageOf(setting)));
        EXPECT_EQ(got.metrics, given.metrics) << setting;
        EXPECT_EQ(got.scene, "half_plane");
        EXPECT_EQ(got.method, setting);
        EXPECT_EQ(got.setting, setting);
        EXPECT_EQ(got.status, "ok");
        EXPECT_EQ(got.message, "");
        EXPECT_EQ(got.width, 64);
        EXPECT_FALSE(got.frameMs);
        EXPECT_EQ(got.renderer, "external");
    }
}

TEST_F(ScoreImage, NoMethodsImageIsTakenForDisplaced) {
    // Coarse maps and a large bias move shadow edges by several pixels, on one scene differently
    // from another: the criterion must stand all of them.
    CompareOptions o = options("run", {"fence", "contact", "antennas", "two_layers", "half_plane"},
                               {"hard", "pcf", "ray_traced"});
    o.settings.sweeps = {"hard.map_size=128,1024", "hard.bias=0.5,4"};
    o.repeats = 1;
    ASSERT_EQ(compare(o), 0);
    const RunFolder run(path("run"));
    int judged = 0;
    for (const Row& r : rows("run")) {
        OutsideImage image;
        image.name = r.params;
        image.width = r.width;
        image.height = r.height;
        image.visibility = run.readVisibility(r.scene, r.frame, r.setting);
        const GBuffer gbuffer = run.readGBuffer(r.scene, r.frame);
        EXPECT_EQ(coverageDisplacement(image, gbuffer), std::nullopt) << r.scene;
        EXPECT_EQ(visibilityDisplacement(image, gbuffer, run.readReference(r.scene, r.frame)),
                  std::nullopt)
            << r.scene << " frame " << r.frame;
        ++judged;
    }
    EXPECT_GE(judged, 50);
}

TEST_F(ScoreImage, RatioOfTwoPictures) {
    // Sixteen columns of a quarter, three pixels that cannot be divided by, one that is no number.
    Image unshadowed = Image::withChannels(64, 64, {"R", "G", "B"});
    for (std::size_t i = 0; i < unshadowed.pixels.size(); ++i)
        unshadowed.pixels[i] = 0.25f + 0.5f * static_cast<float>(i % 3);
    Image shadowed = unshadowed;
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 16; ++x)
            for (int c = 0; c < 3; ++c) shadowed.at(x, y, c) *= 0.25f;
    const float bad[] = {0.0f, -1.0f, std::numeric_limits<float>::infinity()};
    for (int k = 0; k < 3; ++k)
        for (int c = 0; c < 3; ++c) unshadowed.at(30 + k, 30, c) = bad[k];
    shadowed.at(40, 40, 1) = std::numeric_limits<float>::quiet_NaN();
    shadowed.at(50, 50, 1) *= 8.0f;  // above 1: not clamped
    ScoreOptions o = scoring("");
    o.shadowed = write("shadowed.exr", shadowed);
    o.unshadowed = write("unshadowed.exr", unshadowed);
    const Row r = scored(o);
    ASSERT_EQ(r.metrics.scoredPixels, 64u * 64u) << "half_plane fills its frame with scored pixels";
    EXPECT_EQ(r.metrics.nonfinite, 4u);
    EXPECT_EQ(r.metrics.outOfRange, 1u);
    EXPECT_EQ(r.message, "3 pixels masked: unshadowed value 0, negative or not finite");
    EXPECT_EQ(r.setting, "shadowed");

    // The same visibility as one image.
    Image v = Image::withChannels(64, 64, {"visibility"});
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) {
            const auto luma = [&](const Image& image) {
                return 0.2126F * image.at(x, y, 0) + 0.7152F * image.at(x, y, 1) +
                       0.0722F * image.at(x, y, 2);
            };
            const float below = luma(unshadowed);
            v.at(x, y, 0) = below > 0.0f && std::isfinite(below)
                                ? luma(shadowed) / below
                                : std::numeric_limits<float>::quiet_NaN();
        }
    EXPECT_EQ(scored(scoring(write("v.exr", v))).metrics, r.metrics);
}

TEST_F(ScoreImage, SizesMustAgreeAndSaidIsByHowMuch) {
    const auto narrow = write("narrow.exr", Image::withChannels(60, 67, {"visibility"}));
    ScoreOptions o = scoring(narrow);
    o.sizeGiven = true;
    EXPECT_EQ(refusal(o),
              fmt::format("{}: the image is 60x67, the frame 64x64: 4 columns too few, 3 "
                          "rows too many",
                          narrow.string()));
    o = scoring("");
    o.shadowed = narrow;
    o.unshadowed = write("one.exr", Image::withChannels(60, 68, {"visibility"}));
    EXPECT_NE(refusal(o).find("60x67, " + o.unshadowed.string() + " 60x68: 1 row too few"),
              std::string::npos)
        << refusal(o);
}

TEST_F(ScoreImage, ImagesWithoutVisibilityAreRefused) {
    Image colours = Image::withChannels(64, 64, {"R", "G", "B"});
    colours.at(3, 4, 1) = 0.5f;
    EXPECT_NE(refusal(scoring(write("c.exr", colours)))
                  .find("R, G and B differ in 1 of 4096 pixels, by up to 0.5"),
              std::string::npos);
    Image none = Image::withChannels(64, 64, {"visibility"});
    std::ranges::fill(none.pixels, std::numeric_limits<float>::quiet_NaN());
    EXPECT_NE(refusal(scoring(write("n.exr", none))).find("no pixel is finite"), std::string::npos);
    const Image clear = Image::withChannels(64, 64, {"Y", "A"});
    EXPECT_NE(refusal(scoring(write("a.exr", clear))).find("no pixel is covered"),
              std::string::npos);
    std::vector<std::string> names;
    for (int i = 0; i < 16; ++i) names.push_back("pass" + std::to_string(10 + i));
    const std::string many = refusal(scoring(write("m.exr", Image::withChannels(64, 64, names))));
    EXPECT_NE(many.find("16 channels (pass10, pass11"), std::string::npos) << many;
    names[3] = "visibility";
    EXPECT_EQ(refusal(scoring(write("o.exr", Image::withChannels(64, 64, names)))), "");
    EXPECT_EQ(refusal(scoring(imageOf("hard"), "half_plane", 1)),
              "--frame 1: scene 'half_plane' has only frame 0");
}

TEST_F(ScoreImage, IntegerFilesAreTakenAsEncodedAndSaidSo) {
    Image grey = Image::withChannels(64, 64, {"R", "G", "B"});
    std::ranges::fill(grey.pixels, 0.5f);
    const auto png = folder.path() / "v.png";
    writePng(png, grey);  // encodes
    const Row decoded = scored(scoring(png));
    EXPECT_NE(notes.find("v.png: its numbers are read as sRGB-encoded"), std::string::npos)
        << notes;
    const Row floats = scored(scoring(write("v.exr", grey)));
    EXPECT_EQ(notes, "");
    // 0.5 is encoded as 188 of 255, which decodes to 0.5029.
    EXPECT_NEAR(decoded.metrics.bias.value(), floats.metrics.bias.value() + 0.0029, 1e-4);
    ScoreOptions o = scoring(png);
    o.transfer = Transfer::linear;
    EXPECT_NEAR(scored(o).metrics.bias.value(), floats.metrics.bias.value() + 188.0 / 255 - 0.5,
                1e-6);
}

// ---- into a run --------------------------------------------------------------------------------

TEST_F(ScoreImage, StandsBesideTheMethodsOfARun) {
    const std::string still = script("still");
    makeRun({still}, {"hard"});
    const auto before = test::untimedRows(path("run"));
    ScoreOptions o = scoring(imageOf("hard", "still", 0), still, 0);
    o.name = "mine";
    o.run = path("run");
    o.frameMs = 2.5;
    scored(o);
    o.image = imageOf("hard", "still", 1);
    o.frame = 1;
    scored(o);

    for (const int frame : {0, 1}) {
        Row mine = row("run", "mine", frame);
        EXPECT_EQ(mine.metrics, row("run", "hard", frame).metrics) << "flicker of frame 1 as well";
        EXPECT_EQ(mine.frameMs, 2.5);
    }
    EXPECT_TRUE(row("run", "mine", 1).metrics.flicker);
    std::vector<std::string> methods;
    for (const std::string& line : test::untimedRows(path("run")))
        if (line.find(",mine,") == std::string::npos) methods.push_back(line);
    EXPECT_EQ(methods, before);
    const RunFolder run(path("run"));
    EXPECT_EQ(run.readVisibility("still", 1, "mine"), run.readVisibility("still", 1, "hard"));
    EXPECT_NE(test::readText(run.summary()).find("mine"), std::string::npos);
    EXPECT_EQ(record("run").settings.size(), 2u);

    // Scored again, the row is replaced.
    o.frameMs = 1.5;
    scored(o);
    EXPECT_EQ(rows("run").size(), 4u);
    EXPECT_EQ(row("run", "mine", 1).frameMs, 1.5);
    EXPECT_EQ(row("run", "mine", 1).metrics, row("run", "hard", 1).metrics);
}

TEST_F(ScoreImage, ANewRunHoldsTheImageAlone) {
    makeRun({"half_plane"}, {"ray_traced"});
    ScoreOptions o = scoring(imageOf("ray_traced"));
    o.name = "mine";
    o.run = path("new");
    scored(o);
    EXPECT_EQ(row("new", "mine").metrics, row("run", "ray_traced").metrics);
    EXPECT_TRUE(record("new").finished);
    EXPECT_EQ(record("new").references.size(), 1u);
    const RunFolder run(path("new"));
    EXPECT_TRUE(exists(run.grid("half_plane")));
    EXPECT_TRUE(exists(run.summary()));
    EXPECT_TRUE(exists(run.images("half_plane", 0) / "gbuffer.exr"));
    // Methods can join it.
    CompareOptions more = options("new", {"half_plane"}, {"hard"});
    more.resume = true;
    EXPECT_EQ(compare(more), 0);
    EXPECT_EQ(rows("new").size(), 2u);
}

TEST_F(ScoreImage, WhatCouldNotStandBesideTheRunIsRefusedAndNothingWritten) {
    makeRun({"half_plane"}, {"hard"});
    const auto before = test::filesBelow(path("run"));
    const auto refused = [&](const std::string& name, auto change) {
        ScoreOptions o = scoring(imageOf("hard"));
        o.name = name;
        o.run = path("run");
        change(o);
        const std::string message = refusal(o);
        EXPECT_TRUE(test::filesBelow(path("run")) == before) << message;
        return message;
    };
    const auto has = [](const std::string& text, const std::string& part) {
        EXPECT_NE(text.find(part), std::string::npos) << text;
    };
    has(refused("mine", [](ScoreOptions& o) { o.truth.seed = 7; }),
        "the run there has --size 64x64 --seed 0 --reference embree --reference-se 0.05; the image "
        "is scored with --size 64x64 --seed 7");
    has(refused("mine", [](ScoreOptions& o) { o.truth.referenceSe = 0.1; }), "--reference-se 0.1");
    has(refused("mine", [](ScoreOptions& o) { o.truth.reference = "exact"; }), "--reference exact");
    const auto small = write("small.exr", Image::withChannels(32, 32, {"visibility"}));
    has(refused("mine", [&](ScoreOptions& o) { o.image = small; }), "scored with --size 32x32");
    has(refused("mine", [&](ScoreOptions& o) { o.scene = script("half_plane"); }),
        "its scene 'half_plane' is ");
    has(refused("", [](ScoreOptions&) {}), "--name hard: is a method's");
    for (const std::string name : {"reference", "gbuffer", ".hidden", "a/b", "a b"})
        has(refused(name, [](ScoreOptions&) {}), "--name '" + name + "'");
}

}  // namespace
}  // namespace penumbra
