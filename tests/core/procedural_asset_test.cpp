#include <gtest/gtest.h>

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <algorithm>

#include "core/frame/casters.hpp"
#include "tests/core/scene_files.hpp"

namespace penumbra::testing {
namespace {

std::filesystem::path landscape(const TempFolder& folder, const std::string& triangles) {
    return folder.write("made.toml",
                        "shows = 'x'\nasset = 'procedural:landscape:" + triangles + "'\n");
}

TEST(ProceduralAsset, HasAsManyTrianglesAsAsked) {
    for (const std::size_t wanted : {10'000, 12'345, 50'000}) {
        const TempFolder folder;
        const auto scene =
            loadScene(landscape(folder, std::to_string(wanted)).string(), folder.library());
        const std::shared_ptr<const Geometry> geometry = scene->frame(0).geometry;
        // Of bodies of eight triangles, no more than one is missing.
        EXPECT_LE(geometry->triangleCount(), wanted);
        EXPECT_GT(geometry->triangleCount() + 8, wanted);
        for (const glm::vec3& p : geometry->positions) {
            const glm::dvec3 world = glm::dvec3(p) + scene->origin;
            ASSERT_LE(std::max(std::abs(world.x), std::abs(world.z)), 11.0);
            ASSERT_TRUE(world.y > -1.0 && world.y < 3.0) << world.y;
        }
    }
}

TEST(ProceduralAsset, IsOneSheetAndClosedBodiesWithTheirFrontsOutside) {
    const TempFolder folder;
    const auto scene = loadScene(landscape(folder, "20000").string(), folder.library());
    const auto geometry = scene->frame(0).geometry;
    const Casters bodies = Casters::find(*geometry);
    const std::size_t pebbles = (geometry->triangleCount() - geometry->parts[0].indexCount / 3 -
                                 100 * (geometry->parts[1].indexCount / 3)) /
                                8;
    ASSERT_EQ(bodies.thicknessM.size(), 1 + 100 + pebbles);
    EXPECT_EQ(std::ranges::count(bodies.thicknessM, 0.0), 1);
    EXPECT_EQ(std::ranges::count(bodies.insideOut, 1), 0);
    EXPECT_GT(geometry->normals[0].y, 0.5f);
}

TEST(ProceduralAsset, IsTheSameOnAnyNumberOfThreads) {
    const TempFolder folder;
    const auto path = landscape(folder, "30000");
    const auto many = loadScene(path.string(), folder.library())->frame(0).geometry;
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const auto alone = loadScene(path.string(), folder.library())->frame(0).geometry;
    EXPECT_TRUE(many->positions == alone->positions && many->normals == alone->normals &&
                many->indices == alone->indices);
}

TEST(ProceduralAsset, IsRefusedBeyondTheMemoryThatItMayHave) {
    const TempFolder folder;
    const auto path = landscape(folder, "1000000");
    LoadOptions options;
    // Its geometry alone has 500,000 vertices of 32 bytes and three million indices.
    options.maxMemoryBytes = 27'000'000;
    try {
        loadScene(path.string(), folder.library(), options);
        FAIL() << "took more than it may";
    } catch (const InputError& e) {
        EXPECT_NE(std::string(e.what()).find("--max-memory"), std::string::npos) << e.what();
    }
}

TEST(ProceduralAsset, OtherKindsAndCountsAreRefusedWithTheirPlace) {
    const TempFolder folder;
    for (const std::string text : {"", "9999", "100000001", "1e6", "-1", "20000 ", "x"}) {
        const std::string message = failureOf(landscape(folder, text), folder.library());
        EXPECT_NE(message.find("made.toml:2:9: procedural: is followed by landscape:TRIANGLES, "
                               "10000 to 100000000 of them"),
                  std::string::npos)
            << message;
    }
    const auto other = folder.write("other.toml", "shows = 'x'\nasset = 'procedural:sea:20000'\n");
    EXPECT_NE(failureOf(other, folder.library()).find("landscape:TRIANGLES"), std::string::npos);
}

}  // namespace
}  // namespace penumbra::testing
