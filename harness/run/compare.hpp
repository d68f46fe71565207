#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/effects/effects.hpp"
#include "core/gl/context.hpp"
#include "harness/run/settings.hpp"
#include "harness/run/truth.hpp"

namespace penumbra {

/// Cells of an earlier run that are done again, and nothing else.
struct CellChoice {
    std::vector<std::string> settings;  ///< as parseSetting reads them
    std::set<std::string> keys;         ///< Row::key
};

/// What `penumbra compare` was asked for.
struct CompareOptions : TruthOptions {
    std::string suite;                ///< id; empty with no scene: "standard"
    std::vector<std::string> scenes;  ///< ids, scripts or assets
    SettingChoice settings;
    /// Two settings as parseSetting reads them, to be timed in pairs; empty: those of `settings`.
    std::vector<std::string> paired;
    EffectChoice effects;
    /// Every setting is also timed under the plans of harness/study/effects_table.hpp.
    bool effectsTable = false;
    int repeats = 5;                   ///< pairs, where `paired` is given
    std::string curveMetric = "rmse";  ///< on the error axis of curves
    gl::ContextKind context = gl::ContextKind::osmesa;
    std::filesystem::path out;  ///< empty: results/<time>
    bool resume = false;
    int shard = 1, shards = 1;  ///< this process does every `shards`-th cell from the `shard`-th on
    std::string command;        ///< as typed, for the record
    /// Instead of `settings`; such a run says nothing on standard output or in CI's step summary.
    std::optional<CellChoice> again{};
};

/// Runs all cells and writes the run folder; with `paired` also paired.csv, and tells on standard
/// output what A is against B on every scene and overall; with `effectsTable` also effects.csv and
/// effects.md, which it prints. Returns 0, or 3 when some cells failed.
/// Throws InputError for bad input before anything is written, and where another process works in
/// the same folder.
///
/// A row is in results.csv once its cell is finished and its image is in the folder whole; both
/// stay whatever becomes of the process: an exception, a full disk, SIGKILL at any moment. (A power
/// cut or a crash of the system may take images that were not on the disk yet.) `resume` does the
/// rest and ends with the images and the rows, but for times, of a run that was not stopped. On
/// SIGINT or SIGTERM cells that are begun are finished, but not a reference; everything is written
/// of the rows that are there; the result is 128 + the signal's number. A second signal ends the
/// process at once.
int compare(const CompareOptions& options);

}  // namespace penumbra
