#include "harness/cli/commands.hpp"
#include "harness/viewer/view_options.hpp"
#include "harness/viewer/viewer_window.hpp"

namespace penumbra {

void addViewCommand(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand(
        "view",
        "The interactive window: any scene and method live, its parameters, a progressive "
        "reference (docs/VIEWER.md)");
    auto entered = std::make_shared<EnteredView>();
    addViewOptions(*command, *entered);
    command->callback(
        [entered, &action] { action = [entered] { return runViewer(entered->finish()); }; });
}

}  // namespace penumbra
