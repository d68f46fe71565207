#include "harness/report/report_page.hpp"

#include <fmt/format.h>

#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <stdexcept>

#include "core/error.hpp"
#include "harness/metrics/metrics.hpp"
#include "harness/report/page.hpp"
#include "harness/report/page_image.hpp"
#include "harness/report/shade.hpp"
#include "harness/run/csv.hpp"
#include "harness/run/files.hpp"
#include "harness/run/provenance.hpp"
#include "harness/run/separation.hpp"
#include "harness/run/settings.hpp"
#include "methods/shadow_method.hpp"

namespace penumbra {
namespace {

using Json = nlohmann::ordered_json;

bool isNumeric(std::string_view column) {
    try {
        numberInColumn(Row{}, column);
        return true;
    } catch (const std::invalid_argument&) {
        return false;
    }
}

/// results.csv by column: numbers as they are, of texts each only once.
Json columnsJson(const std::vector<Row>& rows) {
    std::string csv = csvHeader() + '\n';
    for (const Row& row : rows) csv += toCsv(row) + '\n';
    const std::vector<CsvRecord> records = splitCsv(csv, "results.csv").complete;
    Json columns = Json::array();
    for (std::size_t c = 0; c < records.front().fields.size(); ++c) {
        const std::string& name = records.front().fields[c];
        Json column = {{"name", name}};
        if (isNumeric(name)) {
            Json& values = column["values"] = Json::array();
            for (const Row& row : rows) {
                const std::optional<double> value = numberInColumn(row, name);
                values.push_back(value ? Json(*value) : Json());
            }
        } else {
            std::map<std::string, std::size_t> seen;
            Json texts = Json::array(), index = Json::array();
            for (std::size_t r = 1; r < records.size(); ++r) {
                const std::string& text = records[r].fields[c];
                const auto [at, isNew] = seen.emplace(text, seen.size());
                if (isNew) texts.push_back(text);
                index.push_back(at->second);
            }
            column["texts"] = std::move(texts);
            column["index"] = std::move(index);
        }
        columns.push_back(std::move(column));
    }
    return columns;
}

std::vector<std::string> splitAt(const std::string& text, char separator) {
    std::vector<std::string> parts;
    for (std::size_t begin = 0; begin < text.size();) {
        const std::size_t end = std::min(text.find(separator, begin), text.size());
        parts.push_back(text.substr(begin, end - begin));
        begin = end + 1;
    }
    return parts;
}

/// What `--set` needs to hear: the parameters that differ from their defaults, or all of a method
/// or parameter that this version does not know.
std::vector<std::string> assignmentsOf(const RunRecord::SettingEntry& setting) {
    if (setting.method == kSeparation) return {};
    std::vector<std::string> all = splitAt(setting.params, ';');
    try {
        std::vector<std::string> some;
        const std::string text =
            setting.params.empty() ? setting.method : setting.method + ':' + setting.params;
        for (const auto& [parameter, value] : parseSetting("run.json", text).assignments)
            some.push_back(parameter + '=' + value);
        return some;
    } catch (const InputError&) {
        return all;
    }
}

Json settingsJson(const std::vector<RunRecord::SettingEntry>& settings) {
    Json out = Json::array();
    for (const RunRecord::SettingEntry& setting : settings)
        out.push_back({{"name", setting.name},
                       {"method", setting.method},
                       {"params", setting.params},
                       {"sets", assignmentsOf(setting)}});
    return out;
}

/// In the order that gives a method its colour in curve/ too.
Json methodsJson() {
    Json out = Json::array();
    for (const MethodInfo& info : methodRegistry())
        out.push_back({{"id", info.id}, {"title", info.title}, {"source", info.source}});
    return out;
}

Json scenesJson(const RunRecord& record, const std::vector<PageScene>& scenes) {
    Json out = Json::array();
    for (std::size_t i = 0; i < record.scenes.size(); ++i) {
        const RunRecord::SceneEntry& scene = record.scenes[i];
        Json frames = Json::array();
        for (const PageScene::Frame& frame : scenes[i].frames)
            frames.push_back({{"index", frame.index},
                              {"width", frame.width},
                              {"height", frame.height},
                              {"rows", frame.rows}});
        out.push_back({{"id", scene.id},
                       {"shows", scene.shows},
                       {"figure", scene.figure},
                       {"source", scene.source},
                       {"chosen", scene.chosen},
                       {"frames", std::move(frames)}});
    }
    return out;
}

Json referencesJson(const std::vector<ReferenceStats>& references) {
    Json out = Json::array();
    for (const ReferenceStats& r : references) {
        Json one = {{"scene", r.scene},
                    {"frame", r.frame},
                    {"rays", r.rays},
                    {"seconds", r.seconds},
                    {"cached", r.cached},
                    {"scored_pixels", r.scoredPixels},
                    {"penumbra_pixels", r.penumbraPixels}};
        if (r.checked.pixels > 0)
            one["checked"] = {{"pixels", r.checked.pixels},
                              {"coverage", r.checked.coverage()},
                              {"rmse", r.checked.rmse()},
                              {"worst", r.checked.worst}};
        out.push_back(std::move(one));
    }
    return out;
}

Json analysisJson(const std::vector<EffectsRecord>& analysis) {
    Json out = Json::array();
    for (const EffectsRecord& record : analysis) {
        Json effects = Json::array();
        for (const EffectInfo& info : allEffects()) {
            const EffectFinding& finding = record.findings[info.effect];
            effects.push_back({{"effect", info.id},
                               {"called_for", finding.calledFor},
                               {"evidence", finding.evidence}});
        }
        out.push_back({{"scene", record.scene},
                       {"frame", record.frame},
                       {"load_ms", record.loadMs},
                       {"analysis_ms", record.analysisMs},
                       {"effects", std::move(effects)}});
    }
    return out;
}

Json metricsJson() {
    Json out = Json::array();
    for (const MetricInfo& metric : allMetrics())
        out.push_back({{"id", metric.id}, {"unit", metric.unit}, {"doc", metric.doc}});
    return out;
}

Json pairsJson(const std::vector<std::pair<std::string, std::string>>& pairs) {
    Json out = Json::array();
    for (const auto& [name, value] : pairs) out.push_back({name, value});
    return out;
}

/// paired.csv and the like as they are: header and lines of texts.
Json tablesJson(const RunFolder& folder) {
    Json out = Json::object();
    for (const char* name : {"paired", "stress", "claims", "effects"}) {
        const std::filesystem::path path = folder.root() / fmt::format("{}.csv", name);
        if (!std::filesystem::exists(path)) continue;
        Json lines = Json::array();
        const std::vector<CsvRecord> records = splitCsv(readTextFile(path), path.string()).complete;
        for (const CsvRecord& record : records) {
            if (record.fields.size() != records.front().fields.size())
                throw InputError(fmt::format("{}:{}: {} fields, expected {}", path.string(),
                                             record.line, record.fields.size(),
                                             records.front().fields.size()));
            lines.push_back(record.fields);
        }
        if (!lines.empty()) out[name] = std::move(lines);
    }
    return out;
}

/// A colour that canvases take, of linear values.
Json colourJson(const glm::vec3& linear) {
    Json out = Json::array();
    for (int c = 0; c < 3; ++c) out.push_back(srgb8(linear[c]));
    return out;
}

/// The scale of the error maps, as grid/ has it: colours at equal steps from -kErrorScale to
/// +kErrorScale.
Json errorColoursJson() {
    constexpr int kSteps = 256;
    Json out = Json::array();
    for (int i = 0; i <= kSteps; ++i)
        out.push_back(
            colourJson(errorColour(kErrorScale * (2.0F * static_cast<float>(i) / kSteps - 1.0F))));
    return out;
}

Json runJson(const RunFolder& folder, const RunRecord& record, const std::vector<Row>& rows,
             const std::vector<PageScene>& scenes, int stride) {
    Json classes = Json::array();
    for (const ClassColour& c : classColours())
        classes.push_back({{"name", c.name}, {"colour", colourJson(c.rgb)}});
    return {{"name", std::filesystem::weakly_canonical(folder.root()).filename().string()},
            {"command", record.command},
            {"finished", record.finished},
            {"width", record.width},
            {"height", record.height},
            {"repeats", record.repeats},
            {"seed", record.seed},
            {"reference", record.reference},
            {"reference_se", record.referenceSe},
            {"effects", splitAt(record.effects, ' ')},
            {"provenance", pairsJson(record.provenance)},
            {"clock",
             {{"fenced_ms", record.fencedClockMs},
              {"timer_query_ms", record.queryClockMs},
              {"timer_queries_trusted", record.timerQueriesTrusted}}},
            {"skipped_scenes", pairsJson(record.skippedScenes)},
            {"curve_metric", record.curveMetric},
            {"external_renderer", kExternalRenderer},
            {"separation", kSeparation},
            {"least_coverage", Certificate::kLeastCoverage},
            {"most_coverage", Certificate::kMostCoverage},
            {"methods", methodsJson()},
            {"metrics", metricsJson()},
            {"scenes", scenesJson(record, scenes)},
            {"settings", settingsJson(record.settings)},
            {"references", referencesJson(record.references)},
            {"analysis", analysisJson(record.analysis)},
            {"tables", tablesJson(folder)},
            {"stride", stride},
            {"planes",
             {{"visibility", kPlaneVisibility},
              {"standard_error", kPlaneStandardError},
              {"zero", kPlaneZero}}},
            {"error_scale", kErrorScale},
            {"error_colours", errorColoursJson()},
            {"class_colours", std::move(classes)},
            {"columns", columnsJson(rows)}};
}

}  // namespace

void writeReportPage(const RunFolder& folder, const RunRecord& record, const std::vector<Row>& rows,
                     const std::vector<PageScene>& scenes, int stride) {
    const std::array data{jsonData("run", runJson(folder, record, rows, scenes, stride))};
    const PageShell shell = pageShell({.title = "Penumbra report",
                                       .markup = "report.html",
                                       .styles = {"report.css", "compare.css"},
                                       .script = "report.js",
                                       .charts = true},
                                      data);
    std::string page = shell.head;
    page.reserve(std::accumulate(
        scenes.begin(), scenes.end(), shell.head.size() + shell.tail.size(),
        [](std::size_t sum, const PageScene& scene) { return sum + scene.images.size(); }));
    for (const PageScene& scene : scenes) page += scene.images;
    writeFileAtomically(folder.page(), page + shell.tail);
}

}  // namespace penumbra
