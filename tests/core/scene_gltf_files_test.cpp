#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/scene/asset.hpp"
#include "tests/core/scene_files.hpp"

/// Files that nobody here made: the glTF2 tree of Debian package assimp-testmodels, broken ones on
/// purpose among them, and whatever lies in the folder that $PENUMBRA_GLTF_FOLDER names.
namespace penumbra::testing {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> assetsBelow(const fs::path& folder) {
    std::vector<fs::path> files;
    std::error_code error;
    for (const auto& entry : fs::recursive_directory_iterator(folder, error)) {
        const fs::path extension = entry.path().extension();
        if (extension == ".gltf" || extension == ".glb") files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    return files;
}

/// A script that shows the asset's animations from their first to their last key.
std::string scriptOver(const fs::path& asset) {
    double first = 0.0, last = 0.0;
    for (const auto& track : scene_detail::loadAsset(asset, {}).tracks) {
        first = std::min(first, track.curve.times.front());
        last = std::max(last, track.curve.times.back());
    }
    std::string times = std::to_string(first);
    constexpr int kSteps = 8;
    for (int i = 1; i <= kSteps && last > first; ++i)
        times += ", " + std::to_string(first + (last - first) * i / kSteps);
    return "shows = \"all frames\"\nasset = \"package:" + asset.string() +
           "\"\n[frames]\ntimes = [" + times + "]\n";
}

/// Loads the file with a script over its animations and evaluates every frame; the message with
/// which it was refused, else nothing.
std::string failureInFrames(const fs::path& file, const TempFolder& folder) {
    const std::string refused = failureOf(file, folder.library());
    if (!refused.empty()) return refused;
    const auto scene =
        loadScene(folder.write("all.toml", scriptOver(file)).string(), folder.library());
    for (int i = 0; i < scene->frameCount(); ++i) {
        const auto geometry = scene->frame(i).geometry;
        EXPECT_GT(geometry->triangleCount(), 0u) << file;
        const auto finite = [](const glm::vec3& p) { return std::isfinite(glm::length(p)); };
        EXPECT_TRUE(std::all_of(geometry->positions.begin(), geometry->positions.end(), finite))
            << file << " frame " << i;
        EXPECT_TRUE(std::all_of(geometry->normals.begin(), geometry->normals.end(), finite))
            << file << " frame " << i;
        EXPECT_TRUE(std::all_of(geometry->indices.begin(), geometry->indices.end(),
                                [&](auto v) { return v < geometry->positions.size(); }))
            << file << " frame " << i;
    }
    return "";
}

TEST(SceneGltfFiles, EveryFileOfAssimpLoadsOrIsRefusedInOneLine) {
    const fs::path root = "/usr/share/assimp/models/glTF2";
    const std::vector<fs::path> files = assetsBelow(root);
    if (files.empty()) GTEST_SKIP() << "install Debian package assimp-testmodels";
    const TempFolder folder;
    int loaded = 0;
    for (const fs::path& file : files) {
        const std::string message = failureInFrames(file, folder);
        if (message.empty())
            ++loaded;
        else
            EXPECT_TRUE(message.starts_with(file.string())) << message;
    }
    EXPECT_GT(loaded, 0);
}

struct Named {
    const char* file;
    const char* expected;  ///< part of the message; empty: it loads
};

TEST(SceneGltfFiles, WhatIsKnownOfAssimpsFiles) {
    const fs::path root = "/usr/share/assimp/models/glTF2";
    if (!fs::exists(root)) GTEST_SKIP() << "install Debian package assimp-testmodels";
    const TempFolder folder;
    for (const Named& each :
         {Named{"simple_skin/simple_skin.gltf", ""},
          Named{"glTF-Sample-Models/AnimatedMorphCube-glTF/AnimatedMorphCube.gltf", ""},
          Named{"textureTransform/TextureTransformTest.gltf", ""},
          Named{"BoxTextured-glTF-pbrSpecularGlossiness/BoxTextured.gltf", ""},
          Named{"draco/2CylinderEngine.gltf", "KHR_draco_mesh_compression is not supported"},
          Named{"MissingBin/BoxTextured.gltf", "/buffers/0/uri: '"},
          Named{"RecursiveNodes/RecursiveNodes.gltf", "/nodes/"},
          Named{"IndexOutOfRange/IndexOutOfRange.gltf", "/meshes/0/primitives/0/indices: index"},
          Named{"BoxWithInfinites-glTF-Binary/BoxWithInfinites.glb", "is infinite"},
          Named{"SchemaFailures/sceneWrongType.gltf", "/scene: must be a whole number"},
          Named{"wrongTypes/badArray.gltf", "must be"},
          Named{"wrongTypes/badUint.gltf", "must be"}}) {
        const std::string message = failureInFrames(root / each.file, folder);
        if (*each.expected == '\0')
            EXPECT_EQ(message, "") << each.file;
        else
            EXPECT_NE(message.find(each.expected), std::string::npos)
                << each.file << ": " << message;
    }
}

TEST(SceneGltfFiles, EveryFileOfTheGivenFolderLoadsOrIsRefusedInOneLine) {
    const char* const root = std::getenv("PENUMBRA_GLTF_FOLDER");
    if (!root || !*root) GTEST_SKIP() << "set PENUMBRA_GLTF_FOLDER to a folder of glTF files";
    const std::vector<fs::path> files = assetsBelow(root);
    ASSERT_FALSE(files.empty()) << root;
    const TempFolder folder;
    for (const fs::path& file : files) {
        const std::string message = failureInFrames(file, folder);
        EXPECT_TRUE(message.empty() || message.starts_with(file.string())) << message;
    }
}

}  // namespace
}  // namespace penumbra::testing
