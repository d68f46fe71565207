#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "harness/run/truth.hpp"

namespace penumbra {

/// What `penumbra export` was asked for.
struct ExportOptions {
    std::string scene;  ///< id, script or asset
    int frame = 0;
    std::filesystem::path out;  ///< folder, made if absent
    TruthOptions truth;
};

/// Writes one frame for other renderers, as <scene>-<frame, 0000>.glb, .json, -gbuffer.exr and
/// -reference.exr (docs/SCORING.md), and returns the four paths. `note` is told what a user should
/// know. Throws InputError for bad input, before anything is written.
std::vector<std::filesystem::path> exportFrame(const ExportOptions& options,
                                               const std::function<void(std::string)>& note,
                                               const Progress& progress = {});

}  // namespace penumbra
