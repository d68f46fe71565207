// `penumbra stress`: the whole matrix, random draws, and what the command line refuses.

#include <gtest/gtest.h>

#include "tests/cli/in_process.hpp"
#include "tests/core/scene_files.hpp"

namespace penumbra {
namespace {

TEST(Stress, EveryCaseIsGreenOrExplained) {
    const test::Finished done = test::penumbra({"stress"});
    EXPECT_EQ(done.exitCode, 0) << done.out << done.err;
    EXPECT_NE(done.out.find(" 0 failed, 0 mended"), std::string::npos);
}

TEST(Stress, TwoHundredRandomDrawsRunClean) {
    const testing::TempFolder folder;
    const auto out = folder.path() / "found";
    const test::Finished done =
        test::penumbra({"stress", "--random", "200", "--seed", "1", "--out", out.string()});
    EXPECT_EQ(done.exitCode, 0) << done.out << done.err;
    EXPECT_FALSE(std::filesystem::exists(out)) << "made for failures only";
}

TEST(Stress, WritesItsMatrix) {
    const testing::TempFolder folder;
    const auto out = folder.path() / "out";
    const test::Finished done = test::penumbra(
        {"stress", "--case", "no_caster", "--method", "hard", "--out", out.string()});
    EXPECT_EQ(done.exitCode, 0) << done.err;
    EXPECT_NE(done.out.find("no_caster"), std::string::npos);
    for (const char* name : {"stress.csv", "junit.xml", "stress.md"})
        EXPECT_TRUE(std::filesystem::exists(out / name)) << name;
}

TEST(Stress, IsASectionOfTheReportOfARun) {
    const testing::TempFolder folder;
    const std::string run = (folder.path() / "run").string();
    ASSERT_EQ(test::penumbra({"compare", "--scene", "half_plane", "--method", "hard", "--size",
                              "16x16", "--repeats", "1", "--out", run})
                  .exitCode,
              0);
    const auto summary = [&] { return test::readText(folder.path() / "run" / "summary.md"); };
    const std::string before = summary();
    EXPECT_EQ(before.find("Stability"), std::string::npos);
    ASSERT_EQ(test::penumbra({"stress", "--case", "no_caster", "--method", "hard", "--out", run})
                  .exitCode,
              0);
    const std::string after = summary();
    EXPECT_NE(after.find("\n## Stability\n"), std::string::npos);
    EXPECT_NE(after.find("\n### Matrix\n"), std::string::npos);
    EXPECT_NE(after.find("| no_caster | pass 0 |"), std::string::npos);
    ASSERT_EQ(test::penumbra({"report", run}).exitCode, 0);
    EXPECT_EQ(summary(), after);
}

TEST(Stress, RefusesWhatItDoesNotKnow) {
    const auto refusal = [](const std::vector<std::string>& arguments) {
        const test::Finished done = test::penumbraInProcess(arguments);
        EXPECT_EQ(done.exitCode, 2) << arguments.back();
        EXPECT_EQ(test::lines(done.err).size(), 1u) << done.err;
        return done.err;
    };
    EXPECT_NE(refusal({"stress", "--case", "cow"}).find("unknown case 'cow'; the cases are "),
              std::string::npos);
    EXPECT_NE(refusal({"stress", "--method", "cow"}).find("unknown method 'cow'; the methods are "),
              std::string::npos);
    EXPECT_NE(refusal({"stress", "--random", "3", "--method", "cow"}).find("unknown method 'cow'"),
              std::string::npos);
    refusal({"stress", "--random", "0"});
    refusal({"stress", "--context", "cow"});
}

}  // namespace
}  // namespace penumbra
