#include "harness/run/compare.hpp"

#include <cmath>

#include "tests/support/compare_fixture.hpp"
#include "tests/support/fake_methods.hpp"

namespace penumbra {
namespace {

using std::filesystem::exists;
using test::CompareTest;

TEST_F(CompareTest, WhatOneMethodDoesHarmsNoOther) {
    ASSERT_EQ(compare(options("alone", {"half_plane"}, {"hard", "pcf", "ray_traced"})), 0);
    ASSERT_EQ(compare(options("mixed", {"half_plane"},
                              {"fake_throws_in_build", "fake_throws_in_prepare", "fake_refuses",
                               "hard", "fake_gl_error", "pcf", "fake_fails_when_timed",
                               "fake_writes_nothing", "ray_traced"})),
              3);

    const RunFolder mixed(path("mixed"));
    const auto expectStatus = [&](const std::string& setting, const std::string& status,
                                  const std::string& message) {
        const Row r = row("mixed", setting);
        EXPECT_EQ(r.status, status) << setting;
        EXPECT_NE(r.message.find(message), std::string::npos) << setting << ": " << r.message;
        EXPECT_FALSE(r.frameMs) << setting;
        EXPECT_FALSE(r.metrics.rmse) << setting;
        EXPECT_FALSE(exists(mixed.setting("half_plane", 0, setting))) << setting;
    };
    expectStatus("fake_throws_in_build", "failed",
                 "the build broke\nin \"two\" lines, with a comma");
    expectStatus("fake_throws_in_prepare", "failed", "bad_alloc");
    expectStatus("fake_gl_error", "failed", "GL_INVALID_ENUM");
    expectStatus("fake_fails_when_timed", "failed", "only once");
    expectStatus("fake_refuses", "unsupported", "needs a light of another shape");

    // A pixel that nobody wrote is no visibility.
    const Row nothing = row("mixed", "fake_writes_nothing");
    EXPECT_EQ(nothing.status, "ok");
    EXPECT_EQ(nothing.metrics.nonfinite, 64u * 64u);

    std::vector<std::string> good;
    for (const std::string& line : test::untimedRows(path("mixed")))
        if (line.find(",fake_") == std::string::npos) good.push_back(line);
    EXPECT_EQ(good, test::untimedRows(path("alone")));
    for (const char* setting : {"hard", "pcf", "ray_traced"})
        EXPECT_TRUE(test::readText(mixed.setting("half_plane", 0, setting)) ==
                    test::readText(RunFolder(path("alone")).setting("half_plane", 0, setting)))
            << setting;

    EXPECT_TRUE(record("mixed").finished);
    EXPECT_TRUE(exists(mixed.grid("half_plane")));
    EXPECT_NE(test::readText(mixed.summary()).find("fake_gl_error"), std::string::npos);
}

TEST_F(CompareTest, UnsupportedIsNoFailure) {
    EXPECT_EQ(compare(options("run", {"half_plane"}, {"fake_refuses"})), 0);
    EXPECT_EQ(row("run", "fake_refuses").status, "unsupported");
}

TEST_F(CompareTest, AFrameInWhichNothingMovedKeepsTheMaps) {
    ASSERT_EQ(compare(options("run", {script("still")}, {"hard", "pcf", "fake_constant"})), 0);
    for (const char* setting : {"hard", "pcf", "fake_constant"}) {
        const Row first = row("run", setting, 0), second = row("run", setting, 1);
        EXPECT_EQ(first.maps, 1.0) << setting;
        ASSERT_TRUE(first.buildMs) << setting;
        EXPECT_EQ(second.maps, 0.0) << setting;
        EXPECT_FALSE(second.buildMs) << setting;
        EXPECT_EQ(second.frameMs, second.shadeMs) << setting;
        EXPECT_EQ(second.lightTexels, first.lightTexels) << setting << " still holds them";
        const RunFolder run(path("run"));
        EXPECT_EQ(run.readVisibility("still", 1, setting), run.readVisibility("still", 0, setting))
            << setting;
    }
    EXPECT_EQ(row("run", "hard", 0).drawCalls, 2.0);
    EXPECT_EQ(row("run", "hard", 1).drawCalls, 1.0) << "no depth pass";
}

std::string track(const std::string& target, const std::string& values) {
    return "\n[[track]]\ntarget = \"" + target + "\"\ntimes = [0.0, 1.0]\nvalues = " + values +
           "\n";
}

const std::string kGrowingLight = track("light.size", "[[1.6, 1.0], [0.8, 0.5]]");
const std::string kMovingCamera = track("camera.position", "[[-1.7, 2.6, 0.0], [-1.7, 1.3, 0.4]]");

TEST_F(CompareTest, WhatMovesIsBuiltAgain) {
    for (const std::string& moving :
         {script("light", kGrowingLight),
          script("away", track("light.position", "[[0.0, 4.0, 0.0], [0.1, 4.0, 0.0]]"))}) {
        const std::string run = std::filesystem::path(moving).stem().string() + "_run";
        ASSERT_EQ(compare(options(run, {moving}, {"hard"})), 0);
        EXPECT_EQ(row(run, "hard", 1).maps, 1.0) << moving;
        EXPECT_TRUE(row(run, "hard", 1).buildMs) << moving;
        EXPECT_NE(row(run, "hard", 1).effectsSimulated.find("moving_light"), std::string::npos);
    }
}

TEST_F(CompareTest, ATrackThatChangesNothingMovesNothing) {
    const std::string still = track("light.size", "[[1.6, 1.0], [1.6, 1.0]]");
    ASSERT_EQ(compare(options("run", {script("constant", still)}, {"hard"})), 0);
    EXPECT_EQ(row("run", "hard", 1).effectsSimulated.find("moving"), std::string::npos);
    EXPECT_FALSE(row("run", "hard", 1).buildMs);
}

TEST_F(CompareTest, AMovingCameraKeepsTheMaps) {
    CompareOptions o = options("auto", {script("camera", kMovingCamera)}, {"hard", "pcf"});
    ASSERT_EQ(compare(o), 0);
    o.out = path("all");
    o.effects = EffectChoice::parse("all");
    ASSERT_EQ(compare(o), 0);
    for (const char* setting : {"hard", "pcf"}) {
        EXPECT_TRUE(row("auto", setting, 0).buildMs) << setting;
        EXPECT_FALSE(row("auto", setting, 1).buildMs) << setting;
        EXPECT_EQ(row("auto", setting, 1).maps, 0.0) << setting;
        EXPECT_TRUE(row("all", setting, 1).buildMs) << setting << ": all rebuilds every frame";
        // The same maps, for the light's view is of the receivers of all frames.
        for (const int frame : {0, 1}) {
            const RunFolder a(path("auto")), b(path("all"));
            const GBuffer gbuffer = a.readGBuffer("camera", frame);
            const auto kept = a.readVisibility("camera", frame, setting),
                       built = b.readVisibility("camera", frame, setting);
            std::size_t off = 0;
            for (std::size_t i = 0; i < kept.size(); ++i)
                off += gbuffer.mask[i] == PixelClass::scored &&
                       !(std::abs(kept[i] - built[i]) <= 1.0f / 255.0f);
            EXPECT_EQ(off, 0u) << setting << " frame " << frame;
        }
    }
}

TEST_F(CompareTest, ALightThatThePlanHoldsStaysAsItWas) {
    CompareOptions o = options("held", {script("light", kGrowingLight)}, {"pcf", "ray_traced"});
    o.effects = EffectChoice::parse("penumbra,self_shadow,thin_casters");
    ASSERT_EQ(compare(o), 0);
    const RunFolder run(path("held"));
    for (const char* setting : {"pcf", "ray_traced"}) {
        EXPECT_FALSE(row("held", setting, 1).buildMs) << setting;
        EXPECT_EQ(run.readVisibility("light", 1, setting), run.readVisibility("light", 0, setting))
            << setting;
    }
    // The truth moves on.
    EXPECT_NE(run.readReference("light", 1).visibility, run.readReference("light", 0).visibility);
    EXPECT_GT(*row("held", "ray_traced", 1).metrics.rmse,
              2.0 * *row("held", "ray_traced", 0).metrics.rmse);
}

TEST_F(CompareTest, EffectsAreChosenAndNamed) {
    CompareOptions o = options("auto", {script("still")}, {"hard", "pcf"});
    ASSERT_EQ(compare(o), 0);
    // The half plane is one flat sheet in the air, which the camera sees as well.
    EXPECT_EQ(row("auto", "pcf").effectsSimulated, "penumbra self_shadow thin_casters");
    EXPECT_EQ(row("auto", "hard").effectsSimulated, "self_shadow thin_casters");
    EXPECT_EQ(row("auto", "hard").effectsSkipped,
              "layered_casters alpha_mask moving_light moving_casters moving_camera");
    EXPECT_EQ(row("auto", "hard").effectsMissing, "penumbra");
    EXPECT_EQ(row("auto", "pcf").effectsMissing, "");
    EXPECT_EQ(record("auto").effects, "auto");
    ASSERT_EQ(record("auto").analysis.size(), 2u);
    for (const EffectsRecord& found : record("auto").analysis) {
        EXPECT_EQ(found.scene, "still");
        EXPECT_EQ(found.findings.calledFor().text(), "penumbra self_shadow thin_casters");
        for (const EffectInfo& info : allEffects())
            EXPECT_FALSE(found.findings[info.effect].evidence.empty()) << info.id;
    }
    EXPECT_NE(test::readText(RunFolder(path("auto")).summary())
                  .find("| still | 0 to 1 | layered_casters | no | casters are convex or flat"),
              std::string::npos);

    const auto with = [&](const std::string& choice) {
        o.effects = EffectChoice::parse(choice);
        o.out = path(choice);
        EXPECT_EQ(compare(o), 0) << choice;
    };
    with("all");
    EXPECT_EQ(row("all", "pcf").effectsSimulated, EffectSet::all().text());
    EXPECT_EQ(row("all", "pcf").effectsSkipped, "");
    EXPECT_EQ(row("all", "hard").effectsMissing, "penumbra");
    EXPECT_EQ(record("all").effects, "all");
    with("none");
    EXPECT_EQ(row("none", "pcf").effectsSimulated, "");
    EXPECT_EQ(row("none", "pcf").effectsSkipped, EffectSet::all().text());
    EXPECT_EQ(row("none", "hard").effectsMissing, "");
    with("penumbra,alpha_mask");
    EXPECT_EQ(row("penumbra,alpha_mask", "pcf").effectsSimulated, "penumbra alpha_mask");
    EXPECT_EQ(row("penumbra,alpha_mask", "hard").effectsSimulated, "alpha_mask");
    EXPECT_EQ(row("penumbra,alpha_mask", "hard").effectsMissing, "penumbra");
    EXPECT_EQ(record("penumbra,alpha_mask").effects, "penumbra alpha_mask");
}

TEST_F(CompareTest, ScenesOfAbsentPackagesAreSkippedByName) {
    const std::string absent =
        folder
            .write("absent.toml",
                   "shows = \"nothing\"\nasset = \"package:/nonexistent/model.glb\"\n"
                   "package = \"some-package\"\n")
            .string();
    ASSERT_EQ(compare(options("run", {absent, "half_plane"}, {"fake_constant"})), 0);
    ASSERT_EQ(record("run").skippedScenes.size(), 1u);
    EXPECT_EQ(record("run").skippedScenes[0].first, absent);
    EXPECT_EQ(rows("run").size(), 1u);
    EXPECT_NE(test::readText(RunFolder(path("run")).summary()).find("some-package"),
              std::string::npos);

    EXPECT_NE(refusal(options("none", {absent}, {"fake_constant"})).find("some-package"),
              std::string::npos);
    EXPECT_FALSE(exists(path("none")));
}

TEST_F(CompareTest, ASceneNamedTwiceRunsOnceAndTwoOfOneNameAreRefused) {
    ASSERT_EQ(compare(options("run", {"half_plane", "half_plane"}, {"fake_constant"})), 0);
    EXPECT_EQ(rows("run").size(), 1u);
    const std::string message =
        refusal(options("two", {"half_plane", script("half_plane")}, {"fake_constant"}));
    EXPECT_TRUE(message.starts_with("two scenes are called 'half_plane': ")) << message;
    EXPECT_FALSE(exists(path("two")));
}

TEST_F(CompareTest, TheSummaryGoesToTheWorkflowToo) {
    const auto step = folder.write("step.md", "before\n");
    setenv("GITHUB_STEP_SUMMARY", step.c_str(), 1);
    ASSERT_EQ(compare(options("run", {"half_plane"}, {"fake_constant"})), 0);
    unsetenv("GITHUB_STEP_SUMMARY");
    EXPECT_EQ(test::readText(step), "before\n" + test::readText(RunFolder(path("run")).summary()));
}

}  // namespace
}  // namespace penumbra
