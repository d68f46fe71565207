#include "harness/cli/commands.hpp"
#include "harness/run/merge.hpp"

namespace penumbra {

void addMergeCommand(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("merge", "Join the shards of a run into one folder");
    struct Folders {
        std::filesystem::path out;
        std::vector<std::filesystem::path> runs;
    };
    auto folders = std::make_shared<Folders>();
    command->add_option("out", folders->out, "new run folder")->required();
    command->add_option("runs", folders->runs, "run folders")->required();
    command->callback([folders, &action] {
        action = [folders] { return mergeRuns(folders->out, folders->runs); };
    });
}

}  // namespace penumbra
