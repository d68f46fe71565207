#include <cmath>

#include "tests/core/scene_samples.hpp"

namespace penumbra::testing {
namespace {

// Positions are floats relative to the scene's centre: a few units in the last place of 1.
constexpr double kFloatTolerance = 1e-6;

std::shared_ptr<const Scene> loadWith(const TempFolder& folder, const GltfFile& file,
                                      const LoadOptions& options) {
    return loadScene(folder.write("asset.gltf", file.gltf()).string(), folder.library(), options);
}

/// The asset's frames at `times`, as a script sees them.
std::shared_ptr<const Scene> loadAt(const TempFolder& folder, const GltfFile& file,
                                    const std::string& times) {
    folder.write("asset.gltf", file.gltf());
    const auto script = folder.write("moving.toml",
                                     "shows = \"frames\"\nasset = \"asset.gltf\"\n"
                                     "[light]\nposition = [0, 9, 9]\ntarget = [0, 0, 0]\n"
                                     "size = [1, 1]\n[frames]\ntimes = " +
                                         times + "\n");
    return loadScene(script.string(), folder.library());
}

std::vector<glm::dvec3> corners(const Scene& scene, int frame, std::size_t count) {
    const auto geometry = scene.frame(frame).geometry;
    std::vector<glm::dvec3> out;
    for (std::size_t i = 0; i < count; ++i) out.push_back(worldCorner(scene, *geometry, i));
    return out;
}

// --- Topology and accessors ----------------------------------------------------------------------

TEST(SceneGltfFeatures, StripsAndFansBecomeTriangles) {
    const std::vector<glm::vec3> outline = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    for (const int mode : {5, 6}) {
        GltfFile file;
        json primitive = {{"attributes", {{"POSITION", file.vec3s(outline)}}}, {"mode", mode}};
        if (mode == 5) primitive["indices"] = file.u16s({0, 1, 3, 2});
        file.node({{"mesh", file.mesh(primitive)}});
        const TempFolder folder;
        const auto scene = load(folder, file);
        const auto geometry = scene->frame(0).geometry;
        ASSERT_EQ(geometry->parts[0].indexCount, 6u) << mode;
        double area = 0.0;
        for (std::size_t t = 0; t < 2; ++t) {
            const glm::dvec3 a = worldCorner(*scene, *geometry, 3 * t),
                             b = worldCorner(*scene, *geometry, 3 * t + 1),
                             c = worldCorner(*scene, *geometry, 3 * t + 2);
            area += 0.5 * glm::cross(b - a, c - a).z;  // both wound alike
        }
        EXPECT_NEAR(area, 1.0, kFloatTolerance) << mode;
    }
}

TEST(SceneGltfFeatures, DegenerateLinksOfAStripAreDroppedAndCounted) {
    GltfFile file;
    const int position =
        file.vec3s({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {3, 0, 0}, {4, 0, 0}, {3, 1, 0}});
    file.node({{"mesh", file.mesh({{"attributes", {{"POSITION", position}}},
                                   {"indices", file.u16s({0, 1, 2, 2, 3, 3, 4, 5})},
                                   {"mode", 5}})}});
    const TempFolder folder;
    const auto scene = load(folder, file);
    EXPECT_EQ(scene->frame(0).geometry->parts[0].indexCount, 6u);
    EXPECT_EQ(scene->chosen[0], "4 zero-area triangles dropped");
}

TEST(SceneGltfFeatures, PointsAndLinesBesideTrianglesAreLeftOutAndSaid) {
    GltfFile file = triangleFile();
    file.node({{"mesh", file.mesh({{"attributes", {{"POSITION", 0}}}, {"mode", 1}})}});
    const TempFolder folder;
    const auto scene = load(folder, file);
    EXPECT_EQ(scene->chosen[0], "1 primitives of points or lines cast no shadow, left out");
}

TEST(SceneGltfFeatures, SparseValuesReplaceThoseOfTheBufferView) {
    GltfFile file = triangleFile();
    const int which = file.accessor<std::uint8_t>({2}, GltfFile::kU8, "SCALAR", 1);
    const int values = file.vec3s({{0, 5, 0}});
    file.root["accessors"][0]["sparse"] = {
        {"count", 1},
        {"indices", {{"bufferView", which}, {"componentType", GltfFile::kU8}}},
        {"values", {{"bufferView", values}}}};
    const TempFolder folder;
    const auto at = corners(*load(folder, file), 0, 3);
    expectNear(at[1], {1, 0, 0}, kFloatTolerance);
    expectNear(at[2], {0, 5, 0}, kFloatTolerance);
}

TEST(SceneGltfFeatures, SparseIndicesWithoutABufferViewStartFromZeros) {
    GltfFile file = triangleFile();
    const int which = file.accessor<std::uint32_t>({1, 2}, GltfFile::kU32, "SCALAR", 2);
    const int values = file.accessor<std::uint16_t>({1, 2}, GltfFile::kU16, "SCALAR", 2);
    const int indices = file.add(
        "accessors", {{"componentType", GltfFile::kU16},
                      {"type", "SCALAR"},
                      {"count", 3},
                      {"sparse",
                       {{"count", 2},
                        {"indices", {{"bufferView", which}, {"componentType", GltfFile::kU32}}},
                        {"values", {{"bufferView", values}}}}}});
    file.root["meshes"][0]["primitives"][0]["indices"] = indices;
    const TempFolder folder;
    const auto at = corners(*load(folder, file), 0, 3);
    expectNear(at[0], {0, 0, 0}, kFloatTolerance);
    expectNear(at[2], {0, 1, 0}, kFloatTolerance);
}

TEST(SceneGltfFeatures, QuantisedAttributesAreReadAndTheirCoordinatesTransformed) {
    const TempFolder folder;
    const auto scene = load(folder, maskedFile());
    const auto geometry = scene->frame(0).geometry;
    ASSERT_GE(geometry->parts[0].vertexCount, 4u);
    // The fan's first triangle is 1, 2, 0.
    const auto at = corners(*scene, 0, 3);
    expectNear(at[0], {2, 0, 0}, kFloatTolerance);
    expectNear(at[1], {2, 1, 0}, kFloatTolerance);
    expectNear(at[2], {0, 0, 0}, kFloatTolerance);
    expectNear(geometry->normals[0], {0, 0, 1}, kFloatTolerance);
    EXPECT_EQ(geometry->uvs[geometry->indices[1]], glm::vec2(1.0f, 0.25f));  // of (1, 1)
    EXPECT_EQ(geometry->uvs[geometry->indices[2]], glm::vec2(0.5f, 0.0f));   // of (0, 0)
}

TEST(SceneGltfFeatures, TextureCoordinatesTurnCounterClockwiseInTheImage) {
    GltfFile file = maskedFile();
    file.root["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]
             ["KHR_texture_transform"] = {{"rotation", std::acos(0.0)}};
    const TempFolder folder;
    const auto geometry = load(folder, file)->frame(0).geometry;
    // v points down: a quarter turn takes u to -v.
    expectNear(glm::dvec3(geometry->uvs[geometry->indices[0]], 0), {0, -1, 0}, kFloatTolerance);
}

// --- Instances -----------------------------------------------------------------------------------

TEST(SceneGltfFeatures, InstancesArePlacedBelowTheirNode) {
    const TempFolder folder;
    const auto scene = load(folder, sparseInstancedFile());
    const auto geometry = scene->frame(0).geometry;
    EXPECT_EQ(geometry->parts[0].indexCount, 9u);
    const auto at = corners(*scene, 0, 9);
    expectNear(at[1], {6, 0, 0}, kFloatTolerance);
    expectNear(at[4], {4, 0, 1}, kFloatTolerance);  // half a turn about Z
    expectNear(at[5], {5, -1, 1}, kFloatTolerance);
    expectNear(at[7], {7, 0, 2}, kFloatTolerance);
    expectNear(at[8], {5, 3, 2}, kFloatTolerance);
}

// --- Deformation ---------------------------------------------------------------------------------

TEST(SceneGltfFeatures, MorphTargetsAddByTheirWeights) {
    GltfFile file = triangleFile();
    json& primitive = file.root["meshes"][0]["primitives"][0];
    const int up = file.vec3s({{0, 0, 1}, {0, 0, 2}, {0, 0, 3}});
    const int side = file.vec3s({{1, 0, 0}, {1, 0, 0}, {1, 0, 0}});
    primitive["targets"] = json::array({{{"POSITION", up}}, {{"POSITION", side}}});
    file.root["meshes"][0]["weights"] = {0.5, 2};
    const TempFolder folder;
    auto at = corners(*load(folder, file), 0, 3);
    expectNear(at[0], {2, 0, 0.5}, kFloatTolerance);
    expectNear(at[1], {3, 0, 1}, kFloatTolerance);
    expectNear(at[2], {2, 1, 1.5}, kFloatTolerance);
    file.root["nodes"][0]["weights"] = {1, 0};  // the node's win
    at = corners(*load(folder, file), 0, 3);
    expectNear(at[2], {0, 1, 3}, kFloatTolerance);
}

TEST(SceneGltfFeatures, FlatNormalsFollowTheDeformation) {
    GltfFile file = triangleFile();
    const int up = file.vec3s({{0, 0, 0}, {0, 0, 1}, {0, 0, 0}});
    file.root["meshes"][0]["primitives"][0]["targets"] = json::array({{{"POSITION", up}}});
    file.root["meshes"][0]["weights"] = {1};
    const TempFolder folder;
    const auto geometry = load(folder, file)->frame(0).geometry;
    expectNear(geometry->normals[0], glm::normalize(glm::dvec3(-1, 0, 1)), kFloatTolerance);
}

TEST(SceneGltfFeatures, SkinMorphAndAnimationGiveTheVerticesComputedByHand) {
    const TempFolder folder;
    const auto scene = loadAt(folder, deformingFile(), "[0, 0.5, 1]");
    EXPECT_TRUE(scene->movingCasters);
    // Strip 0 1 2 | 1 3 2 | 2 3 4 | 3 5 4: corners 0, 4, 10 are vertices 0, 3 and 5.
    auto at = corners(*scene, 0, 12);  // at rest, weight 0
    expectNear(at[0], {0, 0, 0}, kFloatTolerance);
    expectNear(at[10], {1, 2, 0}, kFloatTolerance);
    at = corners(*scene, 2, 12);  // root at z = 1, tip turned by 90 degrees, weight 1: z + 0.25
    expectNear(at[0], {0, 0, 1.25}, kFloatTolerance);
    // Vertex 5 is (1, 2): (1, 1) from the tip's origin (0, 1), turned to (-1, 1).
    expectNear(at[10], {-1, 2, 1.25}, kFloatTolerance);
    // Vertex 3 is (1, 1), half at rest and half (1, 0) turned to (0, 1) plus (0, 1).
    expectNear(at[4], {0.5, 1.5, 1.25}, kFloatTolerance);
    at = corners(*scene, 1, 12);  // STEP: root still at 0; LINEAR: weight 0.5
    expectNear(at[0], {0, 0, 0.125}, kFloatTolerance);
    // CUBICSPLINE with zero tangents halfway is the mean of the quaternions: 45 degrees.
    const double s = std::sqrt(0.5);
    expectNear(at[10], {0, 1 + 2 * s, 0.125}, kFloatTolerance);
}

TEST(SceneGltfFeatures, NormalsFollowTheSkin) {
    GltfFile file = deformingFile();
    file.root["animations"][0]["channels"][0]["target"]["path"] = "rotation";
    // A quarter turn about X: z -> -y.
    file.root["nodes"][1]["rotation"] = {std::sqrt(0.5), 0, 0, std::sqrt(0.5)};
    file.root["animations"] = json::array();
    const TempFolder folder;
    const auto geometry = load(folder, file)->frame(0).geometry;
    expectNear(geometry->normals[geometry->indices[10]], {0, -1, 0}, kFloatTolerance);
    expectNear(geometry->normals[geometry->indices[0]], {0, 0, 1}, kFloatTolerance);
}

TEST(SceneGltfFeatures, VerticesOfASkinIgnoreTheMeshsOwnNode) {
    GltfFile file = deformingFile();
    const TempFolder folder;
    const auto at = corners(*load(folder, file), 0, 1);
    file.root["nodes"][0]["translation"] = {7, 7, 7};
    expectNear(corners(*load(folder, file), 0, 1)[0], at[0], kFloatTolerance);
}

TEST(SceneGltfFeatures, WeightsAreMadeToSumToOneAndNoneFollowsTheFirstJoint) {
    GltfFile file = deformingFile();
    GltfFile uneven = file;
    const int weights = uneven.vec4s(
        {{0, 0, 0, 0}, {3, 0, 0, 0}, {2, 2, 0, 0}, {0.1f, 0.1f, 0, 0}, {5, 0, 0, 0}, {0, 0, 0, 0}});
    uneven.root["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = weights;
    const TempFolder folder;
    const auto a = corners(*loadAt(folder, file, "[1, 2]"), 0, 12);
    const auto b = corners(*loadAt(folder, uneven, "[1, 2]"), 0, 12);
    for (std::size_t i = 0; i < 12; ++i) expectNear(a[i], b[i], kFloatTolerance);
}

// --- Choices -------------------------------------------------------------------------------------

TEST(SceneGltfFeatures, CamerasAreChosenByIndexOrName) {
    const TempFolder folder;
    const auto cameraOf = [&](const std::string& camera) {
        LoadOptions options;
        options.camera = camera;
        const auto scene = loadWith(folder, deformingFile(), options);
        return scene->frame(0).camera.position + scene->origin;
    };
    expectNear(cameraOf(""), {0, 1, 5}, 1e-9);
    expectNear(cameraOf("1"), {-5, 1, 0}, 1e-9);
    expectNear(cameraOf("left"), {-5, 1, 0}, 1e-9);
    try {
        cameraOf("right");
        FAIL();
    } catch (const InputError& e) {
        EXPECT_NE(std::string(e.what()).find("the cameras are 0 'front', 1 'left'"),
                  std::string::npos)
            << e.what();
    }
}

TEST(SceneGltfFeatures, ScenesAreChosenByIndexOrName) {
    const TempFolder folder;
    const auto load = [&](const std::string& scene) {
        LoadOptions options;
        options.assetScene = scene;
        return loadWith(folder, deformingFile(), options);
    };
    expectNear(load("day")->frame(0).camera.back, {0, 0, 1}, 1e-9);
    // The other scene has no camera: one is placed.
    EXPECT_EQ(load("night")->frame(0).camera, load("1")->frame(0).camera);
    EXPECT_NE(load("night")->frame(0).camera.back.x, 0.0);
    try {
        load("2");
        FAIL();
    } catch (const InputError& e) {
        EXPECT_NE(std::string(e.what()).find("/scenes: --asset-scene 2: the scenes are 0 'day', 1 "
                                             "'night'"),
                  std::string::npos)
            << e.what();
    }
}

// --- Lights --------------------------------------------------------------------------------------

GltfFile punctualFile(const json& lights) {
    GltfFile file;
    file.node({{"mesh", file.quad({0, 0, 0}, {1, 0, 0}, {0, 0, -1})}});
    file.root["extensions"]["KHR_lights_punctual"]["lights"] = lights;
    for (std::size_t i = 0; i < lights.size(); ++i) {
        // A quarter turn about X: -Z becomes -Y.
        file.node({{"name", "lamp " + std::to_string(i)},
                   {"translation", {static_cast<double>(i), 3, 0}},
                   {"rotation", {-std::sqrt(0.5), 0, 0, std::sqrt(0.5)}},
                   {"extensions", {{"KHR_lights_punctual", {{"light", i}}}}}});
    }
    return file;
}

TEST(SceneGltfFeatures, TheMostIntensePointOrSpotIsAPointLight) {
    const TempFolder folder;
    const auto scene =
        load(folder, punctualFile(json::array({{{"type", "directional"}, {"intensity", 100}},
                                               {{"type", "point"}, {"intensity", 1}},
                                               {{"type", "spot"},
                                                {"spot", json::object()},
                                                {"intensity", 4},
                                                {"color", {0.1, 0.5, 0.2}}}})));
    const AreaLight light = scene->frame(0).light;
    EXPECT_TRUE(light.isPoint());
    expectNear(light.centre + scene->origin, {2, 3, 0}, 1e-9);  // 4 x 0.5 beats 1
    expectNear(light.normal(), {0, -1, 0}, 1e-9);
    EXPECT_NE(scene->chosen[0].find("'lamp 2', the spot light"), std::string::npos);
}

TEST(SceneGltfFeatures, ADirectionalLightStandsFarAway) {
    const TempFolder folder;
    const auto scene = load(folder, punctualFile(json::array({{{"type", "directional"}}})));
    const AreaLight light = scene->frame(0).light;
    EXPECT_TRUE(light.isPoint());
    expectNear(light.centre, {0, 100 * std::sqrt(2.0), 0}, 1e-6);
    expectNear(light.normal(), {0, -1, 0}, 1e-9);
}

TEST(SceneGltfFeatures, AnEmissiveRectangleWinsOverPunctualLights) {
    GltfFile file = lampFile();
    file.root["extensions"]["KHR_lights_punctual"]["lights"] = json::array({{{"type", "point"}}});
    file.root["nodes"][0]["extensions"] = {{"KHR_lights_punctual", {{"light", 0}}}};
    const TempFolder folder;
    EXPECT_FALSE(load(folder, file)->frame(0).light.isPoint());
}

TEST(SceneGltfFeatures, EmissiveStrengthCountsInTheFlux) {
    GltfFile file = lampFile();
    file.add("materials",
             {{"emissiveFactor", {1, 1, 1}},
              {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", 50}}}}}});
    file.node({{"mesh", file.quad({0, 2, 0}, {0.1f, 0, 0}, {0, 0, 0.1f}, 1)}});
    const TempFolder folder;
    EXPECT_NEAR(load(folder, file)->frame(0).light.area(), 0.04, 1e-7);
}

}  // namespace
}  // namespace penumbra::testing
