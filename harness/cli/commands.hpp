#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

namespace penumbra {

/// What a parsed subcommand does; its result is the exit code.
using Action = std::function<int()>;

/// Each adds one subcommand to `app`; when it was given on the command line `action` is set.
/// `commandLine` is the command as typed.
void addTuneCommand(CLI::App& app, Action& action);
void addListCommand(CLI::App& app, Action& action);
void addCompareCommand(CLI::App& app, Action& action, const std::string& commandLine);
void addCheckCommand(CLI::App& app, Action& action);
void addApproveCommand(CLI::App& app, Action& action);
void addReportCommand(CLI::App& app, Action& action);
void addMergeCommand(CLI::App& app, Action& action);
void addDiffCommand(CLI::App& app, Action& action);
void addExportCommand(CLI::App& app, Action& action);
void addReproduceCommand(CLI::App& app, Action& action, const std::string& commandLine);
void addScoreCommand(CLI::App& app, Action& action, const std::string& commandLine);
void addStressCommand(CLI::App& app, Action& action);
void addViewCommand(CLI::App& app, Action& action);

}  // namespace penumbra
