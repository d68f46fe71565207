#include "harness/study/curve.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <set>

#include "core/image/image.hpp"
#include "harness/study/plot_layout.hpp"
#include "tests/core/scene_files.hpp"

namespace penumbra {
namespace {

CostPoint point(const std::string& setting, double error, double ms, bool onFront = false) {
    CostPoint p;
    p.setting = setting;
    p.method = setting.substr(0, setting.find('-'));
    p.error = error;
    p.ms = ms;
    p.lowMs = 0.9 * ms;
    p.highMs = 1.1 * ms;
    p.onFront = onFront;
    p.frames = p.scenes = 1;
    return p;
}

/// Three methods; one line within 10 % of another.
CostStudy smallStudy() {
    CostStudy study;
    study.scene = "fence";
    study.frames = study.scenes = 1;
    study.points = {point("a-1", 0.1, 1, true), point("a-2", 0.05, 10, true),
                    point("a-3", 0.06, 20),     point("b-1", 0.11, 1.1),
                    point("b-2", 0.055, 11),    point("c", 0.002, 300, true)};
    study.floor = 0.0005;
    return study;
}

Plot plotOf(const CostStudy& study) {
    return curvePlot(study, "rmse", methodStyles({study}));
}

/// About as wide as 14 px DejaVu Sans.
glm::dvec2 textSize(const std::string& text) {
    return {8.5 * static_cast<double>(text.size()), 17.0};
}

std::size_t occurrences(const std::string& text, const std::string& part) {
    std::size_t n = 0;
    for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; at += part.size())
        ++n;
    return n;
}

void expectLabelsApart(const PlotLayout& layout) {
    for (std::size_t i = 0; i < layout.labels.size(); ++i) {
        const PlotLabel& label = layout.labels[i];
        EXPECT_TRUE(layout.area.contains(label.box)) << label.text;
        for (std::size_t j = 0; j < i; ++j)
            EXPECT_FALSE(label.box.overlaps(layout.labels[j].box))
                << label.text << " lies over " << layout.labels[j].text;
    }
}

TEST(CurvePlot, OneLinePerMethodThroughItsOwnFront) {
    const Plot plot = plotOf(smallStudy());
    ASSERT_EQ(plot.series.size(), 3u);
    const PlotSeries& a = plot.series[0];
    EXPECT_EQ(a.label, "a");
    EXPECT_FALSE(a.dashed);
    EXPECT_EQ(a.points.size(), 3u);
    EXPECT_EQ(a.line, (std::vector<glm::dvec2>{{1, 0.1}, {10, 0.05}})) << "a-3 is worse and slower";
    EXPECT_TRUE(a.points[0].marked);
    EXPECT_FALSE(a.points[2].marked);
    EXPECT_DOUBLE_EQ(a.points[0].xHigh, 1.1);
    EXPECT_EQ(plot.band, (std::vector<glm::dvec2>{{1, 0.1}, {10, 0.05}, {300, 0.002}}));
    EXPECT_EQ(plot.floor, 0.0005);
    EXPECT_EQ(plot.yLabel, "rmse");
}

TEST(CurvePlot, AMethodThatLacksFramesSaysSo) {
    CostStudy study = smallStudy();
    study.scene = kWholeSuite;
    study.frames = 3;
    for (CostPoint& p : study.points) p.frames = p.method == "a" ? 3 : 2;
    study.points.back().frames = 1;
    study.points.push_back(point("c-2", 0.001, 400, true));
    study.points.back().frames = 2;
    const Plot plot = plotOf(study);
    EXPECT_EQ(plot.series[0].label, "a");
    EXPECT_EQ(plot.series[1].label, "b (2 of 3 frames)");
    EXPECT_EQ(plot.series[2].label, "c (1 to 2 of 3 frames)");
    EXPECT_TRUE(plot.series[2].dashed);
    EXPECT_EQ(plot.band.size(), 2u) << "of c nothing is comparable with the others";
}

TEST(CurvePlot, MethodsLookTheSameInEveryStudy) {
    CostStudy other = smallStudy();
    other.points = {point("c", 0.1, 1), point("hard", 0.1, 2)};
    const auto styles = methodStyles({smallStudy(), other});
    std::set<int> different;
    for (const auto& [method, style] : styles) different.insert(style);
    EXPECT_EQ(different.size(), styles.size());
    EXPECT_EQ(curvePlot(other, "rmse", styles).series[0].style, styles.at("c"));
    EXPECT_EQ(methodStyles({}).at("hard"), styles.at("hard")) << "whatever else is in the run";
}

TEST(Plot, AxesAreLogarithmicWithRoundTicks) {
    const LogAxis axis({0.01, 1.0, 0.0}, 100.0, 300.0);
    EXPECT_DOUBLE_EQ(axis(0.01), 100.0);
    EXPECT_DOUBLE_EQ(axis(0.1), 200.0);
    EXPECT_DOUBLE_EQ(axis(1.0), 300.0);
    EXPECT_DOUBLE_EQ(axis(0.0), 100.0) << "no place of its own";
    const std::vector<double> ticks = axis.ticks(100.0, 300.0);
    ASSERT_EQ(ticks.size(), 7u);
    for (std::size_t i = 0; i < ticks.size(); ++i)
        EXPECT_NEAR(ticks[i], (std::vector{0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0})[i], 1e-12);
    const LogAxis wide({1e-3, 1e3}, 0.0, 600.0);
    EXPECT_EQ(wide.ticks(0.0, 600.0).size(), 7u) << "powers of ten only";
    const LogAxis one({5.0}, 0.0, 100.0);
    EXPECT_DOUBLE_EQ(one(5.0), 50.0);
    EXPECT_TRUE(std::isfinite(LogAxis({}, 0.0, 100.0)(1.0)));
}

TEST(Plot, LabelsKeepClearOfEachOtherAndOfDots) {
    const Plot plot = plotOf(smallStudy());
    const PlotLayout layout = layOut(plot, textSize);
    ASSERT_EQ(layout.labels.size(), 4u);
    EXPECT_EQ(layout.labels[0].text, "the reference's own error");
    expectLabelsApart(layout);
    for (const PlotLabel& label : layout.labels)
        for (const PlotSeries& series : plot.series)
            for (const PlotPoint& p : series.points) {
                const glm::dvec2 at = layout.place({p.x, p.y});
                EXPECT_FALSE(label.box.overlaps({at - 3.0, at + 3.0})) << label.text;
            }
}

TEST(Plot, TwentyMethodsOnOneSpotStillHaveLabelsApart) {
    CostStudy study;
    study.frames = 1;
    for (int i = 0; i < 20; ++i)
        study.points.push_back(point(fmt::format("a_method_of_long_name_{:02}", i), 0.1, 10));
    const PlotLayout layout = layOut(plotOf(study), textSize);
    ASSERT_EQ(layout.labels.size(), 20u);
    expectLabelsApart(layout);
}

TEST(Plot, SvgNamesEachMethodOnce) {
    CostStudy study = smallStudy();
    study.scene = "a<b&c";
    const Plot plot = plotOf(study);
    const std::string svg = plotSvg(plot);
    EXPECT_TRUE(svg.ends_with("</svg>\n")) << svg.substr(svg.size() - 20);
    EXPECT_EQ(occurrences(svg, "<desc>rmse against frame time (ms): a, b, c</desc>"), 1u);
    EXPECT_NE(svg.find("<title>What accuracy costs: a&lt;b&amp;c</title>"), std::string::npos);
    EXPECT_EQ(plotSvg(plot), svg) << "surfaces made before leave no trace";
}

TEST(Plot, PngDecodesAndShowsTheMarkedDots) {
    const Plot plot = plotOf(smallStudy());
    testing::TempFolder folder;
    const std::string png = plotPng(plot);
    EXPECT_EQ(plotPng(plot), png);
    const Image image = readImage(folder.write("curve.png", png));
    ASSERT_EQ(image.width, 2 * kPlotWidth);
    ASSERT_EQ(image.height, 2 * kPlotHeight);
    EXPECT_EQ(image.at(1, 1, 0), 1.0f) << "white paper";
    const PlotLayout layout = layOut(plot, textSize);
    for (const PlotSeries& series : plot.series)
        for (const PlotPoint& p : series.points) {
            const glm::ivec2 at = glm::dvec2(2.0) * layout.place({p.x, p.y});
            const bool white = image.at(at.x, at.y, 0) == 1.0f && image.at(at.x, at.y, 1) == 1.0f &&
                               image.at(at.x, at.y, 2) == 1.0f;
            EXPECT_EQ(white, !p.marked) << series.label << " at " << p.x;
        }
}

}  // namespace
}  // namespace penumbra
