#include "harness/gate/thresholds.hpp"

#include <gtest/gtest.h>

#include "core/error.hpp"
#include "tests/core/scene_files.hpp"

namespace penumbra::gate {
namespace {

TEST(Glob, StarsAndQuestionMarks) {
    for (const auto& [pattern, text] :
         std::vector<std::pair<std::string, std::string>>{{"*", ""},
                                                          {"*", "anything"},
                                                          {"fence", "fence"},
                                                          {"f*e", "fence"},
                                                          {"f*e", "fe"},
                                                          {"*a*b*", "xxaxxabxx"},
                                                          {"rmse_?mbra", "rmse_umbra"},
                                                          {"pcss-*", "pcss-01234567"},
                                                          {"[a]*", "[a]b"}})
        EXPECT_TRUE(matchesGlob(pattern, text)) << pattern << " " << text;
    for (const auto& [pattern, text] : std::vector<std::pair<std::string, std::string>>{
             {"", "a"}, {"fence", "fences"}, {"f*e", "fen"}, {"?", ""}, {"*a*b", "xbxa"}})
        EXPECT_FALSE(matchesGlob(pattern, text)) << pattern << " " << text;
}

class GatesFile : public ::testing::Test {
  protected:
    std::string refusal(const std::string& text) {
        const auto file = folder_.write("gates.toml", text);
        try {
            Thresholds::read(file);
        } catch (const InputError& e) {
            const std::string said = e.what();
            EXPECT_TRUE(said.starts_with(file.string() + ":")) << said;
            return said.substr(file.string().size());
        }
        return "nothing is refused";
    }

  private:
    testing::TempFolder folder_;
};

TEST_F(GatesFile, ErrorsNameTheLine) {
    const std::string good = "[[gate]]\nmetric = \"rmse\"\nrelative = 0.1\nreason = \"why not\"\n";
    EXPECT_EQ(refusal(good), "nothing is refused");
    EXPECT_EQ(refusal("[[gate]]\nmetric = \"rmse\"\nrelative = 0.1\n"),
              ":1: 'reason' is missing: say why this may change");
    EXPECT_EQ(refusal("[[gate]]\nrelative = 0.1\nreason = \"x\"\n"), ":1: 'metric' is missing");
    EXPECT_TRUE(refusal(good + "\n[[gate]]\nmetric = \"rsme\"\nrelative = 1\nreason = \"x\"\n")
                    .starts_with(":7: no metric is called 'rsme'; valid are frame_ms, "));
    EXPECT_EQ(
        refusal(good + "  \nrelativ = 2\n"),
        ":6: unknown key 'relativ'; valid keys are scene, method, metric, relative, absolute, "
        "ignore, reason");
    EXPECT_EQ(refusal("[[gate]]\nmetric = \"rmse\"\nrelative = -1\nreason = \"x\"\n"),
              ":3: relative must be a finite number, 0 or more");
    EXPECT_EQ(refusal("[[gate]]\nmetric = \"rmse\"\nabsolute = nan\nreason = \"x\"\n"),
              ":3: absolute must be a finite number, 0 or more");
    EXPECT_EQ(refusal("[[gate]]\nmetric = \"rmse\"\nreason = \"x\"\n"),
              ":1: one of relative, absolute and ignore is needed");
    EXPECT_EQ(refusal("[[gate]]\nmetric = \"rmse\"\nignore = true\nrelative = 1\nreason = \"x\"\n"),
              ":3: ignore leaves nothing to compare with a threshold");
    EXPECT_EQ(refusal("[[gate]]\nmetric = \"row\"\nrelative = 1\nreason = \"x\"\n"),
              ":1: metric \"row\" is no number: it takes ignore = true");
    EXPECT_EQ(refusal("[[gate]]\nmetric = \"rmse\"\nrelative = 1\nreason = \"  \"\n"),
              ":4: reason must be a text that is not empty");
    EXPECT_EQ(refusal("[gate]\nmetric = \"rmse\"\n"), ":1: rules are written as [[gate]]");
    EXPECT_TRUE(refusal("[[gate]]\nmetric = \n").starts_with(":2: "));
    EXPECT_TRUE(refusal("[[gates]]\n").starts_with(":1: unknown key 'gates'; valid keys are gate"));
}

TEST(Thresholds, TheCommittedFileIsRead) {
    EXPECT_NO_THROW(Thresholds::read(std::filesystem::path(PENUMBRA_TEST_DIR).parent_path() /
                                     "results" / "gates.toml"));
}

}  // namespace
}  // namespace penumbra::gate
