#include "harness/gate/check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <string_view>

#include "core/error.hpp"
#include "harness/gate/gate_report.hpp"
#include "harness/gate/remeasure.hpp"
#include "harness/report/benchmark.hpp"
#include "harness/report/report.hpp"
#include "harness/run/files.hpp"
#include "harness/run/folder_lock.hpp"

namespace penumbra::gate {
namespace {

Thresholds readThresholds(const CheckOptions& options) {
    if (!options.gates.empty()) return Thresholds::read(options.gates);
    const std::filesystem::path beside = options.baseline.parent_path() / "gates.toml";
    return std::filesystem::exists(beside) ? Thresholds::read(beside) : Thresholds();
}

/// Drops the baseline's rows of scenes and settings that the run was not asked for.
void keepWhatWasAsked(Baseline& baseline, const RunRecord& record) {
    const auto asked = [&](const Row& row) {
        return std::ranges::find(record.scenes, row.scene, &RunRecord::SceneEntry::id) !=
                   record.scenes.end() &&
               std::ranges::find(record.settings, row.setting, &RunRecord::SettingEntry::name) !=
                   record.settings.end();
    };
    Baseline kept{baseline.file, {}, {}};
    kept.table.absent = baseline.table.absent;
    kept.table.unknown = baseline.table.unknown;
    for (std::size_t i = 0; i < baseline.table.rows.size(); ++i) {
        if (!asked(baseline.table.rows[i])) continue;
        kept.table.rows.push_back(baseline.table.rows[i]);
        kept.table.lines.push_back(baseline.table.lines[i]);
        kept.machines.push_back(baseline.machines[i]);
    }
    baseline = std::move(kept);
}

bool inGithubActions() {
    const char* actions = std::getenv("GITHUB_ACTIONS");
    return actions && std::string_view(actions) == "true";
}

}  // namespace

int check(const CheckOptions& options) {
    const Thresholds thresholds = readThresholds(options);
    Baseline baseline = readBaseline(options.baseline);
    const JudgedRun run = JudgedRun::read(options.run);
    const FolderLock lock(options.run);
    if (options.partial) keepWhatWasAsked(baseline, run.record);
    if (baseline.table.rows.empty())
        throw InputError(fmt::format("{}: holds no row{} to compare with",
                                     options.baseline.string(),
                                     options.partial ? " of what the run was asked for" : ""));

    Verdict verdict = judge(baseline, run, thresholds);
    std::vector<Row> rows = run.table.rows;
    if (verdict.count(State::failed) > 0 && options.remeasure) {
        const Remeasured again = measureAgain(run, verdict);
        verdict = judgeAgain(verdict, again, baseline, thresholds);
        rows = again.run.table.rows;
    }

    const RunFolder folder(options.run);
    const std::string markdown = verdictMarkdown(verdict, run);
    writeFileAtomically(folder.junit(), verdictJunit(verdict, run));
    writeFileAtomically(folder.benchmark(), benchmarkJson(rows));
    writeFileAtomically(folder.gate(), markdown);
    writeSummary(folder);
    appendToStepSummary(markdown);
    fmt::print("{}", verdictText(verdict, run));
    if (inGithubActions()) fmt::print("{}", verdictAnnotations(verdict, run));
    return verdict.fails() ? 1 : 0;
}

}  // namespace penumbra::gate
