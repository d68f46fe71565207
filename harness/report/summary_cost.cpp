#include "harness/report/summary_cost.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "harness/report/markdown.hpp"

namespace penumbra {

using namespace markdown;

namespace {

constexpr std::array kErrors = {0.1, 0.05, 0.02, 0.01, 0.005};
constexpr std::array kBudgets = {1, 2, 5, 10, 50};

/// The parameters in which a method's settings differ, for it is they that tell them apart: the
/// others are the same in every line.
class TellingParameters {
  public:
    explicit TellingParameters(const std::vector<CostStudy>& studies) {
        for (const CostStudy& study : studies)
            for (const CostPoint& p : study.points)
                for (const std::string& one : split(p.params))
                    seen_[p.method][idOf(one)].insert(one);
    }
    std::string operator()(const CostPoint& p) const {
        std::string text;
        for (const std::string& one : split(p.params))
            if (seen_.at(p.method).at(idOf(one)).size() > 1)
                text += (text.empty() ? "" : ", ") + one;
        return text;
    }

  private:
    static std::string idOf(const std::string& assignment) {
        return assignment.substr(0, assignment.find('='));
    }
    static std::vector<std::string> split(const std::string& params) {
        std::vector<std::string> parts;
        for (std::size_t begin = 0; begin < params.size();) {
            const std::size_t end = std::min(params.find(';', begin), params.size());
            parts.push_back(params.substr(begin, end - begin));
            begin = end + 1;
        }
        return parts;
    }
    std::map<std::string, std::map<std::string, std::set<std::string>>> seen_;
};

std::string timeOf(const CostPoint& p) {
    return fmt::format("{} [{}, {}]", number(p.ms), number(p.lowMs), number(p.highMs));
}

std::string title(const CostStudy& study) {
    return study.scene == kWholeSuite ? "**all scenes**" : escaped(study.scene);
}

/// The suite before its scenes.
std::vector<const CostStudy*> suiteFirst(const std::vector<CostStudy>& studies) {
    std::vector<const CostStudy*> order;
    for (const CostStudy& study : studies) order.push_back(&study);
    std::ranges::stable_partition(
        order, [](const CostStudy* study) { return study->scene == kWholeSuite; });
    return order;
}

std::string folded(const std::string& what, const std::string& body) {
    return fmt::format("<details><summary>{}</summary>\n\n{}</details>\n\n", what, body);
}

/// On the front, from fast to slow, with what half of each one's error costs.
std::vector<Cells> frontLines(const CostStudy& study, const TellingParameters& parameters) {
    std::vector<const CostPoint*> front;
    for (const CostPoint& p : study.points)
        if (p.onFront && study.covers(p)) front.push_back(&p);
    std::ranges::stable_sort(front, {}, [](const CostPoint* p) { return p->ms; });
    const CostPoint* unit = costUnit(study);
    std::vector<Cells> lines;
    for (const CostPoint* p : front) {
        const CostPoint* half = cheapestReaching(study, 0.5 * p->error);
        lines.push_back({title(study), escaped(p->setting), escaped(parameters(*p)),
                         number(p->error), timeOf(*p), unit ? number(p->ms / unit->ms) : "",
                         half ? number(half->ms / p->ms) : "none",
                         half ? escaped(half->setting) : ""});
    }
    return lines;
}

std::string fronts(const std::vector<const CostStudy*>& studies, const std::string& error,
                   const TellingParameters& parameters) {
    const auto asTable = [&](const std::vector<Cells>& lines) {
        return table({"scene", "setting", "parameters", error, "ms [95 % interval]",
                      fmt::format("time / {}", kCostUnit), "time of half the error / this", "by"},
                     3, lines);
    };
    std::string out = "### The front, and what the next halving of error costs\n\n" +
                      asTable(frontLines(*studies.front(), parameters));
    std::vector<Cells> lines;
    for (std::size_t i = 1; i < studies.size(); ++i)
        for (Cells& line : frontLines(*studies[i], parameters)) lines.push_back(std::move(line));
    return lines.empty() ? out : out + folded("The fronts of the scenes", asTable(lines));
}

Cells reachingLine(const CostStudy& study, const std::string& name, const std::string& method) {
    Cells line = {name};
    for (const double error : kErrors) {
        const CostPoint* p = cheapestReaching(study, error, method);
        line.push_back(p ? fmt::format("{} ms {}", number(p->ms), escaped(p->setting)) : "–");
    }
    return line;
}

std::string reaching(const std::vector<const CostStudy*>& studies, const std::string& error) {
    Cells header = {""};
    for (const double least : kErrors) header.push_back(fmt::format("{} ≤ {}", error, least));
    std::vector<Cells> ofScenes, ofMethods;
    for (const CostStudy* study : studies)
        ofScenes.push_back(reachingLine(*study, title(*study), ""));
    std::set<std::string> methods;
    for (const CostPoint& p : studies.front()->points) methods.insert(p.method);
    for (const std::string& method : methods)
        ofMethods.push_back(reachingLine(*studies.front(), escaped(method), method));
    header.front() = "scene";
    std::string out = fmt::format("### The cheapest setting that reaches an error\n\n{}",
                                  table(header, header.size(), ofScenes));
    header.front() = "method";
    return out + fmt::format("By method, over {}:\n\n{}", title(*studies.front()),
                             table(header, header.size(), ofMethods));
}

std::string within(const std::vector<const CostStudy*>& studies, const std::string& error) {
    Cells header = {"scene", fmt::format("{}, ms", kCostUnit)};
    for (const int times : kBudgets) header.push_back(fmt::format("{}×", times));
    std::vector<Cells> lines;
    for (const CostStudy* study : studies) {
        const CostPoint* unit = costUnit(*study);
        if (!unit) continue;
        Cells line = {title(*study), number(unit->ms)};
        for (const int times : kBudgets) {
            const CostPoint* p = bestWithin(*study, times * unit->ms);
            line.push_back(p ? number(p->error) + " " + escaped(p->setting) : "–");
        }
        lines.push_back(std::move(line));
    }
    if (lines.empty()) return {};
    return fmt::format("### The least {} within a multiple of the time of `{}`\n\n{}", error,
                       kCostUnit, table(header, header.size(), lines));
}

std::string uncovered(const CostStudy& study) {
    std::string list;
    for (const CostPoint& p : study.points)
        if (!study.covers(p))
            list += fmt::format("- {}: {} of {} frames, {} of {} scenes{}\n", escaped(p.setting),
                                p.frames, study.frames, p.scenes, study.scenes,
                                p.onFront ? "; nothing more accurate is as fast there" : "");
    return list.empty()
               ? list
               : "Not in these tables of all scenes, for they lack frames:\n\n" + list + '\n';
}

}  // namespace

std::string costMarkdown(const std::vector<CostStudy>& studies, const std::string& metric) {
    if (studies.empty()) return {};
    const std::vector<const CostStudy*> order = suiteFirst(studies);
    const TellingParameters parameters(studies);
    const std::string error = errorName(metric);
    return "## What accuracy costs\n\n"
           "Curves: curve/, points: pareto.csv. In a scene " +
           error +
           " is the mean over its frames, over all scenes the root mean square over all frames; ms "
           "is the mean frame time. On the front is what is surely faster (beyond the noise of the "
           "difference) than "
           "everything more accurate.\n\n" +
           uncovered(*order.front()) + fronts(order, error, parameters) + reaching(order, error) +
           within(order, error);
}

}  // namespace penumbra
