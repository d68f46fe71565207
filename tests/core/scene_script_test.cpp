#include <fmt/format.h>

#include <cmath>

#include "tests/core/scene_files.hpp"

namespace penumbra::testing {
namespace {

constexpr double kFloatTolerance = 1e-6;  // positions are floats of order 1

/// "floor", "arm" with child "hand" (a quad each) and "tripod", which has a matrix.
GltfFile armFile() {
    GltfFile file;
    file.node({{"mesh", file.quad({0, 0, 0}, {2, 0, 0}, {0, 0, -2})}, {"name", "floor"}});
    const int hand = file.add("nodes", {{"mesh", file.quad({0, 0, 0}, {0.1f, 0, 0}, {0, 0.1f, 0})},
                                        {"name", "hand"},
                                        {"translation", {1, 0, 0}}});
    file.node({{"children", {hand}}, {"name", "arm"}, {"translation", {0, 1, 0}}});
    file.node({{"name", "tripod"}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}});
    return file;
}

const std::string kHead = "shows = 'a test'\nasset = 'arm.gltf'\n";
const std::string kCamera = "[camera]\nposition = [0, 1, 5]\ntarget = [0, 1, 0]\nfov_y = 40\n";
const std::string kLight = "[light]\nposition = [0, 4, 0]\ntarget = [0, 0, 0]\nsize = [1, 0.5]\n";

std::shared_ptr<const Scene> loadText(const TempFolder& folder, const std::string& text,
                                      const GltfFile& asset = armFile()) {
    folder.write("arm.gltf", asset.gltf());
    return loadScene(folder.write("test.toml", text).string(), folder.library());
}

/// World position of the hand's first corner relative to where it is at rest, (0.9, 0.9, 0).
glm::dvec3 handShift(const Scene& scene, int frame) {
    return worldCorner(scene, *scene.frame(frame).geometry, 6) - glm::dvec3(0.9, 0.9, 0);
}

TEST(SceneScript, PlacesLightAndCameraInWorldSpace) {
    const TempFolder folder;
    const auto scene = loadText(folder, kHead + "figure = 'fig. 1'\n" + kCamera + kLight);
    EXPECT_EQ(scene->id, "test");
    EXPECT_EQ(scene->shows, "a test");
    EXPECT_EQ(scene->figure, "fig. 1");
    EXPECT_EQ(scene->asset.filename(), "arm.gltf");
    EXPECT_EQ(scene->frameCount(), 1);
    const SceneFrame frame = scene->frame(0);
    expectNear(frame.light.centre + scene->origin, {0, 4, 0}, 1e-12);
    expectNear(frame.light.normal(), {0, -1, 0}, 1e-12);
    expectNear(frame.light.axisV, {0, 0, -1}, 1e-12);
    EXPECT_DOUBLE_EQ(frame.light.halfU, 0.5);
    EXPECT_DOUBLE_EQ(frame.light.halfV, 0.25);
    expectNear(frame.camera.position + scene->origin, {0, 1, 5}, 1e-12);
    EXPECT_DOUBLE_EQ(frame.camera.fovYRad, glm::radians(40.0));
    EXPECT_FALSE(scene->movingLight || scene->movingCasters || scene->movingCamera);
    EXPECT_TRUE(scene->chosen.empty());
}

TEST(SceneScript, EdgesAreRelativeToTheOrigin) {
    const TempFolder folder;
    const auto scene = loadText(folder, kHead + kCamera + kLight + R"(
[[edge]]
from = [1, 0, 0]
to = [0.5, 0, 0.25]
half_width = 0.125
[[edge]]
from = [0, 0, 0]
to = [0, 0, 1]
half_width = 2
)");
    ASSERT_EQ(scene->edges.size(), 2u);
    expectNear(scene->edges[0].from + scene->origin, {1, 0, 0}, 1e-12);
    expectNear(scene->edges[0].to + scene->origin, {0.5, 0, 0.25}, 1e-12);
    EXPECT_EQ(scene->edges[0].halfWidthM, 0.125);
    EXPECT_EQ(scene->edges[1].halfWidthM, 2.0);
    EXPECT_TRUE(loadText(folder, kHead + kCamera + kLight)->edges.empty());
}

TEST(SceneScript, PointLightHasAxesToo) {
    const TempFolder folder;
    const auto scene = loadText(
        folder, kHead + kCamera + "[light]\nposition=[0,4,0]\ntarget=[0,0,0]\nsize=[0, 0]\n");
    EXPECT_TRUE(scene->frame(0).light.isPoint());
    expectNear(scene->frame(0).light.normal(), {0, -1, 0}, 1e-12);
}

TEST(SceneScript, EmissiveRectangleStaysASurfaceBesideALightTable) {
    GltfFile asset = armFile();
    asset.add("materials", {{"emissiveFactor", {1, 1, 1}}});
    asset.node({{"mesh", asset.quad({0, 3, 0}, {1, 0, 0}, {0, 0, 1}, 0)}});
    const TempFolder folder;
    EXPECT_EQ(loadText(folder, kHead + kCamera, asset)->frame(0).geometry->triangleCount(), 4u);
    EXPECT_EQ(loadText(folder, kHead + kCamera + kLight, asset)->frame(0).geometry->triangleCount(),
              6u);
}

TEST(SceneScript, TracksDriveLightCameraAndNodes) {
    const TempFolder folder;
    const auto scene = loadText(folder, kHead + kCamera + kLight + R"(
[frames]
times = [0, 1, 2]
[[track]]
target = "light.size"
times = [0, 2]
values = [[1, 0.5], [3, 1.5]]
[[track]]
target = "camera.fov_y"
times = [0, 2]
values = [40, 60]
interpolation = "step"
[[track]]
target = "node:arm.rotation"
times = [0, 2]
values = [[0, 0, 0], [0, 0, 180]]
)");
    EXPECT_TRUE(scene->movingLight && scene->movingCasters && scene->movingCamera);
    EXPECT_EQ(scene->frameCount(), 3);
    EXPECT_DOUBLE_EQ(scene->frame(1).light.halfU, 1.0);
    EXPECT_DOUBLE_EQ(scene->frame(2).light.halfV, 0.75);
    EXPECT_DOUBLE_EQ(scene->frame(1).camera.fovYRad, glm::radians(40.0));
    EXPECT_DOUBLE_EQ(scene->frame(2).camera.fovYRad, glm::radians(60.0));
    // The hand's corner, (0.9, -0.1) from the arm, turns about the arm by 90 degrees.
    expectNear(handShift(*scene, 0), {0, 0, 0}, kFloatTolerance);
    expectNear(handShift(*scene, 1), glm::dvec3(0.1, 1.9, 0) - glm::dvec3(0.9, 0.9, 0),
               kFloatTolerance);
    const auto geometry = scene->frame(1).geometry;
    EXPECT_FALSE(geometry->parts[0].moves);
    EXPECT_TRUE(geometry->parts[1].moves);
}

TEST(SceneScript, FramesOfEqualPoseShareTheirGeometry) {
    const TempFolder folder;
    const std::string track =
        "[frames]\ntimes = [0, 1, 2]\n[[track]]\ntarget = 'node:hand.translation'\n"
        "times = [0, 2]\nvalues = [[1, 0, 0], [2, 0, 0]]\ninterpolation = 'step'\n";
    const auto scene = loadText(folder, kHead + kCamera + kLight + track);
    EXPECT_EQ(scene->frame(0).geometry, scene->frame(1).geometry);
    const auto moved = scene->frame(2).geometry;
    EXPECT_NE(scene->frame(0).geometry, moved);
    EXPECT_EQ(scene->frame(2).geometry, moved);
    expectNear(handShift(*scene, 2), {1, 0, 0}, kFloatTolerance);
}

TEST(SceneScript, AnimationsOfTheAssetPlayInSeconds) {
    GltfFile asset = armFile();
    asset.add("materials", {{"emissiveFactor", {1, 1, 1}}});
    const int lamp = asset.node({{"mesh", asset.quad({0, 3, 0}, {1, 0, 0}, {0, 0, 1}, 0)}});
    const double s = std::sqrt(0.5);
    const auto channel = [](int sampler, int node, const char* path) {
        return json{{"sampler", sampler}, {"target", {{"node", node}, {"path", path}}}};
    };
    const int times = asset.floats({1, 3});
    const int shift = asset.vec3s({{1, 0, 0}, {3, 0, 0}});
    const int turn = asset.vec4s({{0, 0, 0, 1}, {0, 0, s, s}});
    const int lift = asset.vec3s({{0, 0, 0}, {0, 2, 0}});
    asset.add("animations", {{"channels", {channel(0, 1, "translation")}},  // the hand
                             {"samplers", {{{"input", times}, {"output", shift}}}}});
    asset.add("animations",
              {{"channels", {channel(0, 2, "rotation"), channel(1, lamp, "translation")}},
               {"samplers",
                {{{"input", times}, {"output", turn}, {"interpolation", "STEP"}},
                 {{"input", times}, {"output", lift}}}}});
    const TempFolder folder;
    const auto scene = loadText(folder, kHead + kCamera + "[frames]\ntimes = [0, 2, 5]\n", asset);
    EXPECT_TRUE(scene->movingCasters && scene->movingLight);
    expectNear(handShift(*scene, 0), {0, 0, 0}, kFloatTolerance);
    expectNear(handShift(*scene, 1), {1, 0, 0}, kFloatTolerance);
    // Held at the end: 3 along the arm, which has turned by 90 degrees about Z.
    expectNear(handShift(*scene, 2), glm::dvec3(0.1, 3.9, 0) - glm::dvec3(0.9, 0.9, 0),
               kFloatTolerance);
    expectNear(scene->frame(1).light.centre + scene->origin, {0, 4, 0}, kFloatTolerance);
    expectNear(scene->frame(2).light.centre + scene->origin, {0, 5, 0}, kFloatTolerance);

    const auto bare = loadScene((folder.path() / "arm.gltf").string(), folder.library());
    EXPECT_EQ(bare->frameCount(), 1);
    EXPECT_FALSE(bare->movingCasters || bare->movingLight);
}

TEST(SceneScript, GroundIsAddedOnlyWhenAsked) {
    const TempFolder folder;
    EXPECT_EQ(loadText(folder, kHead)->frame(0).geometry->triangleCount(), 4u);
    const auto scene = loadText(folder, kHead + "ground = true\n");
    EXPECT_EQ(scene->frame(0).geometry->triangleCount(), 6u);
    EXPECT_EQ(scene->chosen.size(), 3u);  // light, camera, ground
}

TEST(SceneScript, IdsAreTheScriptsOfTheLibrary) {
    const TempFolder folder;
    folder.write("zebra.toml", "");
    folder.write("arm.gltf", armFile().gltf());
    folder.write("ant.toml", kHead);
    EXPECT_EQ(folder.library().ids(), (std::vector<std::string>{"ant", "zebra"}));
    EXPECT_EQ(loadScene("ant", folder.library())->id, "ant");
    EXPECT_EQ(failureOf("bee", folder.library()), "unknown scene 'bee'; scenes are ant, zebra");
    EXPECT_NE(failureOf("image.png", folder.library()).find("ant, zebra"), std::string::npos);
    EXPECT_NE(failureOf("gone.toml", folder.library()).find("gone.toml: does not exist"),
              std::string::npos);
}

TEST(SceneScript, GeneratedAssetsComeFromTheLibrary) {
    const TempFolder folder;
    folder.write("made.glb", armFile().glb());
    const auto path = folder.write("test.toml", "shows = 'x'\nasset = 'generated:made.glb'\n");
    EXPECT_EQ(loadScene(path.string(), folder.library())->frame(0).geometry->triangleCount(), 4u);
}

TEST(SceneScript, AbsentPackageSkipsTheScene) {
    const TempFolder folder;
    folder.write("engine.toml",
                 "shows = 'x'\nasset = 'package:/nowhere/e.glb'\npackage = 'some-models'\n");
    try {
        loadScene("engine", folder.library());
        FAIL() << "loaded an asset that is not there";
    } catch (const AssetAbsent& e) {
        EXPECT_STREQ(e.what(),
                     "scene 'engine' skipped: install Debian package some-models "
                     "(missing /nowhere/e.glb)");
    }
}

TEST(SceneScript, DecimalPointsAndDotsInProseAreNoDeepKeys) {
    const TempFolder folder;
    const std::string many =
        "times = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, "
        "1.2, 1.3, 1.4, 1.5e0, 1.6, 1.7, 1.8, 1.9]\n";
    EXPECT_EQ(loadText(folder, "# " + std::string(80, '.') + "\n" + kHead + "[frames]\n" + many)
                  ->frameCount(),
              20);
}

TEST(SceneScript, SizeAndFramesAreBounded) {
    const TempFolder folder;
    const auto path = folder.write("test.toml", kHead + std::string(16 << 20, '#'));
    EXPECT_NE(failureOf(path, folder.library()).find("a script has at most 16777216"),
              std::string::npos);
    std::string times = "[frames]\ntimes = [0";
    for (int i = 1; i <= 10000; ++i) times += "," + std::to_string(i);
    folder.write("test.toml", kHead + times + "]\n");
    EXPECT_NE(failureOf(path, folder.library()).find("test.toml:4:9: at most 10000 frames"),
              std::string::npos)
        << failureOf(path, folder.library());
}

struct BadScript {
    const char* name;
    std::string text;
    const char* place;     ///< "line:column" or "line:" where the column is not worth pinning
    const char* expected;  ///< part of the message
};

class SceneScriptBad : public ::testing::TestWithParam<BadScript> {};

TEST_P(SceneScriptBad, IsRefusedWithItsPlace) {
    const TempFolder folder;
    folder.write("arm.gltf", armFile().gltf());
    const auto path = folder.write("bad.toml", GetParam().text);
    const std::string message = failureOf(path, folder.library());
    EXPECT_TRUE(message.starts_with(fmt::format("{}:{}", path.string(), GetParam().place)))
        << message;
    EXPECT_NE(message.find(GetParam().expected), std::string::npos) << message;
}

std::string repeated(const std::string& text, int times) {
    std::string out;
    for (int i = 0; i < times; ++i) out += text;
    return out;
}

const std::string kFull = kHead + kCamera + kLight;  // 10 lines

const BadScript kBadScripts[] = {
    {"Syntax", "shows = \n", "1:", "rror"},
    {"NoShows", "asset = 'arm.gltf'\n", "1:1", "needs 'shows'"},
    {"NoAsset", "shows = 'x'\n", "1:1", "needs 'asset'"},
    {"UnknownKey", kHead + "shine = 1\n", "3:1",
     "unknown key 'shine' in a scene script; valid keys are shows, figure, asset, package, ground, "
     "camera, light, frames, track, edge"},
    {"UnknownCameraKey", kHead + "[camera]\npostion = [0, 1, 5]\n", "4:1",
     "unknown key 'postion' in [camera]; valid keys are position, target, up, fov_y"},
    {"ShowsNoText", "shows = 3\nasset = 'arm.gltf'\n", "1:9", "must be a string"},
    {"GroundNoBool", kHead + "ground = 1\n", "3:10", "true or false"},
    {"CameraNoTable", kHead + "camera = 1\n", "3:10", "[camera]"},
    {"ShortPoint", kHead + "[camera]\nposition = [0, 1]\n", "4:12", "a list of 3 numbers"},
    {"TextInPoint", kHead + "[camera]\nposition = [0, 'a', 0]\n", "4:16", "finite number"},
    {"InfinitePoint", kHead + "[camera]\nposition = [0, inf, 0]\n", "4:16", "finite number"},
    {"NoTarget", kHead + "[camera]\nposition = [0, 1, 0]\nfov_y = 3\n", "3:", "needs 'target'"},
    {"TargetIsPosition", kHead + "[camera]\nposition = [0, 1, 0]\ntarget = [0, 1, 0]\nfov_y = 30\n",
     "5:10", "target must differ"},
    {"WideAngle", kHead + "[camera]\nposition = [0, 1, 0]\ntarget = [0, 0, 0]\nfov_y = 180\n",
     "6:9", "below 180"},
    {"UpAlongView", kHead + "[camera]\nposition=[0,1,0]\ntarget=[0,0,0]\nup=[0,1,0]\nfov_y = 30\n",
     "3:", "up must not lie"},
    {"NegativeSize", kHead + "[light]\nposition=[0,4,0]\ntarget=[0,0,0]\nsize = [1, -1]\n", "6:8",
     "size must be"},
    {"LineLight", kHead + "[light]\nposition=[0,4,0]\ntarget=[0,0,0]\nsize = [1, 0]\n", "6:8",
     "size must be"},
    {"UnsortedFrames", kHead + "[frames]\ntimes = [0, 2, 1]\n", "4:16", "must increase"},
    {"NoFrames", kHead + "[frames]\ntimes = []\n", "4:9", "at least one"},
    {"TrackNoArray", kHead + "[track]\ntarget = 'light.size'\n", "3:", "[[track]]"},
    {"UnknownTarget", kFull + "[[track]]\ntarget = 'light.colour'\n", "12:10",
     "valid targets are light.position"},
    {"UnknownNode",
     kFull + "[[track]]\ntarget = 'node:leg.scale'\ntimes = [0]\nvalues = [[1, 1, 1]]\n", "12:10",
     "no node 'leg'; its nodes are arm, floor, hand, tripod"},
    {"NodeWithMatrix",
     kFull + "[[track]]\ntarget = 'node:tripod.scale'\ntimes = [0]\nvalues = [[1, 1, 1]]\n",
     "12:10", "matrix"},
    {"TrackValuesCount",
     kFull + "[[track]]\ntarget = 'light.size'\ntimes = [0, 1]\nvalues = [[1, 1]]\n", "14:10",
     "each of the 2 times"},
    {"TrackValueLength",
     kFull + "[[track]]\ntarget = 'light.size'\ntimes = [0]\nvalues = [[1, 1, 1]]\n", "14:11",
     "a list of 2 numbers"},
    {"TrackNegativeSize",
     kFull + "[[track]]\ntarget = 'light.size'\ntimes = [0]\nvalues = [[1, -1]]\n", "14:11",
     "size must be"},
    {"Interpolation",
     kFull + "[[track]]\ntarget = 'light.size'\ntimes = [0]\nvalues = [[1, 1]]\n"
             "interpolation = 'cubic'\n",
     "15:17", "valid are linear, step"},
    {"TrackWithoutTable", kHead + "[[track]]\ntarget = 'light.size'\n", "4:10", "needs a [light]"},
    {"TwoTracks",
     kFull + "[[track]]\ntarget = 'light.size'\ntimes = [0]\nvalues = [[1, 1]]\n"
             "[[track]]\ntarget = 'light.size'\ntimes = [0]\nvalues = [[1, 1]]\n",
     "16:10", "has a track already"},
    {"TrackThroughTarget",
     kFull + "[frames]\ntimes = [0, 1]\n[[track]]\ntarget = 'light.position'\ntimes = [0, 1]\n"
             "values = [[0, 4, 0], [0, 0, 0]]\n",
     "7:", "at 1 s the light has no direction"},
    {"EdgeNoArray", kHead + "[edge]\nfrom = [0, 0, 0]\n", "3:", "[[edge]]"},
    {"UnknownEdgeKey", kHead + "[[edge]]\nwidth = 1\n", "4:1",
     "unknown key 'width' in [[edge]]; valid keys are from, to, half_width"},
    {"EdgeWithoutTo", kHead + "[[edge]]\nfrom = [0, 0, 0]\nhalf_width = 1\n",
     "3:", "[[edge]] needs 'to'"},
    {"EdgeWithoutHalfWidth", kHead + "[[edge]]\nfrom = [0, 0, 0]\nto = [1, 0, 0]\n",
     "3:", "[[edge]] needs 'half_width'"},
    {"EdgeOfNoLength", kHead + "[[edge]]\nfrom = [1, 0, 0]\nto = [1, 0, 0]\nhalf_width = 1\n",
     "5:6", "to must differ from from"},
    {"EdgeOfNoWidth", kHead + "[[edge]]\nfrom = [0, 0, 0]\nto = [1, 0, 0]\nhalf_width = 0\n",
     "6:14", "half_width must be a length in metres above 0"},
    {"MissingAsset", "shows = 'x'\nasset = 'gone.glb'\n", "2:9", "gone.glb does not exist"},
    {"AssetOfOtherKind", "shows = 'x'\nasset = 'arm.obj'\n", "2:9", "neither .glb nor .gltf"},
    {"GeneratedWithFolder", "shows = 'x'\nasset = 'generated:../a.glb'\n", "2:9",
     "plain file name"},
    {"PackageRelative", "shows = 'x'\nasset = 'package:a.glb'\n", "2:9", "absolute path"},
    {"NanTime", kHead + "[frames]\ntimes = [0, nan]\n", "4:13", "finite number"},
    {"TextTime", kHead + "[frames]\ntimes = [0, '1']\n", "4:13", "finite number"},
    {"UnsortedTrack",
     kFull + "[[track]]\ntarget = 'light.size'\ntimes = [1, 0]\nvalues = [[1, 1], [1, 1]]\n",
     "13:13", "must increase"},
    {"KeyTwice", kHead + "shows = 'y'\n", "3:", "rror"},
    {"HalfATable", kHead + "[[:edge]]\n", "3:", "rror"},
    {"NoUtf8", kHead + "figure = '\xFF'\n", "3:", "tf-8"},
    // What the reference's and the GPU's floats would make infinite.
    {"FarLight", kHead + "[light]\nposition=[1e30,4,0]\ntarget=[0,0,0]\nsize=[1,1]\n", "4:11",
     "position must be a number from -1e+15 to 1e+15, not 1e+30"},
    {"WideLight", kHead + "[light]\nposition=[0,4,0]\ntarget=[0,0,0]\nsize=[1e25,1e25]\n", "6:7",
     "size must be a number from -1e+15"},
    {"FarCamera", kHead + "[camera]\nposition=[0,-1e300,0]\ntarget=[0,0,0]\nfov_y=30\n", "4:13",
     "position must be a number from -1e+15"},
    {"WideTrack", kFull + "[[track]]\ntarget='node:arm.scale'\ntimes=[0]\nvalues=[[1, 1e16, 1]]\n",
     "14:13", "each of values must be a number from -1e+15"},
    // toml++ itself would overflow the stack over keys of some 20000 parts.
    {"DeepKey", kHead + "a" + repeated(".a", 100000) + " = 1\n", "3:1", "more than 16 dots"},
    {"DeepTable", kHead + "[a" + repeated(" . '.'", 20) + "]\n", "3:1", "more than 16 dots"},
    {"DeepKeyOfNumbers", kHead + "1.1" + repeated(" .1.1", 17) + " = 1\n", "3:1",
     "more than 16 dots"},
    {"DeepList", kHead + "a = " + repeated("[", 100000) + "\n", "3:", "nested"},
};

INSTANTIATE_TEST_SUITE_P(All, SceneScriptBad, ::testing::ValuesIn(kBadScripts),
                         [](const auto& each) { return std::string(each.param.name); });

}  // namespace
}  // namespace penumbra::testing
