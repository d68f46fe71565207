#include "harness/cli/cli.hpp"

#include <fmt/format.h>

#include <cstdio>

#include "core/error.hpp"
#include "harness/cli/commands.hpp"
#include "harness/run/command_line.hpp"
#include "harness/run/interruption.hpp"

namespace penumbra {
namespace {

/// The command line as it could be typed again.
std::string quoted(int argc, char** argv) {
    std::string line = "penumbra";
    for (int i = 1; i < argc; ++i) line += ' ' + shellQuoted(argv[i]);
    return line;
}

/// Errors are one line, whatever their message holds.
std::string oneLine(std::string text) {
    for (char& c : text)
        if (c == '\n' || c == '\r') c = ' ';
    while (text.ends_with(' ')) text.pop_back();
    return text;
}

/// CLI11 says only that a subcommand is required; this says which there are.
void requireSubcommand(const CLI::App& app, int argc, char** argv) {
    if (argc > 1 && argv[1][0] == '-') return;
    std::string names;
    for (const CLI::App* command : app.get_subcommands({})) {
        if (argc > 1 && command->get_name() == argv[1]) return;
        names += (names.empty() ? "" : ", ") + command->get_name();
    }
    throw InputError(argc > 1 ? fmt::format("unknown subcommand '{}'; valid are {}", argv[1], names)
                              : "a subcommand is required: " + names);
}

}  // namespace

int runCommandLine(int argc, char** argv) {
    CLI::App app(
        "Renders scenes with real-time soft-shadow techniques, scores every pixel against a "
        "ray-traced reference and shows what accuracy costs in time.",
        "penumbra");
    app.require_subcommand(1);
    Action action;
    addCompareCommand(app, action, quoted(argc, argv));
    addTuneCommand(app, action);
    addListCommand(app, action);
    addReportCommand(app, action);
    addCheckCommand(app, action);
    addApproveCommand(app, action);
    addMergeCommand(app, action);
    addDiffCommand(app, action);
    addScoreCommand(app, action, quoted(argc, argv));
    addExportCommand(app, action);
    addStressCommand(app, action);
    addReproduceCommand(app, action, quoted(argc, argv));
    addViewCommand(app, action);
    try {
        requireSubcommand(app, argc, argv);
        app.parse(argc, argv);
        return action();
    } catch (const CLI::ParseError& e) {
        if (e.get_exit_code() == 0) return app.exit(e);  // --help
        fmt::print(stderr, "penumbra: {} (see penumbra --help)\n", oneLine(e.what()));
    } catch (const InputError& e) {
        fmt::print(stderr, "penumbra: {}\n", oneLine(e.what()));
    } catch (const Interrupted& e) {
        return 128 + e.signal;
    } catch (const std::exception& e) {
        fmt::print(stderr, "penumbra: stopped: {}\n", oneLine(e.what()));
        return 3;
    }
    return 2;
}

}  // namespace penumbra
