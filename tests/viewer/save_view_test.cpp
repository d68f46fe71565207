#include "harness/viewer/save_view.hpp"

#include "core/error.hpp"
#include "core/image/image.hpp"
#include "harness/run/compare.hpp"
#include "harness/run/run_folder.hpp"
#include "harness/run/suite.hpp"
#include "harness/viewer/camera_control.hpp"
#include "tests/support/run_program.hpp"
#include "tests/viewer/viewer_fixture.hpp"

namespace penumbra {
namespace {

using test::settle;

class SaveView : public test::ViewerTest {
  protected:
    /// What `penumbra compare` makes of a saved script.
    std::vector<float> batchImage(const std::filesystem::path& script, const std::string& method) {
        test::endGlContext();
        CompareOptions o;
        static_cast<TruthOptions&>(o) = smallTruth();
        o.scenes = {script.string()};
        o.settings.methods = {method};
        o.repeats = 1;
        o.out = folder.path() / ("run_" + script.stem().string());
        EXPECT_EQ(compare(o), 0);
        test::glContext();
        return readImage(o.out / "images" / script.stem() / "0000" / (method + ".exr"))
            .channel("visibility");
    }
    TruthOptions smallTruth() const { return options("half_plane", {}); }

    /// Saves a view after `edit` and expects the batch runner to render the same image.
    template <class Edit>
    void expectSameInBatch(const std::string& scene, const std::string& method, const Edit& edit,
                           std::size_t files) {
        std::vector<float> shown;
        const auto script = folder.path() / "saved.toml";
        {
            ViewSession session(options(scene, {method}));
            edit(session);
            settle(session);
            shown = session.method(0)->visibility();
            EXPECT_EQ(saveView(session, script).size(), files);
        }
        const std::vector<float> batch = batchImage(script, method);
        ASSERT_EQ(batch.size(), shown.size());
        for (std::size_t i = 0; i < shown.size(); ++i)
            ASSERT_NEAR(shown[i], batch[i], 1.0 / 255) << scene << " pixel " << i;
    }
};

TEST_F(SaveView, AMovedCameraAndLightBetweenTwoFrames) {
    expectSameInBatch(
        "fence", "pcss",
        [](ViewSession& s) {
            s.showFrame(s.timeline().frameAt(0.71));
            s.setCamera(orbited(s.camera(), glm::dvec3(0.0), 0.3, 0.1));
            AreaLight light = s.light();
            light.centre += glm::dvec3(0.2, -0.1, 0.3);
            light.halfU *= 1.5;
            s.setLight(light);
        },
        1);
}

TEST_F(SaveView, CastersThatTheScriptMoves) {
    expectSameInBatch(
        "two_layers", "pcf", [](ViewSession& s) { s.showFrame(s.timeline().listed[2]); }, 1);
}

TEST_F(SaveView, CastersThatTheAssetMoves) {
    expectSameInBatch(
        "spinner", "pcf", [](ViewSession& s) { s.showFrame(s.timeline().frameAt(0.37)); }, 1);
}

/// An asset without light, camera or ground of its own, all three of which are placed.
std::string bareAsset() {
    return (SceneLibrary::standard().assets / "teapot.glb").string();
}

TEST_F(SaveView, ABareAssetAsItIs) {
    expectSameInBatch(
        bareAsset(), "pcf",
        [](ViewSession& s) { s.setCamera(orbited(s.camera(), glm::dvec3(0.0), -0.4, 0.0)); }, 1);
}

TEST_F(SaveView, ABareAssetUnderAnotherLightIsWrittenWithTheScript) {
    expectSameInBatch(
        bareAsset(), "pcf",
        [](ViewSession& s) {
            AreaLight light = s.light();
            light.centre.x *= 1.3;
            light.halfV *= 2.0;
            s.setLight(light);
        },
        2);
}

TEST_F(SaveView, APointLightOverAnAsset) {
    expectSameInBatch(
        bareAsset(), "hard",
        [](ViewSession& s) {
            AreaLight light = s.light();
            light.halfU = light.halfV = 0.0;
            s.setLight(light);
        },
        2);
}

TEST_F(SaveView, WhatCannotBeSaidIsRefused) {
    ViewSession session(options("half_plane", {"hard"}));
    EXPECT_THROW(saveView(session, folder.path() / "view.glb"), InputError);
    EXPECT_THROW(saveView(session, folder.path() / "no folder" / "view.toml"), std::runtime_error);
    Camera camera = session.camera();
    camera.kind = Camera::Kind::orthographic;
    session.setCamera(camera);
    EXPECT_THROW(saveView(session, folder.path() / "view.toml"), InputError);
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "view.toml"));
}

class AddToSuite : public ::testing::Test {
  protected:
    AddToSuite() {
        for (const char* id : {"a", "b", "c"}) folder.write(std::string(id) + ".toml", "");
        std::filesystem::create_directories(folder.path() / "suites");
    }
    std::vector<std::string> scenesOf(const std::string& suite) const {
        return loadSuite(suite, folder.library()).scenes;
    }
    std::string text(const std::string& suite) const {
        return test::readText(folder.path() / "suites" / (suite + ".toml"));
    }
    testing::TempFolder folder;
};

TEST_F(AddToSuite, MakesASuiteAndAddsToIt) {
    addToSuite(folder.library(), "mine", "b");
    EXPECT_EQ(scenesOf("mine"), (std::vector<std::string>{"b"}));
    addToSuite(folder.library(), "mine", "a");
    EXPECT_EQ(scenesOf("mine"), (std::vector<std::string>{"b", "a"}));
}

TEST_F(AddToSuite, KeepsWhatIsWrittenAround) {
    for (const std::string list : {"[ \"a\" ]", "[\n    \"a\",  # first, \"not b\"\n]", "['a',]"}) {
        folder.write("suites/mine.toml", "# mine\nshows = \"é\"\nscenes = " + list + " # end\n");
        addToSuite(folder.library(), "mine", "b");
        EXPECT_EQ(scenesOf("mine"), (std::vector<std::string>{"a", "b"})) << list;
        EXPECT_TRUE(text("mine").starts_with("# mine\nshows = \"é\"\nscenes = ")) << list;
        EXPECT_TRUE(text("mine").ends_with(" # end\n")) << list;
    }
}

TEST_F(AddToSuite, RefusesAndLeavesTheFileAsItIs) {
    addToSuite(folder.library(), "mine", "a");
    const std::string before = text("mine");
    EXPECT_THROW(addToSuite(folder.library(), "mine", "a"), InputError);
    EXPECT_THROW(addToSuite(folder.library(), "mine", "nope"), InputError);
    EXPECT_THROW(addToSuite(folder.library(), "../mine", "b"), InputError);
    EXPECT_EQ(text("mine"), before);
    folder.write("suites/broken.toml", "scenes = 3\n");
    EXPECT_THROW(addToSuite(folder.library(), "broken", "a"), InputError);
    EXPECT_EQ(text("broken"), "scenes = 3\n");
}

}  // namespace
}  // namespace penumbra
