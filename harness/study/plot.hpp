#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

namespace penumbra {

/// A chart with two logarithmic axes and its labels at the lines, drawn by the same code as SVG and
/// as PNG. The same plot gives the same bytes on one machine. Values at or below 0, for which such
/// axes have no place, are drawn where the least positive one is.

struct PlotPoint {
    double x = 0, y = 0;
    double xLow = 0, xHigh = 0;  ///< a whisker
    bool marked = false;         ///< a filled dot; else a hollow one
};

struct PlotSeries {
    std::string label;  ///< UTF-8; stands beside the line
    /// Colour (of ten chosen for colour-blind people, too) and shape of the dots; any number from
    /// 0, equal ones look alike.
    int style = 0;
    bool dashed = false;
    std::vector<PlotPoint> points;
    std::vector<glm::dvec2> line;  ///< from dot to dot, as much of them as should be joined
};

struct Plot {
    std::string title;
    std::string note;  ///< one line below the title
    std::string xLabel, yLabel;
    std::vector<PlotSeries> series;
    std::vector<glm::dvec2> band;  ///< a broad line behind all others
    std::optional<double> floor;   ///< a horizontal line
    std::string floorLabel;
};

/// Size in units of the SVG; the PNG has twice as many pixels.
inline constexpr int kPlotWidth = 1000, kPlotHeight = 640;

/// An SVG document. Texts are outlines, so that it looks alike everywhere; `<title>` and `<desc>`
/// hold the title and the series' labels for those who cannot see them.
std::string plotSvg(const Plot& plot);

/// The bytes of a PNG file. Both throw std::runtime_error with cairo's reason.
std::string plotPng(const Plot& plot);

}  // namespace penumbra
