#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "harness/reference/certificate.hpp"
#include "harness/run/effects_record.hpp"
#include "harness/run/row.hpp"
#include "harness/study/pareto.hpp"

namespace penumbra {

/// What tracing the reference of one (scene, frame) cost.
struct ReferenceStats {
    std::string scene;
    int frame = 0;
    double rays = 0;     ///< spent, when it was traced
    double seconds = 0;  ///< in this run: of tracing, or of loading it from the cache
    bool cached = false;
    std::size_t penumbraPixels = 0;
    std::size_t scoredPixels = 0;
    /// What one ray count for all pixels would have spent at the same worst standard error; 0 if
    /// unknown.
    double uniformEquivalentRays = 0;
    Certificate checked{};  ///< against exact visibility; empty where that is not possible
};

struct PhaseTime {
    std::string name;  ///< `reference`, `methods` and `images` are work; all others are overhead
    double seconds = 0;
};

struct SummaryInput {
    std::string title = "Penumbra run";
    std::vector<std::pair<std::string, std::string>> provenance;  ///< name, value
    std::vector<Row> rows;
    std::vector<ReferenceStats> references;
    std::vector<EffectsRecord> analysis;
    std::vector<PhaseTime> phases;                                   ///< together the whole run
    std::vector<std::pair<std::string, std::string>> skippedScenes;  ///< scene, reason
    std::vector<CostStudy> studies;                                  ///< of runs with a curve
    std::string costMetric = "rmse";                                 ///< of the studies
};

/// summary.md: warnings first, then settings over all scenes, what accuracy costs, each scene,
/// widths of penumbrae, effects and what methods can simulate of them, what separating shading from
/// visibility costs, the references and where the time went. GitHub-flavoured Markdown; the same
/// input gives the same text.
std::string summaryMarkdown(const SummaryInput& input);

}  // namespace penumbra
