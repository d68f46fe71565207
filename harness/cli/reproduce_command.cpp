#include "core/error.hpp"
#include "harness/cli/commands.hpp"
#include "harness/cli/truth_options.hpp"
#include "harness/study/reproduce.hpp"

namespace penumbra {

void addReproduceCommand(CLI::App& app, Action& action, const std::string& commandLine) {
    auto* command =
        app.add_subcommand("reproduce", "Measure the papers' headline claims as ratios");
    struct Entered {
        ReproduceOptions options;
        std::optional<std::string> size;
        std::string context = "osmesa";
    };
    auto entered = std::make_shared<Entered>();
    ReproduceOptions& o = entered->options;
    o.command = commandLine;
    command->add_option("paper", o.paper, "id of one paper (default: all)");
    command->add_option("--claims", o.claims, "folder of papers (default: scenes/papers)");
    command->add_flag("--markdown", o.markdown, "print the page claims.md instead of the table");
    addTruthOptions(*command, o, entered->size, "image size WxH (default: 512x512)");
    command->add_option("--pairs", o.pairs, "pairs of timings of each claim about time")
        ->check(CLI::Range(6, 10000));
    command->add_option("--context", entered->context, "osmesa | egl | glfw | auto");
    command->add_option("--out", o.out,
                        "folder for claims.csv and claims.md (default: results/<time>)");
    command->callback([entered, &action] {
        action = [entered] {
            ReproduceOptions& options = entered->options;
            finishTruthOptions(options, entered->size);
            options.context = gl::parseContextKind(entered->context);
            return reproduce(options);
        };
    });
}

}  // namespace penumbra
