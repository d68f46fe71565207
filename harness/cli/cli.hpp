#pragma once

namespace penumbra {

/// The whole program: parses the command line, runs the subcommand, turns exceptions into one line
/// on stderr. Returns the exit code: 0 good, 1 a gate failed, 2 bad input or usage, 3 some cells
/// failed or the work could not go on (a full disk), 128 + N where signal N asked to stop.
int runCommandLine(int argc, char** argv);

}  // namespace penumbra
