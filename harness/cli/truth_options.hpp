#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <utility>

#include "harness/run/progress.hpp"
#include "harness/run/truth.hpp"

namespace penumbra {

/// "AxB" or "A/B": two positive integers around `separator`. Throws InputError naming `option`.
std::pair<int, int> parsePair(const std::string& option, const std::string& text, char separator);

/// The options --seed, --threads, --reference, --reference-se and --cache, the same in every
/// subcommand that needs a frame's truth; they write to `options`. --size, whose default differs,
/// writes to `size`.
void addTruthOptions(CLI::App& command, TruthOptions& options, std::optional<std::string>& size,
                     const std::string& sizeHelp);

/// The options --asset-scene, --camera and --max-memory, of every subcommand that takes an asset.
void addLoadOptions(CLI::App& command, LoadOptions& options);

/// Reads `size`, where it was given, into `options` and refuses what CLI11 lets through.
void finishTruthOptions(TruthOptions& options, const std::optional<std::string>& size);

/// Shows how far tracing a reference has come, from when it begins.
Progress referenceProgress(ProgressLine& line);

}  // namespace penumbra
