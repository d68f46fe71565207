#include "harness/run/suite.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/core/scene_files.hpp"

namespace penumbra {
namespace {

using penumbra::testing::TempFolder;
using Texts = std::vector<std::string>;

/// A library of the scenes `near` and `far` and whatever suites a test writes.
class SuiteFiles : public ::testing::Test {
  protected:
    SuiteFiles() {
        std::filesystem::create_directories(folder.path() / "suites");
        folder.write("near.toml", "");
        folder.write("far.toml", "");
    }
    std::string errorOf(const std::string& content) const {
        folder.write("suites/s.toml", content);
        try {
            loadSuite("s", folder.library());
        } catch (const InputError& e) {
            return e.what();
        }
        return "";
    }
    std::string at(int line) const {
        return (folder.path() / "suites/s.toml").string() + ":" + std::to_string(line) + ": ";
    }
    TempFolder folder;
};

TEST_F(SuiteFiles, IsReadInItsOrder) {
    folder.write("suites/s.toml", "shows = \"both\"\nscenes = [\"near\", \"far\"]\n");
    const Suite suite = loadSuite("s", folder.library());
    EXPECT_EQ(suite.id, "s");
    EXPECT_EQ(suite.shows, "both");
    EXPECT_EQ(suite.scenes, (Texts{"near", "far"}));
}

TEST_F(SuiteFiles, IdsAreSortedAndOnlyScripts) {
    EXPECT_EQ(suiteIds(folder.library()), Texts{});
    for (const char* name : {"b.toml", "a.toml", "notes.txt"})
        folder.write(std::string("suites/") + name, "");
    EXPECT_EQ(suiteIds(folder.library()), (Texts{"a", "b"}));
}

TEST_F(SuiteFiles, AnUnknownIdListsTheKnownOnes) {
    folder.write("suites/b.toml", "");
    folder.write("suites/a.toml", "");
    try {
        loadSuite("c", folder.library());
        FAIL();
    } catch (const InputError& e) {
        EXPECT_STREQ(e.what(), "unknown suite 'c'; the suites are a, b");
    }
}

TEST_F(SuiteFiles, ErrorsNameTheFileAndTheLine) {
    EXPECT_EQ(errorOf("shows = \"x\"\nscenes = [\"near\"]\nscene = 1\n"),
              at(3) + "unknown key 'scene'; valid keys are shows, scenes");
    EXPECT_TRUE(errorOf("shows = \"x\"\nscenes = [\"near\",,]\n").starts_with(at(2)));
    const std::string list = "'scenes' must be a list of scene ids";
    EXPECT_EQ(errorOf("shows = \"x\"\n"), at(1) + list);
    EXPECT_EQ(errorOf("\nscenes = []\n"), at(2) + list);
    EXPECT_EQ(errorOf("\n\nscenes = \"near\"\n"), at(3) + list);
    EXPECT_EQ(errorOf("scenes = [\n  \"near\",\n  7,\n]\n"), at(3) + list);
    EXPECT_EQ(errorOf("scenes = [\"near\"]\nshows = 1\n"), at(2) + "'shows' must be a string");
    EXPECT_EQ(errorOf("scenes = [\n  \"near\",\n  \"nigh\",\n]\n"),
              at(3) + "unknown scene 'nigh'; scenes are far, near");
}

TEST(StandardSuite, HoldsTheScenesItPromises) {
    const Suite suite = loadSuite("standard", SceneLibrary::standard());
    EXPECT_FALSE(suite.shows.empty());
    for (const char* id : {"parallel_rectangle", "half_plane", "two_layers", "sphere_plate",
                           "foliage", "foliage_masked", "butterfly", "antennas", "clouds",
                           "gathering", "fence", "receding_receiver", "contact", "layers", "arcade",
                           "spinner", "teapot", "engine", "bunny"})
        EXPECT_EQ(std::ranges::count(suite.scenes, id), 1) << id;
}

}  // namespace
}  // namespace penumbra
