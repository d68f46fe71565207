#include "harness/cli/commands.hpp"
#include "harness/report/report.hpp"

namespace penumbra {

void addReportCommand(CLI::App& app, Action& action) {
    auto* command =
        app.add_subcommand("report", "Rebuild every artefact of a run folder from its rows");
    auto folder = std::make_shared<std::filesystem::path>();
    command->add_option("run", *folder, "run folder")->required();
    command->callback([folder, &action] {
        action = [folder] {
            writeArtefacts(RunFolder(*folder));
            return 0;
        };
    });
}

}  // namespace penumbra
