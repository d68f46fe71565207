#include "harness/report/report.hpp"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <map>

#include "harness/report/benchmark.hpp"
#include "harness/report/grid.hpp"
#include "harness/report/markdown.hpp"
#include "harness/report/page_image.hpp"
#include "harness/report/report_page.hpp"
#include "harness/report/summary.hpp"
#include "harness/run/csv.hpp"
#include "harness/run/files.hpp"
#include "harness/study/curve.hpp"
#include "harness/study/effects_table.hpp"
#include "harness/study/paired_report.hpp"

namespace penumbra {
namespace {

/// Writes grid/<scene>.png; what the page shows of the scene, `sceneIndex` of the record, comes
/// from the same images.
PageScene drawScene(const RunFolder& folder, const RunRecord& record, std::size_t sceneIndex,
                    const std::vector<Row>& rows, int stride) {
    const RunRecord::SceneEntry& scene = record.scenes[sceneIndex];
    std::vector<int> frames;
    for (const Row& row : rows)
        if (row.scene == scene.id && std::ranges::find(frames, row.frame) == frames.end())
            frames.push_back(row.frame);
    if (frames.empty()) return {};
    std::ranges::sort(frames);

    std::vector<GBuffer> gbuffers;
    std::vector<Reference> references;
    for (int frame : frames) {
        gbuffers.push_back(folder.readGBuffer(scene.id, frame));
        references.push_back(folder.readReference(scene.id, frame));
    }
    std::vector<GridFrame> grid;
    for (std::size_t i = 0; i < frames.size(); ++i) {
        GridFrame g{frames[i], &gbuffers[i], &references[i], {}};
        for (const Row& row : rows) {
            if (row.scene != scene.id || row.frame != frames[i]) continue;
            g.cells.push_back({&row, row.status == "ok"
                                         ? folder.readVisibility(scene.id, row.frame, row.setting)
                                         : std::vector<float>{}});
        }
        grid.push_back(std::move(g));
    }
    std::filesystem::create_directories(folder.grid(scene.id).parent_path());
    writePng(folder.grid(scene.id), renderGrid(scene.id, scene.shows, grid));

    PageScene page;
    for (const GridFrame& frame : grid) {
        page.frames.push_back({frame.index, frame.gbuffer->width, frame.gbuffer->height});
        page.images += pageImages(frame, sceneIndex, rows, stride);
    }
    return page;
}

double imagePixels(const std::vector<Row>& rows) {
    double pixels = 0.0;
    for (const Row& row : rows)
        if (row.status == "ok") pixels += static_cast<double>(row.width) * row.height;
    return pixels;
}

RunRecord readRecord(const RunFolder& folder, const std::string& curveMetric) {
    RunRecord record = RunRecord::read(folder.record());
    if (!curveMetric.empty()) record.curveMetric = curveMetric;
    requireCostMetric(record.curveMetric);
    return record;
}

std::vector<CostStudy> studiesOf(const std::vector<Row>& rows, const RunRecord& record) {
    return hasCurve(rows) ? costStudies(rows, record.curveMetric) : std::vector<CostStudy>{};
}

void writeCurves(const RunFolder& folder, const RunRecord& record, const std::vector<Row>& rows) {
    const std::vector<CostStudy> studies = studiesOf(rows, record);
    // An earlier report may have drawn what is no longer there.
    std::filesystem::remove(folder.pareto());
    std::filesystem::remove_all(folder.curve("").parent_path());
    if (studies.empty()) return;
    std::filesystem::create_directories(folder.curve("").parent_path());
    writeFileAtomically(folder.pareto(), paretoCsv(studies, record.curveMetric));
    const std::map<std::string, int> styles = methodStyles(studies);
    for (const CostStudy& study : studies) {
        const Plot plot = curvePlot(study, record.curveMetric, styles);
        writeFileAtomically(folder.curve(study.scene).concat(".svg"), plotSvg(plot));
        writeFileAtomically(folder.curve(study.scene).concat(".png"), plotPng(plot));
    }
}

/// A document of its own as a section: its headings one level deeper.
std::string asSection(const std::string& document) {
    std::string text = "\n";
    bool lineStarts = true;
    for (const char c : document) {
        if (lineStarts && c == '#') text += '#';
        text += c;
        lineStarts = c == '\n';
    }
    return text;
}

}  // namespace

void orderRows(const RunFolder& folder, const RunRecord& record) {
    std::vector<Row> rows = readCsv(folder.results());
    const auto rank = [](const auto& list, const std::string& name, auto member) {
        return std::ranges::find(list, name, member) - list.begin();
    };
    std::ranges::stable_sort(rows, {}, [&](const Row& row) {
        return std::tuple(rank(record.scenes, row.scene, &RunRecord::SceneEntry::id), row.frame,
                          rank(record.settings, row.setting, &RunRecord::SettingEntry::name));
    });
    std::string text = csvHeader() + "\n";
    for (const Row& row : rows) text += toCsv(row) + "\n";
    writeFileAtomically(folder.results(), text);
    // A verdict on other rows is none on these.
    std::filesystem::remove(folder.gate());
}

void writeArtefacts(const RunFolder& folder, const std::string& curveMetric) {
    const RunRecord record = readRecord(folder, curveMetric);
    const std::vector<Row> rows = readCsv(folder.results());
    const int stride = pageStride(imagePixels(rows));
    std::vector<PageScene> scenes(record.scenes.size());
    // One at a time, for a long scene shall not wait behind short ones; each holds its images.
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, scenes.size(), 1),
        [&](const tbb::blocked_range<std::size_t>& range) {
            for (std::size_t i = range.begin(); i != range.end(); ++i)
                scenes[i] = drawScene(folder, record, i, rows, stride);
        },
        tbb::simple_partitioner());
    writeCurves(folder, record, rows);
    if (std::filesystem::exists(folder.effectsCsv()))
        writeFileAtomically(folder.effectsTable(),
                            effectsTableMarkdown(readEffectsCsv(folder.effectsCsv())));
    writeFileAtomically(folder.benchmark(), benchmarkJson(rows));
    writeReportPage(folder, record, rows, scenes, stride);
    writeSummary(folder, curveMetric);
}

void writeSummary(const RunFolder& folder, const std::string& curveMetric) {
    const RunRecord record = readRecord(folder, curveMetric);
    SummaryInput input;
    input.provenance = record.provenance;
    input.provenance.emplace_back("command", record.command);
    if (record.fetches.nearestPerS > 0.0)
        input.provenance.emplace_back(
            "fetches",
            fmt::format("{} nearest/s, {} compare/s", markdown::count(record.fetches.nearestPerS),
                        markdown::count(record.fetches.comparePerS)));
    input.rows = readCsv(folder.results());
    input.studies = studiesOf(input.rows, record);
    input.costMetric = record.curveMetric;
    input.references = record.references;
    input.analysis = record.analysis;
    input.phases = record.phases;
    input.skippedScenes = record.skippedScenes;
    std::string text = summaryMarkdown(input);
    if (std::filesystem::exists(folder.paired()))
        text += pairedMarkdown(readPairedCsv(folder.paired()), input.rows, record.settings);
    if (std::filesystem::exists(folder.stress())) text += asSection(readTextFile(folder.stress()));
    if (std::filesystem::exists(folder.gate())) text += asSection(readTextFile(folder.gate()));
    writeFileAtomically(folder.summary(), text);
}

}  // namespace penumbra
