#include "harness/cli/commands.hpp"
#include "harness/report/report.hpp"

namespace penumbra {

void addReportCommand(CLI::App& app, Action& action) {
    auto* command =
        app.add_subcommand("report", "Rebuild every artefact of a run folder from its rows");
    auto folder = std::make_shared<std::filesystem::path>();
    command->add_option("run", *folder, "run folder")->required();
    auto curveMetric = std::make_shared<std::string>();
    command->add_option("--curve-metric", *curveMetric,
                        "error on curves and in cost tables (default: the run's)");
    command->callback([folder, curveMetric, &action] {
        action = [folder, curveMetric] {
            writeArtefacts(RunFolder(*folder), *curveMetric);
            return 0;
        };
    });
}

}  // namespace penumbra
