// A large scene in little memory. The same of ten million triangles is measured by hand
// (docs/PERFORMANCE.md, "Size").

#include <gtest/gtest.h>

#include <set>

#include "harness/run/row.hpp"
#include "methods/shadow_method.hpp"
#include "tests/core/scene_files.hpp"
#include "tests/support/run_program.hpp"

namespace penumbra {
namespace {

using namespace test;

/// What a run of a million triangles may have resident.
constexpr double kMostMiB = 2048.0;

TEST(Size, AMillionTrianglesFromAFileAreScoredWithEveryMethodWithin2GiB) {
    const testing::TempFolder folder;
    const Finished made =
        penumbra({"export", "--scene", PENUMBRA_TEST_DIR "/../scenes/large/landscape_1m.toml",
                  "--size", "16x16", "--reference-se", "0.05", "--out", folder.path()});
    ASSERT_EQ(made.exitCode, 0) << made.err;
    EXPECT_LT(made.peakMiB, kMostMiB);

    const std::filesystem::path out = folder.path() / "run";
    const Finished run =
        penumbra({"compare", "--scene", folder.path() / "landscape_1m-0000.glb", "--size",
                  "128x128", "--repeats", "1", "--reference-se", "0.05", "--out", out});
    ASSERT_EQ(run.exitCode, 0) << run.err;
    EXPECT_LT(run.peakMiB, kMostMiB);
    std::set<std::string> scored;
    for (const Row& row : readCsv(out / "results.csv")) {
        EXPECT_EQ(row.status, "ok") << row.method << ": " << row.message;
        scored.insert(row.method);
        // The whole image shadowed or lit is off by 0.4 and more.
        EXPECT_LT(row.metrics.rmse, 0.25) << row.method;
    }
    for (const MethodInfo& method : methodRegistry()) EXPECT_TRUE(scored.contains(method.id));
}

}  // namespace
}  // namespace penumbra
