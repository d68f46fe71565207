#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "harness/run/run_record.hpp"
#include "harness/study/paired.hpp"

namespace penumbra {

/// What one frame of a scene says about two settings.
struct PairedFrame {
    std::string scene;
    int frame = 0;
    std::string a, b;  ///< names of the settings, as in results.csv
    std::vector<PairSample> pairs;
    bool operator==(const PairedFrame&) const = default;
};

/// paired.csv, one line per pair: scene, frame, a, b, pair (from 0), first (a or b), a_ms, b_ms,
/// speedup (b_ms / a_ms). Every number of the section below is computed from these lines.
void writePairedCsv(const std::filesystem::path& path, const std::vector<PairedFrame>& frames);
/// Throws InputError with file:line.
std::vector<PairedFrame> readPairedCsv(const std::filesystem::path& path);

/// A and B on one scene, or over the scenes.
struct PairedFinding {
    std::string scene;       ///< "overall" for all of them
    std::size_t frames = 0;  ///< or scenes
    std::size_t pairs = 0;
    double speedup = 0;                      ///< median
    std::optional<MedianInterval> interval;  ///< absent below kFewestForSignTest scenes
    std::optional<double> rmseA, rmseB;      ///< over a scene's frames; overall absent
    std::optional<double> rmseRatio;         ///< A's over B's

    /// "A is 1.83x (1.78-1.90) faster than B at 0.6 % higher rmse".
    std::string sentence() const;
};

/// One finding per scene, from all pairs of all its frames, and where there are several one
/// overall: the median over scenes of each scene's median speedup, with the sign-test interval of
/// those medians, so that it speaks of the next scene of this kind and not of the noise of the
/// clock; the rmse ratio is the median over scenes too.
std::vector<PairedFinding> pairedFindings(const std::vector<PairedFrame>& frames,
                                          const std::vector<Row>& rows);

/// The section of summary.md.
std::string pairedMarkdown(const std::vector<PairedFrame>& frames, const std::vector<Row>& rows,
                           const std::vector<RunRecord::SettingEntry>& settings);

}  // namespace penumbra
