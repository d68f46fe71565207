#include "harness/study/curve.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "methods/shadow_method.hpp"

namespace penumbra {
namespace {

/// Through what of the points no other is better than in time and error; they come from fast to
/// slow.
std::vector<glm::dvec2> ownFront(const std::vector<PlotPoint>& points) {
    std::vector<glm::dvec2> line;
    for (const PlotPoint& p : points)
        if (line.empty() || p.y < line.back().y) line.emplace_back(p.x, p.y);
    return line;
}

std::string seriesLabel(const CostStudy& study, const std::string& method, std::size_t least,
                        std::size_t most) {
    if (least == study.frames) return method;
    return least == most
               ? fmt::format("{} ({} of {} frames)", method, least, study.frames)
               : fmt::format("{} ({} to {} of {} frames)", method, least, most, study.frames);
}

}  // namespace

std::map<std::string, int> methodStyles(const std::vector<CostStudy>& studies) {
    std::map<std::string, int> styles;
    for (const MethodInfo& info : methodRegistry())
        styles.emplace(info.id, static_cast<int>(styles.size()));
    std::set<std::string> others;
    for (const CostStudy& study : studies)
        for (const CostPoint& p : study.points)
            if (!styles.contains(p.method)) others.insert(p.method);
    for (const std::string& method : others)
        styles.emplace(method, static_cast<int>(styles.size()));
    return styles;
}

Plot curvePlot(const CostStudy& study, const std::string& metric,
               const std::map<std::string, int>& styles) {
    const bool suite = study.scene == kWholeSuite;
    const std::string error = errorName(metric);
    Plot plot;
    plot.title = suite ? fmt::format("What accuracy costs over {} scenes", study.scenes)
                       : fmt::format("What accuracy costs: {}", study.scene);
    plot.note =
        "Filled, on the broad line: surely faster than everything more accurate. Bars: 95 % "
        "intervals of the time.";
    plot.xLabel = suite || study.frames > 1
                      ? fmt::format("frame time (ms), mean over {} frames", study.frames)
                      : "frame time (ms)";
    plot.yLabel = suite ? fmt::format("{}, root mean square over frames", error) : error;
    plot.floor = study.floor;
    plot.floorLabel = "the reference's own error";

    std::map<std::string, std::vector<const CostPoint*>> byMethod;
    for (const CostPoint& p : study.points) byMethod[p.method].push_back(&p);
    std::vector<const CostPoint*> front;
    for (const auto& [method, points] : byMethod) {
        PlotSeries series;
        series.style = styles.at(method);
        std::size_t least = study.frames, most = 0;
        for (const CostPoint* p : points) {
            least = std::min(least, p->frames);
            most = std::max(most, p->frames);
            series.points.push_back({p->ms, p->error, p->lowMs, p->highMs, p->onFront});
            if (p->onFront && study.covers(*p)) front.push_back(p);
        }
        series.label = seriesLabel(study, method, least, most);
        series.dashed = least < study.frames;
        series.line = ownFront(series.points);
        plot.series.push_back(std::move(series));
    }
    std::ranges::sort(front, {}, [](const CostPoint* p) { return std::pair(p->ms, -p->error); });
    for (const CostPoint* p : front) plot.band.emplace_back(p->ms, p->error);
    return plot;
}

}  // namespace penumbra
