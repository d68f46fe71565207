// Assets that nobody here made, by the real program: they render, or one line says where in the
// file what is wrong, and nothing is written.
#include "tests/core/scene_samples.hpp"
#include "tests/support/run_files.hpp"

namespace penumbra {
namespace {

using Texts = std::vector<std::string>;

class AssetFiles : public ::testing::Test {
  protected:
    std::string path(const std::string& name) const { return (folder.path() / name).string(); }

    test::Finished compare(const std::string& scene, const Texts& more = {}) const {
        Texts all = {"compare",     "--scene",        scene, "--method", "hard",      "--size",
                     "32x32",       "--repeats",      "1",   "--out",    path("run"), "--cache",
                     path("cache"), "--reference-se", "0.05"};
        all.insert(all.end(), more.begin(), more.end());
        return test::penumbra(all);
    }
    void expectRefused(const test::Finished& done, const std::string& said) const {
        EXPECT_EQ(done.exitCode, 2) << done.err;
        EXPECT_EQ(test::lines(done.err).size(), 1u) << done.err;
        EXPECT_NE(done.err.find(said), std::string::npos) << done.err;
        EXPECT_FALSE(std::filesystem::exists(path("run")));
    }

    testing::TempFolder folder;
};

TEST_F(AssetFiles, ASampleOfAssimpsFilesRendersOrIsRefused) {
    const std::string root = "/usr/share/assimp/models/glTF2/";
    if (!std::filesystem::exists(root)) GTEST_SKIP() << "install Debian package assimp-testmodels";
    expectRefused(compare(root + "draco/2CylinderEngine.gltf"),
                  "2CylinderEngine.gltf: /extensionsRequired/0: KHR_draco_mesh_compression");
    expectRefused(compare(root + "RecursiveNodes/RecursiveNodes.gltf"),
                  "RecursiveNodes.gltf: /nodes/0: is part of a cycle");
    expectRefused(compare(root + "MissingBin/BoxTextured.gltf"), "BoxTextured.gltf: /buffers/0");
    const test::Finished skin = compare(root + "simple_skin/simple_skin.gltf");
    EXPECT_EQ(skin.exitCode, 0) << skin.err;
}

/// One picture of every file that loads, in one process: what takes the time is its start.
TEST_F(AssetFiles, EveryFileOfAssimpThatLoadsRenders) {
    const std::filesystem::path root = "/usr/share/assimp/models/glTF2";
    if (!std::filesystem::exists(root)) GTEST_SKIP() << "install Debian package assimp-testmodels";
    Texts arguments = {
        "compare", "--method",  "hard",    "--size",      "24x24",          "--repeats", "1",
        "--out",   path("run"), "--cache", path("cache"), "--reference-se", "0.3",       "--scene"};
    std::map<std::string, std::filesystem::path> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root)) {
        const std::filesystem::path file = entry.path();
        if (file.extension() != ".gltf" && file.extension() != ".glb") continue;
        if (!testing::failureOf(file, folder.library()).empty()) continue;
        // A script gives each an id of its own: several files have one name.
        const std::string id = "asset_" + std::to_string(files.size());
        const std::string script =
            "shows = 'an asset'\nasset = 'package:" + file.string() + "'\nground = true\n";
        arguments.push_back(folder.write(id + ".toml", script).string());
        files[id] = file;
    }
    ASSERT_FALSE(files.empty());
    const test::Finished done = test::penumbra(arguments);
    ASSERT_EQ(done.exitCode, 0) << done.err;
    for (const Row& row : readCsv(folder.path() / "run/results.csv")) {
        const std::filesystem::path& file = files.at(row.scene);
        EXPECT_EQ(row.status, "ok") << file << " " << row.message;
        EXPECT_EQ(row.metrics.nonfinite, 0u) << file;
        EXPECT_EQ(row.metrics.outOfRange, 0u) << file;
        // The camera that is placed where an asset has none sees it and its ground.
        EXPECT_GT(row.metrics.scoredPixels, 24u * 24u / 20u) << file;
        EXPECT_TRUE(row.metrics.rmseLit) << file << " has no lit pixel";
        files.erase(row.scene);
    }
    EXPECT_TRUE(files.empty()) << files.begin()->second << " has no row";
}

TEST_F(AssetFiles, SceneAndCameraAreChosenAndRecorded) {
    const std::string file = folder.write("a.glb", testing::deformingFile().glb()).string();
    expectRefused(compare(file, {"--camera", "nope"}), "the cameras are 0 'front', 1 'left'");
    expectRefused(compare(file, {"--asset-scene", "7"}), "the scenes are 0 'day', 1 'night'");
    const test::Finished done = compare(file, {"--camera", "left"});
    EXPECT_EQ(done.exitCode, 0) << done.err;
    // A resumed run with another camera would mix rows of two views.
    const test::Finished other = compare(file, {"--camera", "front", "--resume"});
    EXPECT_EQ(other.exitCode, 2);
    EXPECT_NE(other.err.find("--camera 'left'"), std::string::npos) << other.err;
}

TEST_F(AssetFiles, MemoryIsBoundedByTheOption) {
    const std::string file = folder.write("a.glb", testing::deformingFile().glb()).string();
    expectRefused(compare(file, {"--max-memory", "4KiB"}), "--max-memory is 0.003906 MiB");
}

}  // namespace
}  // namespace penumbra
