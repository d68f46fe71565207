#include "harness/cli/commands.hpp"
#include "harness/gate/check.hpp"
#include "harness/run/provenance.hpp"

namespace penumbra {

void addCheckCommand(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand(
        "check",
        "Compare a run with a baseline. Exit code 1 if something became worse than it may: "
        "accuracy "
        "beyond a threshold and the reference's noise, time beyond a threshold and both intervals, "
        "more work, missing effects, or a row that is gone");
    auto options = std::make_shared<gate::CheckOptions>();
    options->baseline = resultsFolder() / "baseline.csv";
    command->add_option("run", options->run, "run folder")->required();
    command->add_option("--baseline", options->baseline,
                        "what to compare with (default: results/baseline.csv)");
    command->add_option("--gates", options->gates,
                        "thresholds by scene, method and metric (default: gates.toml beside the "
                        "baseline)");
    command->add_flag("!--no-remeasure", options->remeasure,
                      "do not measure what fails a second time");
    command->add_flag("--partial", options->partial,
                      "rows of scenes and settings that the run was not asked for are not missing");
    command->callback([options, &action] { action = [options] { return check(*options); }; });
}

}  // namespace penumbra
