#include <cmath>
#include <functional>
#include <limits>

#include "tests/core/scene_files.hpp"

namespace penumbra::testing {
namespace {

// Positions are floats relative to the scene's centre: a few units in the last place of 1.
constexpr double kFloatTolerance = 1e-6;

// --- Transforms ----------------------------------------------------------------------------------

TEST(SceneGltf, ChildIsPlacedByParentAndItself) {
    GltfFile file;
    const int child = file.add("nodes", {{"mesh", file.triangle()}, {"scale", {2, 3, 1}}});
    // A quarter turn about Z: x -> y, y -> -x.
    file.node({{"children", {child}},
               {"translation", {10, 0, 0}},
               {"rotation", {0, 0, std::sqrt(0.5), std::sqrt(0.5)}}});
    const TempFolder folder;
    const auto scene = load(folder, file);
    const SceneFrame frame = scene->frame(0);
    expectNear(worldCorner(*scene, *frame.geometry, 0), {10, 0, 0}, kFloatTolerance);
    expectNear(worldCorner(*scene, *frame.geometry, 1), {10, 2, 0}, kFloatTolerance);
    expectNear(worldCorner(*scene, *frame.geometry, 2), {7, 0, 0}, kFloatTolerance);
}

TEST(SceneGltf, MatrixIsColumnMajor) {
    GltfFile file;
    file.node(
        {{"mesh", file.triangle()}, {"matrix", {0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 5, 6, 7, 1}}});
    const TempFolder folder;
    const auto scene = load(folder, file);
    const auto geometry = scene->frame(0).geometry;
    expectNear(worldCorner(*scene, *geometry, 1), {5, 7, 7}, kFloatTolerance);
    expectNear(worldCorner(*scene, *geometry, 2), {5, 6, 8}, kFloatTolerance);
}

TEST(SceneGltf, NormalsGoWithTheInverseTranspose) {
    GltfFile file;
    const glm::vec3 n = glm::normalize(glm::vec3(1, 1, 0));  // of the plane x + y = 1
    const int position = file.vec3s({{1, 0, 0}, {0, 1, 0}, {0, 1, 1}});
    const int normal = file.vec3s({n, n, n});
    file.node({{"mesh", file.mesh({{"attributes", {{"POSITION", position}, {"NORMAL", normal}}}})},
               {"scale", {2, 1, 1}}});
    const TempFolder folder;
    const auto geometry = load(folder, file)->frame(0).geometry;
    // The scaled plane is x / 2 + y = 1.
    expectNear(geometry->normals[0], glm::normalize(glm::dvec3(1, 2, 0)), kFloatTolerance);
}

TEST(SceneGltf, MirroringKeepsTheFront) {
    GltfFile file;
    const int position = file.vec3s({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
    const int normal = file.vec3s({{0, 0, 1}, {0, 0, 1}, {0, 0, 1}});
    const int mesh = file.mesh({{"attributes", {{"POSITION", position}, {"NORMAL", normal}}}});
    file.node({{"mesh", mesh}, {"scale", {-1, 1, 1}}});
    const TempFolder folder;
    const auto geometry = load(folder, file)->frame(0).geometry;
    expectNear(geometry->normals[0], {0, 0, 1}, kFloatTolerance);
    expectNear(windingNormal(*geometry, 0), {0, 0, 1}, kFloatTolerance);
}

TEST(SceneGltf, FarFromTheOriginPrecisionIsKept) {
    const auto geometryAt = [](double offset) {
        GltfFile file;
        const int mesh = file.quad({0.1f, 0, 0}, {0.7f, 0, 0}, {0, 0.3f, 0.1f});
        file.node({{"mesh", mesh}, {"translation", {offset, -offset, offset}}});
        const TempFolder folder;
        return load(folder, file)->frame(0).geometry;
    };
    const auto near = geometryAt(0.0), far = geometryAt(1e6);
    ASSERT_EQ(near->positions.size(), far->positions.size());
    for (std::size_t i = 0; i < near->positions.size(); ++i) {
        // 1e6 + x is rounded to 1e-10 in double; as floats those offsets would lose 0.03.
        expectNear(near->positions[i], far->positions[i], 1e-7);
    }
}

TEST(SceneGltf, OneMeshMayBePlacedTwice) {
    GltfFile file;
    const int mesh = file.triangle();
    file.node({{"mesh", mesh}, {"name", "a"}});
    file.node({{"mesh", mesh}, {"name", "b"}, {"translation", {0, 0, 2}}});
    const TempFolder folder;
    const auto scene = load(folder, file);
    const auto geometry = scene->frame(0).geometry;
    ASSERT_GE(geometry->parts.size(), 2u);
    EXPECT_EQ(geometry->parts[0].name, "a");
    EXPECT_EQ(geometry->parts[1].name, "b");
    EXPECT_EQ(geometry->partOf(1), 1u);
    expectNear(worldCorner(*scene, *geometry, 3), {0, 0, 2}, kFloatTolerance);
}

TEST(SceneGltf, WithoutScenesAllRootsAreRead) {
    GltfFile file = triangleFile();
    file.root.erase("scene");
    file.root.erase("scenes");
    const TempFolder folder;
    EXPECT_GE(load(folder, file)->frame(0).geometry->triangleCount(), 1u);
}

// --- Meshes --------------------------------------------------------------------------------------

TEST(SceneGltf, EveryIndexTypeGivesTheSameTriangles) {
    const std::vector<glm::vec3> corners = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    const auto positionsWith = [&](const std::function<int(GltfFile&)>& indices) {
        GltfFile file;
        json primitive = {{"attributes", {{"POSITION", file.vec3s(corners)}}}};
        primitive["indices"] = indices(file);
        file.node({{"mesh", file.mesh(primitive)}});
        const TempFolder folder;
        const auto scene = load(folder, file);
        const auto geometry = scene->frame(0).geometry;
        std::vector<glm::dvec3> out;
        for (std::size_t i = 0; i < 6; ++i) out.push_back(worldCorner(*scene, *geometry, i));
        return out;
    };
    const auto u8 = positionsWith([](GltfFile& f) {
        return f.accessor<std::uint8_t>({0, 1, 2, 0, 2, 3}, GltfFile::kU8, "SCALAR", 6);
    });
    const auto u16 = positionsWith([](GltfFile& f) { return f.u16s({0, 1, 2, 0, 2, 3}); });
    const auto u32 = positionsWith([](GltfFile& f) {
        return f.accessor<std::uint32_t>({0, 1, 2, 0, 2, 3}, GltfFile::kU32, "SCALAR", 6);
    });
    EXPECT_EQ(u8, u16);
    EXPECT_EQ(u8, u32);
    expectNear(u8[2], {1, 1, 0}, kFloatTolerance);
    expectNear(u8[5], {0, 1, 0}, kFloatTolerance);
}

TEST(SceneGltf, InterleavedAttributesFollowTheirStride) {
    GltfFile file;
    const std::vector<float> interleaved = {0, 0, 0, 9, 9, 9, 1, 0, 0, 9, 9, 9, 0, 1, 0, 9, 9, 9};
    const int position = file.accessor(interleaved, GltfFile::kFloat, "VEC3", 3);
    file.root["bufferViews"][0]["byteStride"] = 24;
    file.node({{"mesh", file.mesh({{"attributes", {{"POSITION", position}}}})}});
    const TempFolder folder;
    const auto scene = load(folder, file);
    expectNear(worldCorner(*scene, *scene->frame(0).geometry, 2), {0, 1, 0}, kFloatTolerance);
}

TEST(SceneGltf, AbsentOrBrokenNormalsBecomeFlat) {
    for (const bool broken : {false, true}) {
        GltfFile file;
        json attributes = {{"POSITION", file.vec3s({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 1}})}};
        if (broken) {
            const float nan = std::numeric_limits<float>::quiet_NaN();
            attributes["NORMAL"] = file.vec3s({{0, 0, 1}, {0, 0, 0}, {nan, 0, 1}, {0, 0, 1}});
        }
        const int indices = file.u16s({0, 1, 2, 0, 2, 3});
        file.node({{"mesh", file.mesh({{"attributes", attributes}, {"indices", indices}})}});
        const TempFolder folder;
        const auto geometry = load(folder, file)->frame(0).geometry;
        for (std::size_t i = 0; i < 6; ++i) {
            expectNear(geometry->normals[geometry->indices[i]], windingNormal(*geometry, i / 3),
                       kFloatTolerance);
        }
    }
}

TEST(SceneGltf, ZeroAreaTrianglesAreDroppedAndCounted) {
    GltfFile file;
    const int position = file.vec3s({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 0, 0}, {7, 7, 7}});
    const int indices = file.u16s({0, 1, 2, 0, 0, 2, 0, 1, 3});  // good, repeated, collinear
    file.node(
        {{"mesh", file.mesh({{"attributes", {{"POSITION", position}}}, {"indices", indices}})}});
    const TempFolder folder;
    const auto scene = load(folder, file);
    EXPECT_EQ(scene->frame(0).geometry->parts[0].indexCount, 3u);
    ASSERT_FALSE(scene->chosen.empty());
    EXPECT_EQ(scene->chosen[0], "2 zero-area triangles dropped");
    // Neither the dropped triangles' corners nor the unused vertex count into the bounds.
    expectNear(scene->origin, {0.5, 0.5, 0}, kFloatTolerance);
}

// --- Materials -----------------------------------------------------------------------------------

TEST(SceneGltf, MaskedTextureIsSampledThroughItsOwnCoordinates) {
    GltfFile file;
    file.add("images", {{"uri", kRgbaPng}});
    file.add("samplers", {{"magFilter", 9728}, {"wrapS", 33071}, {"wrapT", 33648}});
    file.add("textures", {{"source", 0}, {"sampler", 0}});
    file.add("materials", {{"alphaMode", "MASK"},
                           {"alphaCutoff", 0.4},
                           {"pbrMetallicRoughness",
                            {{"baseColorFactor", {1, 0.5, 1, 0.5}},
                             {"baseColorTexture", {{"index", 0}, {"texCoord", 1}}}}}});
    const int position = file.vec3s({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
    const int uv =
        file.accessor<std::uint16_t>({0, 0, 65535, 0, 0, 65535}, GltfFile::kU16, "VEC2", 3, true);
    file.node({{"mesh", file.mesh({{"attributes", {{"POSITION", position}, {"TEXCOORD_1", uv}}},
                                   {"material", 0}})}});
    const TempFolder folder;
    const auto scene = load(folder, file);
    const Material& material = scene->materials[0];
    EXPECT_TRUE(material.masked);
    EXPECT_FLOAT_EQ(material.alphaCutoff, 0.4f);
    ASSERT_EQ(scene->images.size(), 1u);
    const TextureImage& image = scene->images[0];
    EXPECT_EQ(image.wrapS, Wrap::clampToEdge);
    EXPECT_EQ(image.wrapT, Wrap::mirroredRepeat);
    EXPECT_FALSE(image.linear);
    const std::vector<std::uint8_t> texels = {255, 0, 0,   255, 0,   255, 0,   128,
                                              0,   0, 255, 0,   255, 255, 255, 64};
    EXPECT_EQ(image.rgba, texels);  // not multiplied by alpha
    const glm::vec4 green = baseColorAt(material, scene->images, {0.75f, 0.25f});
    EXPECT_FLOAT_EQ(green.g, 0.5f);
    EXPECT_FLOAT_EQ(green.a, 0.5f * 128 / 255);
    const auto geometry = scene->frame(0).geometry;
    EXPECT_EQ(geometry->uvs[geometry->indices[1]], glm::vec2(1, 0));
}

TEST(SceneGltf, BlendIsOpaqueAndSaid) {
    GltfFile file;
    file.add("materials", {{"alphaMode", "BLEND"}, {"name", "glass"}});
    file.node({{"mesh", file.quad({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0)}});
    const TempFolder folder;
    const auto scene = load(folder, file);
    EXPECT_FALSE(scene->materials[0].masked);
    EXPECT_NE(scene->chosen[0].find("'glass'"), std::string::npos);
}

TEST(SceneGltf, PrimitiveWithoutMaterialIsOpaqueWhite) {
    const TempFolder folder;
    const auto scene = load(folder, triangleFile());
    const Material& material = scene->materials[scene->frame(0).geometry->parts[0].material];
    EXPECT_EQ(material.baseColor, glm::vec4(1.0f));
    EXPECT_FALSE(material.masked);
}

// --- The light -----------------------------------------------------------------------------------

TEST(SceneGltf, EmissiveRectangleIsTheLightAndNoSurface) {
    const TempFolder folder;
    const auto scene = load(folder, lampFile());
    const SceneFrame frame = scene->frame(0);
    EXPECT_EQ(frame.geometry->triangleCount(), 2u);
    expectNear(scene->origin, {0, 0, 0}, kFloatTolerance);
    expectNear(frame.light.centre, {0, 3, 0}, kFloatTolerance);
    expectNear(frame.light.normal(), {0, -1, 0}, kFloatTolerance);
    EXPECT_NEAR(frame.light.area(), 0.5, kFloatTolerance);
    EXPECT_NEAR(frame.light.halfU, 0.5, kFloatTolerance);
    EXPECT_NEAR(glm::dot(frame.light.axisU, frame.light.axisV), 0.0, 1e-12);
}

TEST(SceneGltf, MirroredRectangleStillEmitsToItsFront) {
    const TempFolder folder;
    const auto scene = load(folder, lampFile({{"scale", {-2, 1, 1}}}));
    expectNear(scene->frame(0).light.normal(), {0, -1, 0}, kFloatTolerance);
    EXPECT_NEAR(scene->frame(0).light.area(), 1.0, kFloatTolerance);
    const auto turned = load(folder, lampFile({{"scale", {1, -1, 1}}}));
    expectNear(turned->frame(0).light.normal(), {0, 1, 0}, kFloatTolerance);
}

TEST(SceneGltf, EveryOrderOfARectanglesCornersIsRecognised) {
    const std::vector<std::vector<std::uint16_t>> orders = {{0, 1, 2, 0, 2, 3},
                                                            {1, 2, 0, 2, 3, 0},
                                                            {2, 0, 1, 3, 0, 2},
                                                            {0, 1, 3, 1, 2, 3},
                                                            {3, 0, 1, 2, 3, 1}};
    for (const auto& order : orders) {
        GltfFile file = lampFile();
        const int indices = file.u16s(order);
        file.root["meshes"][1]["primitives"][0]["indices"] = indices;
        const TempFolder folder;
        const SceneFrame frame = load(folder, file)->frame(0);
        EXPECT_NEAR(frame.light.area(), 0.5, kFloatTolerance);
        expectNear(frame.light.normal(), {0, -1, 0}, kFloatTolerance);
        EXPECT_EQ(frame.geometry->triangleCount(), 2u);
    }
}

TEST(SceneGltf, GreatestFluxIsTheLightAndTheRestIsSaid) {
    GltfFile file = lampFile();
    file.node({{"mesh", file.quad({0, 0, 0}, {0.1f, 0, 0}, {0, 0, 0.1f}, 0)},
               {"name", "small lamp"},
               {"translation", {1, 2, 0}}});
    const TempFolder folder;
    const auto scene = load(folder, file);
    EXPECT_NEAR(scene->frame(0).light.area(), 0.5, kFloatTolerance);
    EXPECT_EQ(scene->frame(0).geometry->triangleCount(), 4u);
    EXPECT_NE(scene->chosen[0].find("'small lamp'"), std::string::npos) << scene->chosen[0];
}

TEST(SceneGltf, EmissiveShapesThatAreNoRectangleStaySurfaces) {
    GltfFile file = lampFile();
    file.node({{"mesh", file.quad({0, 0, 0}, {1, 0, 0}, {0.5f, 0, 1}, 0)}});  // a parallelogram
    file.root["nodes"].erase(1);                                              // the lamp
    file.root["scenes"][0]["nodes"] = {0, 1};
    const TempFolder folder;
    const auto scene = load(folder, file);
    EXPECT_GE(scene->frame(0).geometry->triangleCount(), 4u);
    EXPECT_NE(scene->chosen[0].find("not one rectangle"), std::string::npos) << scene->chosen[0];
}

// --- Cameras -------------------------------------------------------------------------------------

TEST(SceneGltf, FirstCameraOfTheHierarchyIsUsed) {
    GltfFile file = lampFile();
    file.add("cameras",
             {{"type", "orthographic"},
              {"orthographic", {{"xmag", 3}, {"ymag", 2}, {"znear", 0.1}, {"zfar", 9}}}});
    file.add("cameras",
             {{"type", "perspective"}, {"perspective", {{"yfov", 0.9}, {"znear", 0.25}}}});
    file.add("nodes", {{"camera", 0}});  // not part of the scene
    const int child = file.add("nodes", {{"camera", 1}, {"translation", {0, 0, 1}}});
    // A quarter turn about Y: the view along -Z becomes one along -X.
    file.node({{"children", {child}},
               {"translation", {5, 1, 0}},
               {"scale", {3, 3, 3}},
               {"rotation", {0, std::sqrt(0.5), 0, std::sqrt(0.5)}}});
    file.node({{"camera", 0}});
    const TempFolder folder;
    const Camera camera = load(folder, file)->frame(0).camera;
    EXPECT_EQ(camera.kind, Camera::Kind::perspective);
    EXPECT_DOUBLE_EQ(camera.fovYRad, 0.9);
    EXPECT_DOUBLE_EQ(camera.nearM, 0.25);
    EXPECT_GT(camera.farM, 1e20);
    expectNear(camera.position, {8, 1, 0}, 1e-12);
    expectNear(camera.back, {1, 0, 0}, 1e-12);
    expectNear(camera.right, {0, 0, -1}, 1e-12);
    expectNear(camera.up, {0, 1, 0}, 1e-12);
}

TEST(SceneGltf, OrthographicCameraIsRead) {
    GltfFile file = lampFile();
    file.add("cameras",
             {{"type", "orthographic"},
              {"orthographic", {{"xmag", 3}, {"ymag", 2}, {"znear", 0.1}, {"zfar", 9}}}});
    file.node({{"camera", 0}});
    const TempFolder folder;
    const Camera camera = load(folder, file)->frame(0).camera;
    EXPECT_EQ(camera.kind, Camera::Kind::orthographic);
    EXPECT_DOUBLE_EQ(camera.magY, 2.0);
    EXPECT_DOUBLE_EQ(camera.farM, 9.0);
}

// --- What is placed ------------------------------------------------------------------------------

/// A closed cube with half side 1 around `centre`, its faces outwards.
GltfFile cubeFile(glm::vec3 centre) {
    GltfFile file;
    for (int axis = 0; axis < 3; ++axis) {
        for (const float side : {-1.0f, 1.0f}) {
            glm::vec3 normal(0), u(0), v(0);
            normal[axis] = side;
            u[(axis + 1) % 3] = side;
            v[(axis + 2) % 3] = 1;
            file.node({{"mesh", file.quad(centre + normal, u, v)}});
        }
    }
    return file;
}

TEST(SceneGltf, BareAssetGetsLightCameraAndGround) {
    const TempFolder folder;
    const auto scene = load(folder, cubeFile({4, 5, 6}));
    const SceneFrame frame = scene->frame(0);
    const double radius = std::sqrt(3.0);
    expectNear(scene->origin, {4, 5, 6}, 1e-6);
    expectNear(frame.light.centre, 3 * radius * glm::normalize(glm::dvec3(0.45, 1, 0.35)), 1e-6);
    expectNear(frame.light.normal(), -glm::normalize(frame.light.centre), 1e-9);
    EXPECT_NEAR(2 * frame.light.halfU, 0.5 * radius, 1e-6);
    EXPECT_NEAR(2 * frame.light.halfV, 0.5 * radius, 1e-6);
    // The bounding sphere fits into the view.
    const double distance = glm::length(frame.camera.position);
    EXPECT_GT(std::sin(0.5 * frame.camera.fovYRad), radius / distance);
    expectNear(-frame.camera.back, -glm::normalize(glm::dvec3(0.6, 0.55, 1)), 1e-9);

    ASSERT_EQ(frame.geometry->triangleCount(), 14u);
    const Part& ground = frame.geometry->parts.back();
    EXPECT_EQ(ground.name, "ground");
    EXPECT_FLOAT_EQ(scene->materials[ground.material].baseColor.r, 0.8f);
    expectNear(windingNormal(*frame.geometry, 12), {0, 1, 0}, kFloatTolerance);
    for (std::uint32_t i = 0; i < ground.vertexCount; ++i) {
        const glm::dvec3 corner(frame.geometry->positions[ground.firstVertex + i]);
        EXPECT_NEAR(corner.y, -1 - 1e-3 * radius, 1e-6);
        const glm::dvec3 ray = glm::normalize(corner - frame.light.centre);
        EXPECT_GE(glm::dot(ray, frame.light.normal()), 0.5 - 1e-6);  // cos 60 degrees
        EXPECT_GT(std::abs(corner.x), 1.9);                          // larger than the cube
    }
    EXPECT_EQ(scene->chosen.size(), 3u);
    EXPECT_NEAR(scene->radiusM, boundsOf(frame.geometry->positions).radius(), 1e-9);
}

TEST(SceneGltf, NoGroundBelowAnAssetThatHasAFloor) {
    GltfFile file = cubeFile({0, 1, 0});
    file.node({{"mesh", file.quad({0, 0, 0}, {3, 0, 0}, {0, 0, -3})}});
    const TempFolder folder;
    EXPECT_EQ(load(folder, file)->frame(0).geometry->triangleCount(), 14u);
}

TEST(SceneGltf, NoGroundWhereTheAssetHasItsOwnLightOrCamera) {
    GltfFile lit = cubeFile({0, 0, 0});
    lit.add("materials", {{"emissiveFactor", {1, 1, 1}}});
    lit.node({{"mesh", lit.quad({0, 4, 0}, {1, 0, 0}, {0, 0, 1}, 0)}});
    GltfFile seen = cubeFile({0, 0, 0});
    seen.add("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}});
    seen.node({{"camera", 0}, {"translation", {0, 0, 5}}});
    const TempFolder folder;
    EXPECT_EQ(load(folder, lit)->frame(0).geometry->triangleCount(), 12u);
    EXPECT_EQ(load(folder, seen)->frame(0).geometry->triangleCount(), 12u);
}

TEST(SceneGltf, ScaleChangesNothingButTheScale) {
    const auto lightOf = [](double scale) {
        GltfFile file = cubeFile({0, 0, 0});
        for (json& node : file.root["nodes"]) node["scale"] = {scale, scale, scale};
        const TempFolder folder;
        return load(folder, file)->frame(0).light;
    };
    for (const double scale : {1e-3, 1e3}) {
        expectNear(lightOf(scale).centre, scale * lightOf(1).centre, 1e-9 * scale);
    }
}

TEST(SceneGltf, GlbIsReadLikeGltf) {
    const TempFolder folder;
    const GltfFile file = lampFile();
    const auto text = load(folder, file);
    const auto binary =
        loadScene(folder.write("binary.glb", file.glb()).string(), folder.library());
    EXPECT_EQ(text->frame(0).geometry->positions, binary->frame(0).geometry->positions);
    EXPECT_EQ(text->frame(0).light, binary->frame(0).light);
    EXPECT_EQ(binary->id, "binary");
}

TEST(SceneGltf, ExternalFilesAreReadFromTheAssetsFolder) {
    GltfFile file = triangleFile();
    const TempFolder folder;
    folder.write("my data.bin", file.bytes);
    file.root["buffers"] =
        json::array({{{"byteLength", file.bytes.size()}, {"uri", "my%20data.bin"}}});
    EXPECT_GE(load(folder, file)->frame(0).geometry->triangleCount(), 1u);
}

}  // namespace
}  // namespace penumbra::testing
