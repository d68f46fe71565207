#include <gtest/gtest.h>

#include <cmath>

#include "harness/run/suite.hpp"
#include "tests/core/scene_files.hpp"
#include "tests/support/run_files.hpp"

namespace penumbra {
namespace {

std::size_t triangles(const SceneFrame& frame) {
    return frame.geometry->indices.size() / 3;
}

TEST(Assets, TheGeneratorWritesTheSameBytesEveryTime) {
    const std::filesystem::path program =
        std::filesystem::path(PENUMBRA_PROGRAM).parent_path() / "scenes" / "penumbra_assets";
    const testing::TempFolder folder;
    const std::string a = (folder.path() / "a").string(), b = (folder.path() / "b").string();
    for (const std::string& out : {a, b}) {
        const test::Finished done = test::Program({program.string(), out}).wait();
        ASSERT_EQ(done.exitCode, 0) << done.err;
    }
    EXPECT_GE(test::filesBelow(a).size(), 16u);
    test::expectSameFiles(a, b);
}

/// Every scene of the standard suite that is to be had here, loaded once.
class StandardScenes : public ::testing::Test {
  protected:
    static void SetUpTestSuite() {
        const SceneLibrary library = SceneLibrary::standard();
        for (const std::string& id : loadSuite("standard", library).scenes) {
            try {
                scenes[id] = loadScene(id, library);
            } catch (const AssetAbsent& e) {
                absent[id] = e.what();
            }
        }
    }
    static void TearDownTestSuite() { scenes.clear(); }

    /// Null, and the test skipped, where its package is absent.
    static std::shared_ptr<const Scene> scene(const std::string& id) {
        const auto at = scenes.find(id);
        return at == scenes.end() ? nullptr : at->second;
    }
    static void expectTriangles(const std::string& id, std::size_t lo, std::size_t hi) {
        ASSERT_TRUE(scene(id)) << id;
        const std::size_t n = triangles(scene(id)->frame(0));
        EXPECT_GE(n, lo) << id;
        EXPECT_LE(n, hi) << id;
    }

    static inline std::map<std::string, std::shared_ptr<const Scene>> scenes;
    static inline std::map<std::string, std::string> absent;
};

TEST_F(StandardScenes, OnlyPackagesMayBeAbsent) {
    for (const auto& [id, reason] : absent) {
        EXPECT_TRUE(id == "engine" || id == "bunny") << reason;
        EXPECT_NE(reason.find("install Debian package"), std::string::npos) << reason;
    }
}

TEST_F(StandardScenes, EveryFrameHasALightACameraAndGeometry) {
    for (const auto& [id, loaded] : scenes) {
        EXPECT_EQ(loaded->id, id);
        EXPECT_FALSE(loaded->shows.empty()) << id;
        EXPECT_GE(loaded->frameCount(), 1) << id;
        for (int f = 0; f < loaded->frameCount(); ++f) {
            const SceneFrame frame = loaded->frame(f);
            EXPECT_GT(triangles(frame), 0u) << id << " frame " << f;
            EXPECT_GT(frame.light.area(), 0.0) << id << " frame " << f;
            EXPECT_TRUE(std::isfinite(glm::length(frame.camera.position))) << id << " frame " << f;
        }
    }
}

// With three methods and references the suite must stay within minutes on two cores.
TEST_F(StandardScenes, FewFrames) {
    int frames = 0;
    for (const auto& [id, loaded] : scenes) frames += loaded->frameCount();
    EXPECT_LE(frames, 30);
}

// "About" is taken as within a tenth.
TEST_F(StandardScenes, TriangleCountsAreAsDescribed) {
    expectTriangles("clouds", 4'500, 5'500);
    expectTriangles("gathering", 1'890, 2'310);
    expectTriangles("arcade", 180'000, 220'000);
    expectTriangles("foliage", 4'000, 100'000);  // thousands of leaves of two triangles or more
    expectTriangles("foliage_masked", 4'000, 100'000);
    if (scene("bunny")) expectTriangles("bunny", 60'000, 80'000);
}

TEST_F(StandardScenes, WhatMovesIsWhatTheSceneIsAbout) {
    for (const auto& [id, loaded] : scenes) {
        EXPECT_EQ(loaded->movingLight, id == "fence") << id;
        EXPECT_EQ(loaded->movingCasters,
                  id == "spinner" || id == "two_layers" || id == "receding_receiver")
            << id;
        EXPECT_EQ(loaded->movingCamera, id == "arcade") << id;
        const bool moves = loaded->movingLight || loaded->movingCasters || loaded->movingCamera;
        EXPECT_EQ(loaded->frameCount() > 1, moves) << id << ": still frames would only cost time";
        for (int f = 1; f < loaded->frameCount(); ++f) {
            const SceneFrame before = loaded->frame(f - 1), now = loaded->frame(f);
            EXPECT_TRUE(before.geometry != now.geometry || before.light != now.light ||
                        before.camera != now.camera)
                << id << " frame " << f << " shows nothing new";
        }
    }
}

TEST_F(StandardScenes, OnlyTheMaskedTreeIsMasked) {
    for (const auto& [id, loaded] : scenes) {
        const bool masked = std::ranges::any_of(loaded->materials, &Material::masked);
        EXPECT_EQ(masked, id == "foliage_masked") << id;
    }
}

}  // namespace
}  // namespace penumbra
