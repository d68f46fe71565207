#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/effects/effects.hpp"
#include "core/frame/gbuffer.hpp"
#include "harness/run/cells.hpp"

namespace penumbra {

/// One setting on one frame under one plan: a line of effects.csv.
struct EffectsCell {
    std::string scene;
    int frame = 0;
    std::string method, setting;
    /// "auto", "all", or "-" and the id of the effect that was left out of auto.
    std::string plan;
    std::string status = "ok";  ///< as Row::status
    std::optional<double> frameMs, frameMsLow, frameMsHigh;
    /// Over scored pixels: against the image of auto, and against the reference.
    std::optional<double> rmseToAuto, maxToAuto, rmse;
    bool operator==(const EffectsCell&) const = default;
};

/// The plans beside auto under which a setting is run on a frame that calls for `calledFor`: all,
/// and auto without each of the effects that it simulates.
struct PlanVariant {
    std::string name;  ///< EffectsCell::plan
    EffectChoice choice;
};
std::vector<PlanVariant> planVariants(const EffectSet& calledFor, const EffectSet& canSimulate);

struct VariantImage {
    EffectsCell cell;
    std::vector<float> visibility;  ///< empty if it failed
};

/// Runs `runs` under auto and each under its other plans, all of them interleaved in the same
/// rounds, and returns them run by run; the cells lack rmse. `done` gets what runCells would give
/// it of auto.
std::vector<VariantImage> runVariants(
    const Frame& frame, const CellOptions& options, const std::vector<SettingRun*>& runs,
    const TextureTarget& target,
    const std::function<void(std::size_t, Row&&, const std::vector<float>&)>& done);

void writeEffectsCsv(const std::filesystem::path& path, const std::vector<EffectsCell>& cells);
/// Throws InputError with file and line.
std::vector<EffectsCell> readEffectsCsv(const std::filesystem::path& path);

/// effects.md: all against auto for each setting over its frames, then what each effect left out
/// saves and does to the image, then every plan scene by scene.
std::string effectsTableMarkdown(const std::vector<EffectsCell>& cells);

}  // namespace penumbra
