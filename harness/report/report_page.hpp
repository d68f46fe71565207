#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "harness/run/run_folder.hpp"
#include "harness/run/run_record.hpp"

namespace penumbra {

/// What report.html shows of one scene's images.
struct PageScene {
    struct Frame {
        int index = 0, width = 0, height = 0;  ///< of the run's images
        std::vector<std::size_t> rows;         ///< those that have an image
    };
    std::vector<Frame> frames;
    std::string images;  ///< pageImages() of each
};

/// report.html: one file that opens from disk. `scenes` are those of the record, in its order, with
/// images sampled every `stride` pixels. paired.csv, stress.csv, claims.csv and effects.csv,
/// where they are there, are sections of it. docs/REPORT.md says how to read it.
void writeReportPage(const RunFolder& folder, const RunRecord& record, const std::vector<Row>& rows,
                     const std::vector<PageScene>& scenes, int stride);

}  // namespace penumbra
