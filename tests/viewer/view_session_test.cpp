#include "core/error.hpp"
#include "harness/run/cells.hpp"
#include "harness/run/staged_frame.hpp"
#include "tests/support/fake_methods.hpp"
#include "tests/viewer/viewer_fixture.hpp"

namespace penumbra {
namespace {

using test::converge;
using test::settle;

class ViewSessionTest : public test::ViewerTest {};

/// What the batch runner makes of the scene's frame 0.
std::vector<float> batchImage(const std::string& scene, const std::string& method, int size) {
    const StagedFrame staged(loadScene(scene, SceneLibrary::standard()), 0, size, size, 0);
    SettingChoice choice;
    choice.methods = {method};
    const std::vector<Setting> settings = expandSettings(choice);
    SettingRun run(settings.front());
    std::vector<float> image;
    const TextureTarget target(size, size);
    runCells(staged.frame, {.effects = {}, .calledFor = staged.analysis.calledFor(), .repeats = 1},
             {&run}, target,
             [&](std::size_t, Row&&, const std::vector<float>& seen) { image = seen; });
    return image;
}

TEST_F(ViewSessionTest, ShowsTheImagesThatTheBatchRunnerMakes) {
    ViewSession session(options("half_plane", {"pcss", "ray_traced"}));
    settle(session);
    EXPECT_EQ(session.method(0)->visibility(), batchImage("half_plane", "pcss", 64));
    EXPECT_EQ(session.method(1)->visibility(), batchImage("half_plane", "ray_traced", 64));
    ASSERT_TRUE(session.method(0)->work());
    EXPECT_GT(*session.method(0)->work()->drawCalls, 0.0);
    EXPECT_EQ(*session.method(0)->work()->maps, 1.0);
}

TEST_F(ViewSessionTest, OnlyWhatChangedIsRenderedAgain) {
    ViewSession session(options("half_plane", {"pcf", "hard"}));
    settle(session);
    const auto first = session.method(0)->imageVersion(),
               second = session.method(1)->imageVersion();
    settle(session);
    EXPECT_EQ(session.method(0)->imageVersion(), first);
    session.method(0)->setParameter("map_size", "256");
    settle(session);
    EXPECT_GT(session.method(0)->imageVersion(), first);
    EXPECT_EQ(session.method(1)->imageVersion(), second);
    const Geometry* const before = &session.frame().gpuGeometry.geometry();
    Camera camera = session.camera();
    camera.position += 0.1 * camera.right;
    session.setCamera(camera);
    settle(session);
    EXPECT_GT(session.method(1)->imageVersion(), second);
    EXPECT_EQ(&session.frame().gpuGeometry.geometry(), before) << "nothing of it moved";
}

TEST_F(ViewSessionTest, MapsAreKeptWhileTheLightSeesTheSame) {
    ViewSession session(options("half_plane", {"pcf"}));
    settle(session);
    session.update(/*measure=*/true);
    EXPECT_TRUE(session.method(0)->keptMaps());
    EXPECT_EQ(session.method(0)->times().back().buildMs, 0.0);
    AreaLight light = session.light();
    light.halfU *= 0.5;
    session.setLight(light);
    session.update();
    EXPECT_FALSE(session.method(0)->keptMaps());
}

TEST_F(ViewSessionTest, AMethodThatThrowsIsFailedAndTheOtherGoesOn) {
    ViewSession session(options("half_plane", {"fake_throws_in_build", "pcf"}));
    settle(session);
    EXPECT_EQ(session.method(0)->status(), "failed");
    EXPECT_NE(session.method(0)->message().find("the build broke"), std::string::npos);
    EXPECT_TRUE(session.method(0)->visibility().empty());
    EXPECT_EQ(session.method(1)->status(), "ok");
    EXPECT_EQ(session.method(1)->visibility(), batchImage("half_plane", "pcf", 64));
    session.setMethod(0, "fake_refuses");
    settle(session);
    EXPECT_EQ(session.method(0)->status(), "unsupported");
    session.setMethod(0, "fake_gl_error");
    settle(session);
    EXPECT_EQ(session.method(0)->status(), "failed");
    session.setMethod(0, "hard");
    settle(session);
    EXPECT_EQ(session.method(0)->status(), "ok");
}

TEST_F(ViewSessionTest, ABrokenAssetKeepsTheOldScene) {
    ViewSession session(options("half_plane", {"hard"}));
    settle(session);
    const auto image = session.method(0)->visibility();
    const auto broken = folder.write("broken.glb", "glTF, but not for long");
    try {
        session.open(broken.string());
        FAIL() << "opened";
    } catch (const InputError& e) {
        EXPECT_NE(std::string(e.what()).find("broken.glb"), std::string::npos);
        EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
    }
    settle(session);
    EXPECT_EQ(session.scene().id, "half_plane");
    EXPECT_EQ(session.sceneName(), "half_plane");
    EXPECT_EQ(session.method(0)->visibility(), image);
    session.open("two_layers");
    settle(session);
    EXPECT_EQ(session.scene().id, "two_layers");
    EXPECT_NE(session.method(0)->visibility(), image);
}

TEST_F(ViewSessionTest, TheReferenceConvergesAndScoresTheImages) {
    ViewSession session(options("half_plane", {"ray_traced", "fake_constant"}));
    converge(session);
    ASSERT_TRUE(session.reference()->standardError);
    // The target is per pixel, so that the rms is below it.
    EXPECT_LE(*session.reference()->standardError, 0.05);
    ASSERT_TRUE(session.score(0) && session.score(1));
    EXPECT_LT(session.score(0)->rmse, session.score(1)->rmse);
    EXPECT_LE(session.score(0)->rmseCorrected, session.score(0)->rmse);
    // A moved light drops it at once.
    AreaLight light = session.light();
    light.centre.x += 0.3;
    session.setLight(light);
    session.update();
    EXPECT_FALSE(session.reference() && session.reference()->converged);
}

TEST_F(ViewSessionTest, ItsReferenceIsTheOneThatCompareScoresAgainst) {
    ViewOptions o = options("half_plane", {"hard"});
    ViewSession session(o);
    converge(session);
    const StagedFrame staged(loadScene("half_plane", SceneLibrary::standard()), 0, 64, 64, 0);
    o.cache = folder.path() / "another";
    const ObtainedReference batch =
        obtainReference(*staged.traced.scene, 0, *staged.traced.tracer, staged.traced.gbuffer,
                        staged.traced.frame.light, o);
    EXPECT_TRUE(std::filesystem::exists(folder.path() / "cache")) << "compare can use it";
    // Further passes may have been averaged in by now: by standard errors, not by equality.
    const Reference& seen = session.reference()->reference;
    for (std::size_t i = 0; i < seen.visibility.size(); ++i)
        ASSERT_NEAR(seen.visibility[i], batch.reference.visibility[i],
                    1e-6 + 6.0 * batch.reference.standardError[i])  // far beyond chance in 4096
            << i;
}

TEST_F(ViewSessionTest, TheMeanOfIndependentReferencesHasTheErrorOfAMean) {
    const auto one = [](std::vector<float> v, std::vector<float> se, float rays) {
        Reference r;
        r.width = static_cast<int>(v.size());
        r.height = 1;
        r.irradiance = v;
        r.visibility = std::move(v);
        r.standardError = std::move(se);
        r.rays.assign(r.visibility.size(), rays);
        return r;
    };
    // Mixed; constant in both; constant but not the same.
    const Reference mean = meanOf({one({0.4f, 1.0f, 0.0f}, {0.03f, 0.01f, 0.01f}, 300.0f),
                                   one({0.6f, 1.0f, 1.0f}, {0.04f, 0.01f, 0.01f}, 300.0f)});
    EXPECT_FLOAT_EQ(mean.visibility[0], 0.5f);
    EXPECT_FLOAT_EQ(mean.standardError[0], 0.025f);  // sqrt(0.03^2 + 0.04^2) / 2
    EXPECT_FLOAT_EQ(mean.standardError[1], 3.0f / 600.0f);
    EXPECT_FLOAT_EQ(mean.visibility[2], 0.5f);
    EXPECT_FLOAT_EQ(mean.rays[1], 600.0f);
}

TEST_F(ViewSessionTest, EffectsAreSwitchedByHand) {
    ViewSession session(options("half_plane", {"pcss"}));
    settle(session);
    EXPECT_TRUE(session.method(0)->plan().has(Effect::penumbra));
    const auto soft = session.method(0)->visibility();
    session.switchEffect(Effect::penumbra, false);
    settle(session);
    EXPECT_FALSE(session.method(0)->plan().has(Effect::penumbra));
    EXPECT_NE(session.method(0)->visibility(), soft);
    session.switchEffect(Effect::penumbra, true);
    settle(session);
    EXPECT_EQ(session.method(0)->visibility(), soft);
    session.setEffects("all");
    EXPECT_THROW(session.setEffects("nope"), InputError);
    EXPECT_EQ(session.effects(), "all");
}

TEST_F(ViewSessionTest, APastedLineChangesWhatItSaysAndABadOneNothing) {
    ViewSession session(options("half_plane", {"pcss:blocker_taps=25"}));
    EXPECT_EQ(session.take(parseCommandLine("penumbra view --set pcss.filter_taps=9")), "");
    EXPECT_EQ(spelled(session.method(0)->setting()), "pcss:blocker_taps=25;filter_taps=9");
    EXPECT_EQ(session.scene().id, "half_plane");
    EXPECT_THROW(session.take(parseCommandLine("penumbra view --scene two_layers --method nope")),
                 InputError);
    EXPECT_THROW(session.take(parseCommandLine("penumbra view --method pcf --scene nope")),
                 InputError);
    EXPECT_EQ(session.scene().id, "half_plane");
    EXPECT_EQ(session.method(0)->setting().method, "pcss");
    EXPECT_EQ(session.take(parseCommandLine(
                  "penumbra compare --scene fence --method pcf vsm --size 32x48 --ladder")),
              "not used: --ladder");
    EXPECT_EQ(session.scene().id, "fence");
    EXPECT_EQ(session.method(1)->setting().method, "vsm");
    settle(session);
    EXPECT_EQ(session.method(1)->visibility().size(), 32u * 48u);
}

TEST_F(ViewSessionTest, EveryParameterCanBeSetToItsExtremes) {
    ViewSession session(options("half_plane", {"pcss"}));
    LiveMethod& method = *session.method(0);
    for (const Parameter* p : method.parameters())
        for (const std::string& value : p->extremes()) method.setParameter(p->id(), value);
    EXPECT_THROW(method.setParameter("blocker_taps", "0"), InputError);
    method.resetParameters();
    EXPECT_TRUE(method.atDefaults());
    EXPECT_EQ(spelled(method.setting()), "pcss");
}

TEST_F(ViewSessionTest, TracksPlayBetweenTheListedFrames) {
    ViewSession session(options("fence", {"hard"}));
    const Timeline& timeline = session.timeline();
    ASSERT_TRUE(timeline.moves());
    ASSERT_EQ(timeline.listed.size(), 3u);
    EXPECT_EQ(timeline.timesS[static_cast<std::size_t>(timeline.listed[1])], 0.5);
    session.showFrame(timeline.frameAt(0.25));
    // The light grows linearly from 0.1 to 0.4 m in half a second; frames are 1/30 s apart.
    EXPECT_NEAR(2.0 * session.light().halfU, 0.25, 0.6 / 60.0 + 1e-9);
    session.showFrame(timeline.frameAt(1.0));
    EXPECT_EQ(2.0 * session.light().halfU, 1.0);
    session.showFrame(100000);
    EXPECT_EQ(session.timeS(), 1.0);
    // A light moved by hand stays while the time goes on, until it is given back.
    AreaLight light = session.light();
    light.halfU = 0.05;
    session.setLight(light);
    session.showFrame(0);
    EXPECT_EQ(session.light().halfU, 0.05);
    session.resetLight();
    EXPECT_EQ(2.0 * session.light().halfU, 0.1);
}

TEST_F(ViewSessionTest, FramesThatDoNotExistAreRefused) {
    ViewOptions o = options("fence", {"hard"});
    o.frame = 3;
    EXPECT_THROW(ViewSession{o}, InputError);
    o.frame = 2;
    EXPECT_EQ(ViewSession(o).timeS(), 1.0);
}

}  // namespace
}  // namespace penumbra
