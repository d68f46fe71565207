#include "harness/gate/history_page.hpp"

#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>

#include "harness/gate/series.hpp"
#include "harness/report/page.hpp"
#include "harness/run/csv.hpp"
#include "harness/run/files.hpp"

namespace penumbra::gate {
namespace {

using Json = nlohmann::ordered_json;

Json approvalsJson(const std::vector<Approval>& approvals) {
    Json list = Json::array();
    for (const Approval& a : approvals)
        list.push_back(
            {{"when", a.when},
             {"who", a.who},
             {"commit", a.commit},
             {"reason", a.reason},
             {"machine", fmt::format("{}, {} threads, {}", a.renderer, a.threads, a.machine)},
             {"changes", a.changes.size()}});
    return list;
}

Json seriesJson(const std::vector<Series>& all) {
    Json list = Json::array();
    for (const Series& s : all) {
        Json values = Json::array(), steps = Json::array();
        for (const auto& value : s.values) values.push_back(value ? Json(*value) : Json());
        for (const Step& step : s.steps)
            steps.push_back({{"at", step.at}, {"before", step.before}, {"after", step.after}});
        list.push_back({{"scene", s.scene},
                        {"frame", s.frame},
                        {"setting", s.setting},
                        {"metric", s.metric},
                        {"values", std::move(values)},
                        {"steps", std::move(steps)}});
    }
    return list;
}

}  // namespace

std::string historyPage(const std::vector<Approval>& approvals) {
    const PageSource source{.title = "Penumbra: history of the baseline",
                            .markup = "history.html",
                            .styles = {"history.css"},
                            .script = "history.js",
                            .charts = true};
    const std::array data = {jsonData("approval-data", approvalsJson(approvals)),
                             jsonData("series-data", seriesJson(seriesOf(approvals)))};
    const PageShell shell = pageShell(source, data);
    return shell.head + shell.tail;
}

int writeHistoryPage(const std::filesystem::path& history, const std::filesystem::path& out) {
    std::vector<Approval> approvals = readHistory(history);
    const std::filesystem::path baseline = history.parent_path() / "baseline.csv";
    if (std::filesystem::exists(baseline)) dropUnborn(approvals, readTextFile(baseline));
    const std::filesystem::path page = out.empty() ? history.parent_path() / "history.html" : out;
    writeFileAtomically(page, historyPage(approvals));
    fmt::print("{}\n", std::filesystem::absolute(page).lexically_normal().string());
    return 0;
}

}  // namespace penumbra::gate
