#include "harness/gate/remeasure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <map>

#include "core/error.hpp"
#include "harness/run/command_line.hpp"
#include "harness/run/compare.hpp"
#include "harness/run/interruption.hpp"
#include "harness/run/provenance.hpp"
#include "harness/run/run_folder.hpp"
#include "harness/run/separation.hpp"

namespace penumbra::gate {
namespace {

/// Why this program cannot do again what the run did; empty if it can.
std::string obstacle(const RunRecord& record) {
    const std::string threads = record.provenanceOf("threads");
    const Provenance here = gatherProvenance(std::atoi(threads.c_str()));
    const auto differs = [&](const char* what, const std::string& there,
                             const std::string& now) -> std::string {
        return there == now ? ""
                            : fmt::format("the run's {} is {}, this program's {}", what,
                                          there.empty() ? "unknown" : there, now);
    };
    for (const std::string& difference :
         {differs("commit", record.provenanceOf("commit"), here.commit),
          differs("processor", record.provenanceOf("cpu"), here.cpu),
          differs("build", record.provenanceOf("build"), here.buildType)})
        if (!difference.empty()) return difference;
    return "";
}

CompareOptions optionsOf(const RunRecord& record) {
    CompareOptions o;
    o.width = record.width;
    o.height = record.height;
    o.seed = record.seed;
    o.threads = std::atoi(record.provenanceOf("threads").c_str());
    o.reference = record.reference;
    o.referenceSe = record.referenceSe;
    o.cache = record.cache;
    o.load.assetScene = record.assetScene;
    o.load.camera = record.camera;
    o.effects = EffectChoice::parse(effectsArgument(record));
    o.repeats = record.repeats;
    o.curveMetric = record.curveMetric;
    o.context = gl::parseContextKind(record.provenanceOf("context"));
    return o;
}

/// Adds `value` unless it is there.
void addNew(std::vector<std::string>& list, const std::string& value) {
    if (std::ranges::find(list, value) == list.end()) list.push_back(value);
}

std::string keyOfFrameBefore(Row row) {
    --row.frame;
    return row.key();
}

/// Whether two runs of one program on one machine may differ in it. A cell may fail for want of
/// memory, which is the machine's state.
bool mayChange(Kind kind) {
    return kind == Kind::time || kind == Kind::row;
}

/// "rmse 0.1 -> 0.2 (+100 %), bias ..."
std::string changes(const Gate& gate) {
    std::string text;
    for (const Finding& finding : gate.findings)
        text += fmt::format("{}{} {}", text.empty() ? "" : ", ", finding.metric, finding.change);
    return text;
}

}  // namespace

Remeasured measureAgain(const JudgedRun& run, const Verdict& verdict) {
    Remeasured out{run, {}, obstacle(run.record)};
    if (!out.never.empty()) return out;
    CompareOptions options = optionsOf(run.record);
    CellChoice& choice = options.again.emplace();
    for (const Gate& gate : verdict.gates) {
        const Row& row = gate.row;
        if (gate.state != State::failed || isSeparation(row) || row.renderer == kExternalRenderer)
            continue;
        addNew(options.scenes, sceneArgument(run.record, row.scene));
        addNew(choice.settings,
               row.params.empty() ? row.method : fmt::format("{}:{}", row.method, row.params));
        choice.keys.insert(row.key());
        if (row.status != "ok" && row.frame > 0) choice.keys.insert(keyOfFrameBefore(row));
    }
    if (choice.keys.empty()) {
        out.never = "no cell makes these rows";
        return out;
    }
    const RunFolder folder(RunFolder(run.folder).remeasured());
    options.out = folder.root();
    options.command = run.record.command;
    std::filesystem::remove_all(options.out);
    try {
        // A verdict on half of the cells would be none.
        if (const int code = compare(options); code > 128) throw Interrupted(code - 128);
    } catch (const InputError& e) {
        out.never = e.what();
        return out;
    }
    for (Row& again : readResultsTable(folder.results()).rows) {
        const auto first = std::ranges::find(out.run.table.rows, again.key(), &Row::key);
        // Under another renderer neither time nor work would be compared.
        if (first == out.run.table.rows.end() || first->renderer != again.renderer) continue;
        // Without the frame before there is no flicker; images of one commit do not differ.
        if (!again.metrics.flicker) again.metrics.flicker = first->metrics.flicker;
        *first = std::move(again);
        out.keys.insert(first->key());
    }
    if (out.keys.empty()) out.never = "the renderer is another one now";
    return out;
}

Verdict judgeAgain(const Verdict& first, const Remeasured& again, const Baseline& baseline,
                   const Thresholds& thresholds) {
    const Verdict second = again.keys.empty() ? Verdict{} : judge(baseline, again.run, thresholds);
    std::map<std::pair<std::string, Kind>, const Gate*> anew;
    for (const Gate& gate : second.gates) anew[{gate.row.key(), gate.kind}] = &gate;

    Verdict verdict = first;
    std::vector<Gate> uncovered;  // of rows that had no numbers at first
    for (Gate& gate : verdict.gates) {
        if (gate.state != State::failed) continue;
        const std::string key = gate.row.key();
        if (!again.keys.contains(key)) {
            gate.again = "no: " + (again.never.empty() ? "no cell makes this row" : again.never);
            continue;
        }
        const Gate& now = *anew.at({key, gate.kind});
        const std::string atFirst = changes(gate);
        if (!now.fails() && mayChange(gate.kind)) {
            gate.state = State::recovered;
            gate.again = "it passes; at first " + atFirst;
        } else if (!now.fails()) {
            gate.again =
                "it passes, but what is not a time is the same in every run of one program on one "
                "machine: the run's row is not what this program makes";
        } else {
            gate = now;
            gate.again = "it fails again; at first " + atFirst;
        }
        if (gate.kind != Kind::row || gate.fails()) continue;
        for (const Kind kind : {Kind::accuracy, Kind::time, Kind::work, Kind::effects})
            if (const auto found = anew.find({key, kind}); found != anew.end())
                uncovered.push_back(*found->second);
    }
    verdict.gates.insert(verdict.gates.end(), uncovered.begin(), uncovered.end());
    return verdict;
}

}  // namespace penumbra::gate
