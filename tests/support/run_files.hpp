#pragma once

#include <algorithm>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "harness/report/report.hpp"
#include "harness/run/row.hpp"
#include "harness/run/run_folder.hpp"
#include "tests/support/run_program.hpp"

/// What two run folders that did the same work must have in common.
namespace penumbra::test {

/// Whether the number of threads is part of what is compared.
enum class Threads { compared, ignored };

/// The rows as CSV lines without what may differ between two runs of one command: every time is
/// written as 0, so that whether there is one still counts, and the state of the source tree, which
/// its owner may change between the runs, is left out.
inline std::vector<std::string> untimedRows(const std::filesystem::path& runFolder,
                                            Threads threads = Threads::compared) {
    std::vector<std::string> list;
    for (Row row : readCsv(runFolder / "results.csv")) {
        for (auto* ms : {&row.frameMs, &row.frameMsLow, &row.frameMsHigh, &row.frameMsMad,
                         &row.buildMs, &row.shadeMs, &row.prepareMs, &row.shadeFetchesPerPixel})
            if (*ms) *ms = 0.0;
        row.unstable = false;
        row.commit.clear();
        if (threads == Threads::ignored) row.threads = 0;
        list.push_back(toCsv(row));
    }
    return list;
}

/// Makes the pictures anew of a copy of `runFolder` without times, which are drawn on them, in
/// `copy`; whether two runs' are the same can then be asked of `copy`/grid.
inline void drawUntimed(const std::filesystem::path& runFolder, const std::filesystem::path& copy) {
    std::filesystem::copy(runFolder, copy, std::filesystem::copy_options::recursive);
    std::string text = csvHeader() + "\n";
    for (const std::string& row : untimedRows(runFolder)) text += row + "\n";
    std::ofstream(copy / "results.csv", std::ios::binary) << text;
    writeArtefacts(RunFolder(copy));
}

/// Every file below `folder` by its relative path, with its bytes.
inline std::map<std::string, std::string> filesBelow(const std::filesystem::path& folder) {
    std::map<std::string, std::string> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
        if (entry.is_regular_file())
            files[std::filesystem::relative(entry.path(), folder).string()] =
                readText(entry.path());
    return files;
}

/// Compares names and bytes without printing the bytes.
inline void expectSameFiles(const std::filesystem::path& a, const std::filesystem::path& b) {
    const auto filesA = filesBelow(a), filesB = filesBelow(b);
    EXPECT_FALSE(filesA.empty()) << a;
    for (const auto& [name, bytes] : filesA) {
        const auto other = filesB.find(name);
        if (other == filesB.end())
            ADD_FAILURE() << name << " is in " << a << " but not in " << b;
        else
            EXPECT_TRUE(bytes == other->second) << name << " differs between " << a << " and " << b;
    }
    for (const auto& [name, bytes] : filesB)
        EXPECT_TRUE(filesA.contains(name)) << name << " is in " << b << " but not in " << a;
}

}  // namespace penumbra::test
