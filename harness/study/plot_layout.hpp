#pragma once

#include <functional>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "harness/study/plot.hpp"

namespace penumbra {

/// Where things of a Plot are, in units of its picture, y downwards.

struct PlotBox {
    glm::dvec2 lo, hi;
    bool overlaps(const PlotBox& o) const {
        return glm::all(glm::lessThan(lo, o.hi)) && glm::all(glm::lessThan(o.lo, hi));
    }
    bool contains(const PlotBox& o) const {
        return glm::all(glm::lessThanEqual(lo, o.lo)) && glm::all(glm::lessThanEqual(o.hi, hi));
    }
    glm::dvec2 centre() const { return 0.5 * (lo + hi); }
};

/// One logarithmic axis: values to places.
class LogAxis {
  public:
    /// The least and the greatest positive of `values` come to lie at `from` and `to`.
    LogAxis(const std::vector<double>& values, double from, double to);
    double operator()(double value) const;
    /// The values between the places `from` and `to` that get a line and a number: powers of ten,
    /// and 2 and 5 times these where few of them fit.
    std::vector<double> ticks(double from, double to) const;

  private:
    double logLow_, logHigh_, from_, to_;
};

struct PlotLabel {
    std::string text;
    int series = -1;  ///< its index; -1: the floor's
    PlotBox box;
    glm::dvec2 anchor;    ///< the place on the line that it names
    bool leader = false;  ///< far enough from it to need a line there
};

struct PlotLayout {
    PlotBox area;  ///< between the axes
    LogAxis x, y;
    std::vector<PlotLabel> labels;  ///< one for each series and for the floor

    glm::dvec2 place(glm::dvec2 value) const { return {x(value.x), y(value.y)}; }
};

/// Labels keep clear of each other, and of dots and lines where there is room; `textSize` measures
/// a label.
PlotLayout layOut(const Plot& plot, const std::function<glm::dvec2(const std::string&)>& textSize);

}  // namespace penumbra
