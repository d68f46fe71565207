#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "harness/metrics/diff.hpp"
#include "harness/run/row.hpp"
#include "harness/run/truth.hpp"

namespace penumbra {

/// What `penumbra score` was asked for. Either `image` or both of `shadowed` and `unshadowed` are
/// set.
struct ScoreOptions {
    std::string scene;  ///< id, script or asset
    int frame = 0;
    std::filesystem::path image;
    std::filesystem::path shadowed, unshadowed;
    Transfer transfer = Transfer::byFile;
    std::string name;  ///< of the row; empty: the stem of the image's file
    std::optional<double> frameMs;
    TruthOptions truth;
    bool sizeGiven = false;     ///< else the frame is as large as the image
    std::filesystem::path run;  ///< run folder to add the row to, new or existing; empty: none
    std::string command;        ///< as typed, for the record of a new run
};

/// Another renderer's visibility of one frame, scored like a method's: the row of results.csv with
/// every metric that one frame allows. With a run folder the row and the image are added to it, in
/// place of an earlier one of the same name, and its tables and grids are rebuilt. `note` is told
/// what a user should know.
///
/// Throws InputError, before anything is written, for images that cannot be read or show another
/// frame (alignment.hpp), for a run of another size, seed or reference, and there for a name that
/// belongs to a method or could not be a file's.
Row scoreImage(const ScoreOptions& options, const std::function<void(std::string)>& note,
               const Progress& progress = {});

}  // namespace penumbra
