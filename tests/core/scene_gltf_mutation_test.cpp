#include <random>

#include "tests/core/scene_samples.hpp"

/// Truncated and flipped bytes of good files: each must load or be refused by InputError, whose
/// message failureOf() checks. A crash, a sanitizer's finding or any other exception fails the
/// test.
namespace penumbra::testing {
namespace {

struct Sample {
    const char* name;
    GltfFile (*make)();
};

class SceneGltfMutation : public ::testing::TestWithParam<Sample> {
  protected:
    const std::string whole = GetParam().make().glb();
    const TempFolder folder;

    std::string failure(const std::string& bytes) const {
        return failureOf(folder.write("mutant.glb", bytes), folder.library());
    }
};

TEST_P(SceneGltfMutation, TheWholeFileLoads) {
    EXPECT_EQ(failure(whole), "");
}

TEST_P(SceneGltfMutation, EveryTruncationIsRefused) {
    const std::size_t step = std::max<std::size_t>(1, whole.size() / 300);
    for (std::size_t size = 0; size < whole.size(); size += step) {
        EXPECT_NE(failure(whole.substr(0, size)), "") << "cut to " << size << " bytes";
    }
}

TEST_P(SceneGltfMutation, FlippedBitsLoadOrAreRefused) {
    std::mt19937 random(7);
    int refused = 0;
    constexpr int kRounds = 500;
    for (int round = 0; round < kRounds; ++round) {
        std::string mutant = whole;
        for (int k = 0; k <= round % 3; ++k) {
            mutant[random() % mutant.size()] ^= static_cast<char>(1u << random() % 8);
        }
        refused += !failure(mutant).empty();
    }
    EXPECT_GT(refused, kRounds / 10);  // most bytes are JSON, where a flip mostly breaks something
}

/// Digits of the JSON decide sizes, offsets and references: they are where harm is done.
TEST_P(SceneGltfMutation, ChangedNumbersLoadOrAreRefused) {
    std::mt19937 random(11);
    std::vector<std::size_t> digits;
    const std::size_t jsonEnd = whole.find("BIN");
    for (std::size_t i = 20; i < jsonEnd; ++i) {
        if (whole[i] >= '0' && whole[i] <= '9') digits.push_back(i);
    }
    for (int round = 0; round < 300; ++round) {
        std::string mutant = whole;
        for (int k = 0; k <= round % 2; ++k) {
            mutant[digits[random() % digits.size()]] = static_cast<char>('0' + random() % 10);
        }
        failure(mutant);
    }
}

INSTANTIATE_TEST_SUITE_P(All, SceneGltfMutation,
                         ::testing::Values(Sample{"deforming", deformingFile},
                                           Sample{"masked", maskedFile},
                                           Sample{"sparseInstanced", sparseInstancedFile}),
                         [](const auto& each) { return std::string(each.param.name); });

}  // namespace
}  // namespace penumbra::testing
