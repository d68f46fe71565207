#include "harness/gate/approve.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <set>

#include "core/error.hpp"
#include "harness/gate/history.hpp"
#include "harness/gate/judge.hpp"
#include "harness/run/csv.hpp"
#include "harness/run/files.hpp"
#include "harness/run/provenance.hpp"
#include "harness/run/run_folder.hpp"

namespace penumbra::gate {
namespace {

JudgedRun readApprovable(const std::filesystem::path& folder) {
    JudgedRun run = JudgedRun::read(folder);
    const std::string file = RunFolder(folder).results().string();
    if (!run.table.absent.empty())
        throw InputError(fmt::format("{}:1: column {} is missing; the run is of another version",
                                     file, run.table.absent.front()));
    for (std::size_t i = 0; i < run.table.rows.size(); ++i) {
        const Row& row = run.table.rows[i];
        if (row.status == "failed")
            throw InputError(fmt::format(
                "{}:{}: {} frame {} {} failed ({}); a run with failed cells "
                "cannot be a baseline",
                file, run.table.lines[i], row.scene, row.frame, row.setting, row.message));
    }
    if (run.table.rows.empty()) throw InputError(file + ": holds no row");
    return run;
}

struct Counts {
    std::size_t added = 0, changed = 0, gone = 0;
};

Counts countRows(const std::vector<Row>& before, const std::vector<Row>& after,
                 const std::vector<Change>& changes) {
    const auto keysOf = [](const std::vector<Row>& rows) {
        std::set<std::string> keys;
        for (const Row& row : rows) keys.insert(row.key());
        return keys;
    };
    const std::set<std::string> old = keysOf(before), now = keysOf(after);
    std::set<std::string> touched;
    for (const Change& c : changes) {
        Row row;
        row.scene = c.scene;
        row.frame = c.frame;
        row.setting = c.setting;
        touched.insert(row.key());
    }
    Counts counts;
    for (const std::string& key : old) counts.gone += !now.contains(key);
    for (const std::string& key : now) {
        counts.added += !old.contains(key);
        counts.changed += old.contains(key) && touched.contains(key);
    }
    return counts;
}

}  // namespace

int approve(const ApproveOptions& options) {
    if (options.reason.find_first_not_of(" \t\r\n") == std::string::npos)
        throw InputError("--reason: is empty; say why this run is right");
    const std::filesystem::path history =
        options.history.empty() ? options.baseline.parent_path() / "history.csv" : options.history;
    const JudgedRun run = readApprovable(options.run);

    std::vector<Row> before;
    std::string textBefore;
    if (std::filesystem::exists(options.baseline)) {
        before = readBaseline(options.baseline).table.rows;
        textBefore = readTextFile(options.baseline);
    }
    std::vector<Approval> approvals;
    if (std::filesystem::exists(history)) approvals = readHistory(history);
    dropUnborn(approvals, textBefore);

    const std::vector<Row>& rows = run.table.rows;
    const std::string machine = machineOf(run.record);
    const std::string text = baselineText(rows, machine);
    approvals.push_back({utcNow("%Y-%m-%dT%H:%M:%SZ"), userName(),
                         run.record.provenanceOf("commit"), options.reason,
                         run.record.provenanceOf("renderer"), machine,
                         std::atoi(run.record.provenanceOf("threads").c_str()), hashOf(text),
                         changesBetween(before, rows)});
    writeFileAtomically(history, historyText(approvals), true);
    writeFileAtomically(options.baseline, text, true);  // from here on it counts

    const Counts counts = countRows(before, rows, approvals.back().changes);
    fmt::print("{}: {} rows, {} new, {} changed, {} gone\n", options.baseline.string(), rows.size(),
               counts.added, counts.changed, counts.gone);
    return 0;
}

}  // namespace penumbra::gate
