#include "harness/report/report.hpp"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <deque>
#include <map>
#include <set>

#include "core/error.hpp"
#include "core/image/image.hpp"
#include "harness/report/benchmark.hpp"
#include "harness/report/grid.hpp"
#include "harness/report/markdown.hpp"
#include "harness/report/page_image.hpp"
#include "harness/report/report_page.hpp"
#include "harness/report/summary.hpp"
#include "harness/run/csv.hpp"
#include "harness/run/files.hpp"
#include "harness/run/row_check.hpp"
#include "harness/study/curve.hpp"
#include "harness/study/effects_table.hpp"
#include "harness/study/paired_report.hpp"

namespace penumbra {
namespace {

/// V of the row's image; empty where it has none, as in a folder that was sent without images.
std::vector<float> visibilityOf(const RunFolder& folder, const Row& row, const GBuffer& gbuffer) {
    const std::filesystem::path path = folder.setting(row.scene, row.frame, row.setting);
    if (row.status != "ok" || !std::filesystem::exists(path)) return {};
    std::vector<float> visibility = folder.readVisibility(row.scene, row.frame, row.setting);
    if (visibility.size() != gbuffer.size())
        throw InputError(fmt::format("{}: {} pixels, the frame's gbuffer.exr has {}", path.string(),
                                     visibility.size(), gbuffer.size()));
    return visibility;
}

/// Writes grid/<scene>.png; what the page shows of the scene, `sceneIndex` of the record, comes
/// from the same images. Frames that the folder has no truth of are left out.
PageScene drawScene(const RunFolder& folder, const RunRecord& record, std::size_t sceneIndex,
                    const std::vector<Row>& rows, int stride) {
    const RunRecord::SceneEntry& scene = record.scenes[sceneIndex];
    std::set<int> frames;
    for (const Row& row : rows)
        if (row.scene == scene.id) frames.insert(row.frame);
    if (frames.empty()) return {};
    std::erase_if(frames, [&](int frame) {
        const std::filesystem::path images = folder.images(scene.id, frame);
        return !std::filesystem::exists(images / "gbuffer.exr") ||
               !std::filesystem::exists(images / "reference.exr");
    });
    if (frames.empty()) {
        // An earlier report may have drawn what is no longer there.
        std::filesystem::remove(folder.grid(scene.id));
        return {};
    }

    std::deque<GBuffer> gbuffers;
    std::deque<Reference> references;
    std::vector<GridFrame> grid;
    for (const int frame : frames) {
        const GBuffer& gbuffer = gbuffers.emplace_back(folder.readGBuffer(scene.id, frame));
        references.push_back(folder.readReference(scene.id, frame));
        GridFrame g{frame, &gbuffer, &references.back(), {}};
        for (const Row& row : rows)
            if (row.scene == scene.id && row.frame == frame)
                g.cells.push_back({&row, visibilityOf(folder, row, gbuffer)});
        grid.push_back(std::move(g));
    }
    std::filesystem::create_directories(folder.grid(scene.id).parent_path());
    const GridPicture picture = renderGrid(scene.id, scene.shows, grid);
    writePngBytes(folder.grid(scene.id), picture.width, picture.height, picture.rgb);

    PageScene page;
    for (const GridFrame& frame : grid) {
        std::vector<std::size_t> withImage;
        for (const GridCell& cell : frame.cells)
            if (!cell.visibility.empty())
                withImage.push_back(static_cast<std::size_t>(cell.row - rows.data()));
        page.frames.push_back(
            {frame.index, frame.gbuffer->width, frame.gbuffer->height, std::move(withImage)});
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
    tbb::parallel_for(std::size_t{0}, studies.size(), [&](std::size_t i) {
        const Plot plot = curvePlot(studies[i], record.curveMetric, styles);
        const std::filesystem::path path = folder.curve(studies[i].scene);
        writeFileAtomically(std::filesystem::path(path).concat(".svg"), plotSvg(plot));
        writeFileAtomically(std::filesystem::path(path).concat(".png"), plotPng(plot));
    });
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
    const std::vector<Row> rows = readCheckedCsv(folder.results());
    if (std::filesystem::exists(folder.effectsCsv()))
        writeFileAtomically(folder.effectsTable(),
                            effectsTableMarkdown(readEffectsCsv(folder.effectsCsv())));
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
    writeFileAtomically(folder.benchmark(), benchmarkJson(rows));
    writeReportPage(folder, record, rows, scenes, stride);
    writeSummary(folder, curveMetric);
}

void writeSummary(const RunFolder& folder, const std::string& curveMetric) {
    const RunRecord record = readRecord(folder, curveMetric);
    SummaryInput input;
    input.provenance = record.provenance;
    input.provenance.emplace_back("command", record.command);
    if (!record.finished)
        input.provenance.emplace_back("unfinished",
                                      "cells without a row are left for compare --resume");
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
    const std::filesystem::path claims = folder.root() / "claims.md";
    if (std::filesystem::exists(claims)) text += asSection(readTextFile(claims));
    if (std::filesystem::exists(folder.stress())) text += asSection(readTextFile(folder.stress()));
    if (std::filesystem::exists(folder.gate())) text += asSection(readTextFile(folder.gate()));
    writeFileAtomically(folder.summary(), text);
}

}  // namespace penumbra
