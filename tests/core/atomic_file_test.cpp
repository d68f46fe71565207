#include "core/file/atomic_file.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <thread>
#include <vector>

#include "tests/core/scene_files.hpp"

namespace penumbra {
namespace {

std::string readAll(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

TEST(AtomicFile, ManyWritersOfOneNameLeaveOneWholeFile) {
    const testing::TempFolder folder;
    const std::filesystem::path path = folder.path() / "file";
    // Longer than a pipe's or a page's worth, so that a mixture of two would show.
    const auto text = [](int writer) {
        return std::string(100000, static_cast<char>('a' + writer));
    };
    writeFileAtomically(path, text(0));
    std::vector<std::thread> writers;
    for (int writer = 0; writer < 3; ++writer)
        writers.emplace_back([&, writer] {
            for (int i = 0; i < 50; ++i) writeFileAtomically(path, text(writer), i % 2 == 0);
        });
    for (int i = 0; i < 100; ++i) {
        const std::string now = readAll(path);
        EXPECT_TRUE(now.size() == 100000 && now.find_first_not_of(now[0]) == std::string::npos);
    }
    for (std::thread& writer : writers) writer.join();
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

TEST(AtomicFile, TemporaryNamesAreToldFromOthers) {
    EXPECT_TRUE(isTemporaryFile("folder/run.json.0123456789abcdef.tmp"));
    for (const char* other :
         {"run.json", "run.json.tmp", "run.json.12.tmp", "run.json.0123456789abcdeg.tmp",
          "run.json-0123456789abcdef.tmp", ".0123456789abcdef.tmp", "0123456789abcdef.tmp",
          "run.json.0123456789abcdef.tmp.old", ".tmp", ""})
        EXPECT_FALSE(isTemporaryFile(other)) << other;
}

TEST(AtomicFile, NothingIsRemovedFromAFolderThatIsNotThere) {
    const testing::TempFolder folder;
    EXPECT_NO_THROW(removeStaleTemporaries(folder.path() / "absent", std::chrono::hours(0),
                                           [](std::string_view) { return true; }));
}

}  // namespace
}  // namespace penumbra
