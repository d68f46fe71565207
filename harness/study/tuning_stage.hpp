#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "harness/metrics/metrics.hpp"
#include "harness/run/cells.hpp"
#include "harness/run/staged_frame.hpp"

namespace penumbra {

/// One frame at one size on which settings are scored and timed. What was measured is kept on disk:
/// the same settings asked for together with the same repeats give the rows of the first time, as
/// long as machine, renderer, threads, program, shaders, scene, size, seed and reference are the
/// same. That is what makes a search over noisy timings repeatable.
class TuningStage {
  public:
    /// `machine`: renderer and processor. `remeasure`: rows on disk are replaced instead of read.
    TuningStage(std::shared_ptr<const Scene> scene, int index, int width, int height,
                const TruthOptions& truth, const std::string& machine, bool remeasure,
                const Progress& progress = {});

    int width() const { return staged_.frame.width(); }
    int height() const { return staged_.frame.height(); }
    double pixels() const { return static_cast<double>(width()) * height(); }
    /// One row per setting in their order, scored, the timings interleaved as runCells does.
    std::vector<Row> measure(const std::vector<Setting>& settings, int repeats) const;

  private:
    std::vector<Row> measureAnew(const std::vector<Setting>& settings, int repeats) const;

    StagedFrame staged_;
    Reference reference_;
    Scorer scorer_;
    TextureTarget target_;
    std::filesystem::path folder_;
    std::string key_;
    bool remeasure_;
};

}  // namespace penumbra
