#include <filesystem>
#include <optional>

#include "core/error.hpp"
#include "harness/cli/commands.hpp"
#include "harness/gate/history_page.hpp"
#include "harness/report/report.hpp"
#include "harness/run/folder_lock.hpp"
#include "harness/run/provenance.hpp"

namespace penumbra {
namespace {

struct Entered {
    std::filesystem::path source, out;  ///< source: a run folder or a history
    std::string curveMetric;
    bool history = false;
};

int run(const Entered& entered) {
    if (entered.history)
        return gate::writeHistoryPage(
            entered.source.empty() ? resultsFolder() / "history.csv" : entered.source, entered.out);
    if (entered.source.empty()) throw InputError("report: name a run folder, or --history");
    if (!entered.out.empty()) throw InputError("--out: goes with --history");
    std::optional<FolderLock> lock;  // what is no folder has a message of its own below
    if (std::filesystem::is_directory(entered.source)) lock.emplace(entered.source);
    writeArtefacts(RunFolder(entered.source), entered.curveMetric);
    return 0;
}

}  // namespace

void addReportCommand(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("report",
                                       "Rebuild every artefact of a run folder from its rows, or "
                                       "the page of what was approved over time");
    auto entered = std::make_shared<Entered>();
    command->add_option("run", entered->source,
                        "run folder, or the file of --history (default: results/history.csv)");
    command->add_option("--curve-metric", entered->curveMetric,
                        "error on curves and in cost tables (default: the run's)");
    command->add_flag("--history", entered->history,
                      "every metric over the approved commits, with its steps, as a page");
    command->add_option("--out", entered->out,
                        "the page of --history (default: history.html beside the file)");
    command->callback([entered, &action] { action = [entered] { return run(*entered); }; });
}

}  // namespace penumbra
