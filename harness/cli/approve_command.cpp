#include "harness/cli/commands.hpp"
#include "harness/gate/approve.hpp"
#include "harness/run/provenance.hpp"

namespace penumbra {

void addApproveCommand(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand(
        "approve", "Make a run the baseline and record who, when, why, before and after");
    auto options = std::make_shared<gate::ApproveOptions>();
    options->baseline = resultsFolder() / "baseline.csv";
    command->add_option("run", options->run, "run folder")->required();
    command->add_option("--reason", options->reason, "why the run is right")->required();
    command->add_option("--baseline", options->baseline,
                        "what to replace (default: results/baseline.csv)");
    command->add_option("--history", options->history,
                        "what to append to (default: history.csv beside the baseline)");
    command->callback([options, &action] { action = [options] { return approve(*options); }; });
}

}  // namespace penumbra
