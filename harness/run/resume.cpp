#include "harness/run/resume.hpp"

#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <string_view>
#include <vector>

#include "core/error.hpp"
#include "core/file/atomic_file.hpp"
#include "harness/run/files.hpp"
#include "harness/run/row.hpp"

namespace penumbra {
namespace {

void requireSameRun(const RunFolder& folder, const RunRecord& before, const RunRecord& record) {
    if (before.width != record.width || before.height != record.height ||
        before.seed != record.seed || before.reference != record.reference ||
        before.referenceSe != record.referenceSe || before.effects != record.effects ||
        before.assetScene != record.assetScene || before.camera != record.camera)
        throw InputError(fmt::format(
            "--resume {}: the run there has --size {}x{} --seed {} --reference {} "
            "--reference-se {} --effects '{}' --asset-scene '{}' --camera '{}'; a "
            "resumed run must have the same",
            folder.root().string(), before.width, before.height, before.seed, before.reference,
            before.referenceSe, before.effects, before.assetScene, before.camera));
}

/// What a kill left of files that were being written beside their names.
void removeTornFiles(const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> torn;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
        if (isTemporaryFile(entry.path())) torn.push_back(entry.path());
    for (const auto& path : torn) std::filesystem::remove(path);
}

bool mustBeDoneAgain(const RunFolder& folder, const Row& row) {
    return row.status == "failed" ||
           (row.status == "ok" &&
            !std::filesystem::exists(folder.setting(row.scene, row.frame, row.setting)));
}

}  // namespace

std::set<std::string> takeUpRun(const RunFolder& folder, RunRecord& record) {
    const RunRecord before = RunRecord::read(folder.record());
    requireSameRun(folder, before, record);
    record.references = before.references;
    record.analysis = before.analysis;
    removeTornFiles(folder.root());
    std::set<std::string> done;
    std::string kept = csvHeader() + "\n";
    for (const Row& row : readCsv(folder.results())) {
        if (mustBeDoneAgain(folder, row)) continue;
        done.insert(row.key());
        kept += toCsv(row) + "\n";
    }
    writeFileAtomically(folder.results(), kept);
    return done;
}

void removeTornBeginnings(const RunFolder& folder) {
    removeStaleTemporaries(folder.root(), std::chrono::hours(0), [&](std::string_view name) {
        return name.starts_with(folder.record().filename().string() + ".") ||
               name.starts_with(folder.results().filename().string() + ".");
    });
}

}  // namespace penumbra
