#include "harness/study/plot_layout.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace penumbra {
namespace {

constexpr PlotBox kArea{{84, 74}, {kPlotWidth - 20, kPlotHeight - 58}};
/// Between the axes and the data: room for labels at the ends of lines, most of all at the right.
constexpr glm::dvec2 kRoomLow{26, 22}, kRoomHigh{130, 26};
constexpr double kDot = 6.0;       ///< half the size that a dot keeps free
constexpr double kLabelGap = 2.0;  ///< between labels
constexpr double kLeaderFrom = 20.0;

struct Segment {
    glm::dvec2 a, b;
};

/// Liang and Barsky: whether any of the segment lies in the box.
bool crosses(const Segment& s, const PlotBox& box) {
    double enter = 0.0, leave = 1.0;
    const glm::dvec2 d = s.b - s.a;
    for (int axis = 0; axis < 2; ++axis) {
        if (d[axis] == 0.0) {
            if (s.a[axis] < box.lo[axis] || s.a[axis] > box.hi[axis]) return false;
            continue;
        }
        double t0 = (box.lo[axis] - s.a[axis]) / d[axis];
        double t1 = (box.hi[axis] - s.a[axis]) / d[axis];
        if (t0 > t1) std::swap(t0, t1);
        enter = std::max(enter, t0);
        leave = std::min(leave, t1);
    }
    return enter <= leave;
}

/// What labels should not cover.
struct Obstacles {
    std::vector<PlotBox> dots;
    std::vector<Segment> lines, whiskers;

    double costOf(const PlotBox& box) const {
        double cost = 0.0;
        for (const PlotBox& dot : dots) cost += dot.overlaps(box) ? 8.0 : 0.0;
        for (const Segment& line : lines) cost += crosses(line, box) ? 4.0 : 0.0;
        for (const Segment& whisker : whiskers) cost += crosses(whisker, box) ? 3.0 : 0.0;
        return cost;
    }
};

void addLine(std::vector<Segment>& segments, const std::vector<glm::dvec2>& line,
             const PlotLayout& layout) {
    for (std::size_t i = 1; i < line.size(); ++i)
        segments.push_back({layout.place(line[i - 1]), layout.place(line[i])});
}

Obstacles obstaclesOf(const Plot& plot, const PlotLayout& layout) {
    Obstacles obstacles;
    for (const PlotSeries& series : plot.series) {
        addLine(obstacles.lines, series.line, layout);
        for (const PlotPoint& p : series.points) {
            const glm::dvec2 at = layout.place({p.x, p.y});
            obstacles.dots.push_back({at - kDot, at + kDot});
            obstacles.whiskers.push_back({{layout.x(p.xLow), at.y}, {layout.x(p.xHigh), at.y}});
        }
    }
    addLine(obstacles.lines, plot.band, layout);
    if (plot.floor) {
        const double y = layout.y(*plot.floor);
        obstacles.lines.push_back({{layout.area.lo.x, y}, {layout.area.hi.x, y}});
    }
    return obstacles;
}

/// Finds room for one label after another.
class Placer {
  public:
    Placer(const Obstacles& obstacles, PlotLayout& layout)
        : obstacles_(obstacles), layout_(layout) {}

    /// Beside one of the series' anchors, the last of them for choice; where all that is taken,
    /// anywhere.
    void place(PlotLabel label, glm::dvec2 size, const std::vector<glm::dvec2>& anchors) {
        best_ = std::numeric_limits<double>::infinity();
        chosen_ = label;
        for (std::size_t i = 0; i < anchors.size(); ++i)
            for (const double distance : {9.0, 14.0, 22.0, 34.0, 50.0, 70.0})
                for (int dx = -1; dx <= 1; ++dx)
                    for (int dy = -1; dy <= 1; ++dy) {
                        if (dx == 0 && dy == 0) continue;
                        const glm::dvec2 away(dx, dy);
                        label.anchor = anchors[i];
                        consider(label, anchors[i] + away * (distance + 0.5 * size), size,
                                 0.1 * distance + (i + 1 == anchors.size() ? 0.0 : 1.0) +
                                     (dy == 0 ? 0.0 : 0.3));
                    }
        constexpr double kStep = 6.0;
        if (std::isinf(best_))
            for (double y = layout_.area.lo.y; y < layout_.area.hi.y; y += kStep)
                for (double x = layout_.area.lo.x; x < layout_.area.hi.x; x += kStep) {
                    label.anchor = anchors.back();
                    const glm::dvec2 centre = glm::dvec2(x, y) + 0.5 * size;
                    consider(label, centre, size, 0.1 * glm::distance(centre, label.anchor));
                }
        layout_.labels.push_back(chosen_);
    }

