#include <fmt/format.h>
#include <gtest/gtest.h>

#include "harness/run/csv.hpp"
#include "tests/cli/in_process.hpp"
#include "tests/core/scene_files.hpp"

namespace penumbra {
namespace {

/// Whether `text` has `part` in it; shows both where it is expected to and does not.
::testing::AssertionResult says(const std::string& text, const std::string& part) {
    if (text.find(part) != std::string::npos)
        return ::testing::AssertionSuccess() << "\"" << part << "\" is in: " << text;
    return ::testing::AssertionFailure() << "\"" << part << "\" is not in: " << text;
}

/// 9 maps over 4: a claim that costs nothing to measure and has no noise.
std::string paper(const std::string& ratio, const std::string& more = "") {
    return "citation = \"Someone 1999\"\n[[claim]]\nid = \"maps\"\nclaim = \"in words\"\n"
           "place = \"fig. 1\"\nscene = \"half_plane\"\na = "
           "\"light_sampled:samples=9;pattern=owen\"\n"
           "b = \"light_sampled:samples=4;pattern=owen\"\nmetric = \"maps\"\npaper = " +
           ratio +
           "\nexpect = \"match\"\nfactor = 1.1\nwhy = \"arithmetic\"\nfound = \"the reason\"\n" +
           more;
}

class Reproduce : public ::testing::Test {
  protected:
    test::Finished reproduce(std::vector<std::string> more) const {
        std::vector<std::string> arguments = {
            "reproduce", "--size",      "16x16", "--claims", folder.path().string(),
            "--out",     out().string()};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return test::penumbra(arguments);
    }
    std::filesystem::path out() const { return folder.path() / "out"; }
    testing::TempFolder folder;
};

TEST_F(Reproduce, MeasuresAndJudges) {
    folder.write("good.toml", paper("2.25"));
    folder.write("wrong.toml", paper("7"));
    const test::Finished done = reproduce({"--markdown"});
    EXPECT_EQ(done.exitCode, 0) << done.err;  // what does not hold is a result
    EXPECT_EQ(done.out, test::readText(out() / "claims.md"));
    EXPECT_TRUE(says(done.out, "| 2.25 (within 1.1×) | 2.25 | holds |"));
    EXPECT_TRUE(says(done.out, "| 7 (within 1.1×) | 2.25 | does not hold |"));
    EXPECT_TRUE(says(done.out, "**Found:** the reason"));
    const CsvRecords csv = splitCsv(test::readText(out() / "claims.csv"), "claims.csv");
    ASSERT_EQ(csv.complete.size(), 3U);
    EXPECT_EQ(csv.complete[1].fields[0], "good");
    EXPECT_EQ(csv.complete[2].fields[0], "wrong");
}

TEST_F(Reproduce, OnePaper) {
    folder.write("good.toml", paper("2.25"));
    folder.write("wrong.toml", paper("7"));
    const test::Finished done = reproduce({"good"});
    EXPECT_EQ(done.exitCode, 0) << done.err;
    EXPECT_TRUE(says(done.out, "1 claims: holds 1."));
    const test::Finished unknown = reproduce({"god"});
    EXPECT_EQ(unknown.exitCode, 2);
    EXPECT_EQ(unknown.err, "penumbra: unknown paper 'god'; the papers are good, wrong\n");
}

TEST_F(Reproduce, SaysWhatCouldNotRun) {
    folder.write("p.toml", paper("2.25", "frame = 5\n"));
    const test::Finished done = reproduce({});
    EXPECT_EQ(done.exitCode, 3);
    EXPECT_TRUE(says(done.out, "could not run"));
    EXPECT_TRUE(says(done.out, "scene 'half_plane' has no frame 5"));
}

TEST_F(Reproduce, RefusesABadFileBeforeAnythingIsWritten) {
    folder.write("p.toml", paper("2.25", "color = 5\n"));
    const test::Finished done = reproduce({});
    EXPECT_EQ(done.exitCode, 2);
    EXPECT_TRUE(says(done.err, "p.toml:15: unknown key 'color'"));
    EXPECT_EQ(test::lines(done.err).size(), 1U);
    EXPECT_FALSE(std::filesystem::exists(out()));
}

TEST_F(Reproduce, ScalingWritesItsTable) {
    const auto scale = [&](const std::string& axis, const std::string& method) {
        return test::penumbra({"compare", "--scaling", axis, "--method", method, "--scene",
                               "half_plane", "--size", "16x16", "--repeats", "2", "--out",
                               (out() / axis).string()});
    };
    EXPECT_EQ(scale("map_size", "hard").exitCode, 0);
    const CsvRecords csv = splitCsv(test::readText(out() / "map_size" / "scaling.csv"), "csv");
    ASSERT_EQ(csv.complete.size(), 5U);  // the header, and a quarter to twice the default of 1024
    for (const std::size_t i : {1, 2, 3, 4})
        EXPECT_EQ(csv.complete[i].fields[4], std::to_string(128 << i));
    EXPECT_TRUE(says(test::readText(out() / "map_size" / "scaling" / "half_plane.svg"),
                     fmt::format("hard {:.2f}", std::stod(csv.complete[1].fields[9]))));
    EXPECT_TRUE(std::filesystem::exists(out() / "map_size" / "scaling" / "half_plane.png"));
    EXPECT_EQ(scale("slices", "hard").exitCode, 0);
    EXPECT_FALSE(std::filesystem::exists(out() / "slices" / "scaling" / "half_plane.svg"));
    EXPECT_TRUE(says(test::readText(out() / "slices" / "summary.md"),
                     "| hard | not applicable: has no slices |"));
    const test::Finished unknown = scale("threads", "hard");
    EXPECT_EQ(unknown.exitCode, 2);
    EXPECT_TRUE(says(unknown.err, "valid are triangles, pixels, map_size, light_size, slices"));
}

}  // namespace
}  // namespace penumbra
