#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "harness/gate/judge.hpp"

/// Rows, baselines and runs for tests of the gate, with round numbers and no files.
namespace penumbra::test {

inline const std::string kMachine = "a processor, Release";

inline Row gateRow(const std::string& scene, const std::string& method, int frame = 0) {
    Row row;
    row.scene = scene;
    row.frame = frame;
    row.method = row.setting = method;
    row.width = row.height = 512;
    row.frameMs = 10.0;
    row.frameMsLow = 9.8;
    row.frameMsHigh = 10.2;
    row.frameMsMad = 0.1;
    row.repeats = 5;
    row.drawCalls = 20;
    row.triangles = 10000;
    row.fragments = 300000;
    row.maps = 1;
    row.lightTexels = 1 << 20;
    row.textureMib = 4;
    row.metrics.rmse = 0.05;
    row.metrics.mae = 0.02;
    row.metrics.bias = 0.001;
    row.metrics.p99 = 0.2;
    row.metrics.maxError = 0.5;
    row.metrics.ssim = 0.9;
    row.metrics.rmsePenumbra = 0.1;
    row.metrics.leakRate = 0.0;
    row.metrics.scoredPixels = 250000;
    row.metrics.referenceSe = 0.0008;
    row.renderer = "llvmpipe";
    row.threads = 2;
    row.commit = "0123456789ab";
    return row;
}

inline gate::Baseline baselineOf(std::vector<Row> rows) {
    gate::Baseline baseline;
    baseline.file = "baseline.csv";
    baseline.machines.assign(rows.size(), kMachine);
    for (std::size_t i = 0; i < rows.size(); ++i) baseline.table.lines.push_back(i + 2);
    baseline.table.rows = std::move(rows);
    return baseline;
}

inline gate::JudgedRun runOf(std::vector<Row> rows) {
    gate::JudgedRun run;
    run.folder = "no_such_run";
    run.record.finished = true;
    run.record.width = run.record.height = 512;
    run.record.repeats = 5;
    run.record.referenceSe = 1.0 / 1024;
    run.record.provenance = {{"cpu", "a processor"}, {"build", "Release"}, {"threads", "2"}};
    for (std::size_t i = 0; i < rows.size(); ++i) {
        run.table.lines.push_back(i + 2);
        run.record.references.push_back(
            {.scene = rows[i].scene, .frame = rows[i].frame, .penumbraPixels = 40000});
    }
    run.table.rows = std::move(rows);
    return run;
}

/// The gate of this kind of the row; null if it was not judged.
inline const gate::Gate* gateOf(const gate::Verdict& verdict, const Row& row, gate::Kind kind) {
    const auto at = std::ranges::find_if(verdict.gates, [&](const gate::Gate& gate) {
        return gate.kind == kind && gate.row.key() == row.key();
    });
    return at == verdict.gates.end() ? nullptr : &*at;
}

}  // namespace penumbra::test