  private:
    void consider(PlotLabel& label, glm::dvec2 centre, glm::dvec2 size, double cost) {
        label.box = {centre - 0.5 * size, centre + 0.5 * size};
        if (!layout_.area.contains(label.box)) return;
        const PlotBox apart{label.box.lo - kLabelGap, label.box.hi + kLabelGap};
        for (const PlotLabel& other : layout_.labels)
            if (other.box.overlaps(apart)) return;
        cost += obstacles_.costOf(label.box);
        if (cost >= best_) return;
        best_ = cost;
        const glm::dvec2 nearest = glm::clamp(label.anchor, label.box.lo, label.box.hi);
        label.leader = glm::distance(nearest, label.anchor) > kLeaderFrom;
        chosen_ = label;
    }

    const Obstacles& obstacles_;
    PlotLayout& layout_;
    PlotLabel chosen_;
    double best_ = 0.0;
};

/// Dots and the middles between them.
std::vector<glm::dvec2> anchorsOf(const PlotSeries& series, const PlotLayout& layout) {
    std::vector<glm::dvec2> anchors;
    for (const glm::dvec2& value : series.line) {
        const glm::dvec2 at = layout.place(value);
        if (!anchors.empty()) anchors.push_back(0.5 * (anchors.back() + at));
        anchors.push_back(at);
    }
    if (anchors.empty())
        for (const PlotPoint& p : series.points) anchors.push_back(layout.place({p.x, p.y}));
    return anchors;
}

}  // namespace

LogAxis::LogAxis(const std::vector<double>& values, double from, double to)
    : logLow_(std::numeric_limits<double>::infinity()), logHigh_(-logLow_), from_(from), to_(to) {
    for (const double value : values) {
        if (!(value > 0.0)) continue;
        logLow_ = std::min(logLow_, std::log10(value));
        logHigh_ = std::max(logHigh_, std::log10(value));
    }
    if (logLow_ > logHigh_) logLow_ = logHigh_ = 0.0;
    // Less than half a decade would make much of very little.
    constexpr double kLeastDecades = 0.5;
    const double missing = std::max(0.0, kLeastDecades - (logHigh_ - logLow_));
    logLow_ -= 0.5 * missing;
    logHigh_ += 0.5 * missing;
}

double LogAxis::operator()(double value) const {
    const double log = value > 0.0 ? std::max(std::log10(value), logLow_) : logLow_;
    return from_ + (log - logLow_) / (logHigh_ - logLow_) * (to_ - from_);
}

std::vector<double> LogAxis::ticks(double from, double to) const {
    const double perUnit = (logHigh_ - logLow_) / (to_ - from_);
    double low = logLow_ + (from - from_) * perUnit, high = logLow_ + (to - from_) * perUnit;
    if (low > high) std::swap(low, high);
    const bool few = high - low > 3.5;
    std::vector<double> ticks;
    for (int decade = static_cast<int>(std::floor(low)); decade <= high; ++decade)
        for (const int times : {1, 2, 5}) {
            const double value = times * std::pow(10.0, decade);
            const double log = std::log10(value);
            if ((times == 1 || !few) && log >= low && log <= high) ticks.push_back(value);
        }
    return ticks;
}

PlotLayout layOut(const Plot& plot, const std::function<glm::dvec2(const std::string&)>& textSize) {
    std::vector<double> xs, ys;
    for (const PlotSeries& series : plot.series)
        for (const PlotPoint& p : series.points) {
            xs.insert(xs.end(), {p.x, p.xLow, p.xHigh});
            ys.push_back(p.y);
        }
    if (plot.floor) ys.push_back(*plot.floor);
    PlotLayout layout{kArea,
                      LogAxis(xs, kArea.lo.x + kRoomLow.x, kArea.hi.x - kRoomHigh.x),
                      LogAxis(ys, kArea.hi.y - kRoomHigh.y, kArea.lo.y + kRoomLow.y),
                      {}};
    const Obstacles obstacles = obstaclesOf(plot, layout);
    if (plot.floor) {
        const glm::dvec2 size = textSize(plot.floorLabel);
        const glm::dvec2 at(layout.area.lo.x + 6.0, layout.y(*plot.floor) + 2.0);
        layout.labels.push_back({plot.floorLabel, -1, {at, at + size}, at, false});
    }
    Placer placer(obstacles, layout);
    for (std::size_t i = 0; i < plot.series.size(); ++i) {
        const PlotSeries& series = plot.series[i];
        if (series.points.empty()) continue;
        PlotLabel label;
        label.text = series.label;
        label.series = static_cast<int>(i);
        placer.place(label, textSize(series.label), anchorsOf(series, layout));
    }
    return layout;
}

}  // namespace penumbra
