#include "harness/run/files.hpp"

#include <gtest/gtest.h>

#include "tests/core/scene_files.hpp"
#include "tests/support/run_files.hpp"

namespace penumbra {
namespace {

using penumbra::testing::TempFolder;
using Files = std::map<std::string, std::string>;

TEST(WriteFileAtomically, WritesAndReplacesAndLeavesNothingElse) {
    const TempFolder folder;
    writeFileAtomically(folder.path() / "file", "one\n");
    EXPECT_EQ(test::filesBelow(folder.path()), (Files{{"file", "one\n"}}));
    const std::string binary("a\0\r\n\xff", 5);
    writeFileAtomically(folder.path() / "file", binary);
    EXPECT_EQ(test::filesBelow(folder.path()), (Files{{"file", binary}}));
}

TEST(WriteFileAtomically, AReaderOfTheOldFileKeepsIt) {
    const TempFolder folder;
    writeFileAtomically(folder.path() / "file", "old");
    std::ifstream reader(folder.path() / "file");
    writeFileAtomically(folder.path() / "file", "new and longer");
    EXPECT_EQ(std::string(std::istreambuf_iterator<char>(reader), {}), "old");
}

TEST(WriteFileAtomically, AFailureNamesTheFileAndLeavesNothing) {
    const TempFolder folder;
    std::filesystem::create_directories(folder.path() / "taken" / "by a folder");
    for (const std::filesystem::path& path :
         {folder.path() / "absent" / "file", folder.path() / "taken"}) {
        try {
            writeFileAtomically(path, "text");
            ADD_FAILURE() << path;
        } catch (const std::runtime_error& e) {
            EXPECT_TRUE(std::string(e.what()).starts_with(path.string() + ": cannot be written: "))
                << e.what();
        }
    }
    EXPECT_EQ(test::filesBelow(folder.path()), Files{});
}

}  // namespace
}  // namespace penumbra
