#include "harness/study/plot.hpp"
#include "harness/report/escape.hpp"

#include <cairo-svg.h>
#include <fmt/format.h>

#include <array>
#include <memory>
#include <numbers>
#include <stdexcept>

#include "harness/report/escape.hpp"
#include "harness/study/plot_layout.hpp"

namespace penumbra {
namespace {

constexpr double kLabelSize = 14.5, kAxisSize = 13.0, kTitleSize = 20.0, kNoteSize = 12.5;
constexpr double kPngScale = 2.0;

struct Ink {
    double r, g, b;
};
constexpr Ink kPaper{1.0, 1.0, 1.0}, kText{0.13, 0.13, 0.13}, kFaint{0.40, 0.40, 0.40};
constexpr Ink kGrid{0.90, 0.90, 0.90}, kFrame{0.60, 0.60, 0.60}, kBand{0.84, 0.84, 0.84};

/// Okabe and Ito 2008, "Color Universal Design", without yellow, which white paper swallows, and
/// the wine, olive and indigo of Paul Tol's "muted" scheme, all of other lightness.
constexpr std::array<Ink, 10> kInks{{
    {0.000, 0.447, 0.698},  // blue
    {0.835, 0.369, 0.000},  // vermillion
    {0.000, 0.620, 0.451},  // bluish green
    {0.800, 0.475, 0.655},  // reddish purple
    {0.902, 0.624, 0.000},  // orange
    {0.337, 0.706, 0.914},  // sky blue
    {0.250, 0.250, 0.250},  // black
    {0.533, 0.133, 0.333},  // wine
    {0.600, 0.600, 0.200},  // olive
    {0.200, 0.133, 0.533},  // indigo
}};
enum class Shape { circle, square, diamond, triangle };
constexpr int kShapes = 4;

Ink inkOf(const PlotSeries& series) {
    return kInks[static_cast<std::size_t>(series.style) % kInks.size()];
}
Shape shapeOf(const PlotSeries& series) {
    return static_cast<Shape>(series.style / static_cast<int>(kInks.size()) % kShapes);
}
/// Letters are thinner than lines and need more contrast.
Ink darkened(const Ink& ink) {
    return {0.72 * ink.r, 0.72 * ink.g, 0.72 * ink.b};
}

using Surface = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;

void check(cairo_status_t status, const char* what) {
    if (status != CAIRO_STATUS_SUCCESS)
        throw std::runtime_error(fmt::format("{}: {}", what, cairo_status_to_string(status)));
}

/// A pen on a surface, with the plot's typeface.
class Canvas {
  public:
    explicit Canvas(cairo_surface_t* surface)
        : context_(cairo_create(surface), &cairo_destroy),
          options_(cairo_font_options_create(), &cairo_font_options_destroy) {
        // Letters of the same width at every scale, so that one layout fits both files.
        cairo_font_options_set_hint_metrics(options_.get(), CAIRO_HINT_METRICS_OFF);
        cairo_font_options_set_hint_style(options_.get(), CAIRO_HINT_STYLE_NONE);
        cairo_font_options_set_antialias(options_.get(), CAIRO_ANTIALIAS_GRAY);
        cairo_set_font_options(context_.get(), options_.get());
        cairo_set_line_join(context_.get(), CAIRO_LINE_JOIN_ROUND);
        cairo_set_line_cap(context_.get(), CAIRO_LINE_CAP_ROUND);
    }

    cairo_t* get() const { return context_.get(); }
    void scale(double factor) { cairo_scale(get(), factor, factor); }
    void ink(const Ink& c) { cairo_set_source_rgb(get(), c.r, c.g, c.b); }

    void font(double size, bool bold = false) {
        cairo_select_font_face(get(), "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
                               bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
        cairo_set_font_size(get(), size);
    }
    /// Advance and height of a line in the current font.
    glm::dvec2 textSize(const std::string& text) {
        cairo_text_extents_t extents;
        cairo_font_extents_t face;
        cairo_text_extents(get(), text.c_str(), &extents);
        cairo_font_extents(get(), &face);
        return {extents.x_advance, face.ascent + face.descent};
    }
    /// With the upper left corner at `at`.
    void text(glm::dvec2 at, const std::string& text) {
        cairo_font_extents_t face;
        cairo_font_extents(get(), &face);
        cairo_move_to(get(), at.x, at.y + face.ascent);
        cairo_show_text(get(), text.c_str());
    }
    void line(glm::dvec2 a, glm::dvec2 b, double width) {
        cairo_move_to(get(), a.x, a.y);
        cairo_line_to(get(), b.x, b.y);
        stroke(width);
    }
    void stroke(double width) {
        cairo_set_line_width(get(), width);
        cairo_stroke(get());
    }
    void dashes(double length) { cairo_set_dash(get(), &length, length > 0.0 ? 1 : 0, 0.0); }

  private:
    std::unique_ptr<cairo_t, decltype(&cairo_destroy)> context_;
    std::unique_ptr<cairo_font_options_t, decltype(&cairo_font_options_destroy)> options_;
};

void polyline(Canvas& canvas, const PlotLayout& layout, const std::vector<glm::dvec2>& values,
              double width) {
    cairo_new_path(canvas.get());  // showing text leaves a point behind
    for (const glm::dvec2& value : values) {
        const glm::dvec2 at = layout.place(value);
        cairo_line_to(canvas.get(), at.x, at.y);
    }
    canvas.stroke(width);
}

void outline(Canvas& canvas, Shape shape, glm::dvec2 at, double radius) {
    cairo_t* c = canvas.get();
    const auto corners = [&](std::initializer_list<glm::dvec2> directions) {
        cairo_new_sub_path(c);
        for (const glm::dvec2& d : directions)
            cairo_line_to(c, at.x + radius * d.x, at.y + radius * d.y);
        cairo_close_path(c);
    };
    switch (shape) {
        case Shape::circle:
            cairo_new_sub_path(c);
            cairo_arc(c, at.x, at.y, radius, 0.0, 2.0 * std::numbers::pi);
            break;
        case Shape::square:
            corners({{-0.9, -0.9}, {0.9, -0.9}, {0.9, 0.9}, {-0.9, 0.9}});
            break;
        case Shape::diamond:
            corners({{0.0, -1.25}, {1.25, 0.0}, {0.0, 1.25}, {-1.25, 0.0}});
            break;
        case Shape::triangle:
            corners({{0.0, -1.2}, {1.1, 0.8}, {-1.1, 0.8}});
            break;
    }
}

void drawPoint(Canvas& canvas, const PlotLayout& layout, const PlotSeries& series,
               const PlotPoint& p) {
    constexpr double kCap = 3.0;
    const glm::dvec2 at = layout.place({p.x, p.y});
    const double low = layout.x(p.xLow), high = layout.x(p.xHigh);
    canvas.ink(inkOf(series));
    canvas.line({low, at.y}, {high, at.y}, 1.2);
    for (const double end : {low, high}) canvas.line({end, at.y - kCap}, {end, at.y + kCap}, 1.2);
    outline(canvas, shapeOf(series), at, p.marked ? 5.5 : 3.6);
    canvas.ink(p.marked ? inkOf(series) : kPaper);
    cairo_fill_preserve(canvas.get());
    canvas.ink(p.marked ? kText : inkOf(series));
    canvas.stroke(1.4);
}

void drawAxes(Canvas& canvas, const Plot& plot, const PlotLayout& layout) {
    const PlotBox& area = layout.area;
    canvas.font(kAxisSize);
    for (const double value : layout.x.ticks(area.lo.x, area.hi.x)) {
        const double x = layout.x(value);
        canvas.ink(kGrid);
        canvas.line({x, area.lo.y}, {x, area.hi.y}, 1.0);
        const std::string text = fmt::format("{:.6g}", value);
        canvas.ink(kFaint);
        canvas.text({x - 0.5 * canvas.textSize(text).x, area.hi.y + 5.0}, text);
    }
    for (const double value : layout.y.ticks(area.hi.y, area.lo.y)) {
        const double y = layout.y(value);
        canvas.ink(kGrid);
        canvas.line({area.lo.x, y}, {area.hi.x, y}, 1.0);
        const std::string text = fmt::format("{:.6g}", value);
        const glm::dvec2 size = canvas.textSize(text);
        canvas.ink(kFaint);
        canvas.text({area.lo.x - 8.0 - size.x, y - 0.5 * size.y}, text);
    }
    canvas.ink(kFrame);
    canvas.line({area.lo.x, area.hi.y}, area.hi, 1.2);
    canvas.line(area.lo, {area.lo.x, area.hi.y}, 1.2);

    canvas.ink(kText);
    const double middle = 0.5 * (area.lo.x + area.hi.x);
    canvas.text({middle - 0.5 * canvas.textSize(plot.xLabel).x, area.hi.y + 27.0}, plot.xLabel);
    cairo_save(canvas.get());
    cairo_translate(canvas.get(), 12.0,
                    0.5 * (area.lo.y + area.hi.y + canvas.textSize(plot.yLabel).x));
    cairo_rotate(canvas.get(), -0.5 * std::numbers::pi);
    canvas.text({0.0, 0.0}, plot.yLabel);
    cairo_restore(canvas.get());
}

void drawLabels(Canvas& canvas, const Plot& plot, const PlotLayout& layout) {
    canvas.font(kLabelSize);
    for (const PlotLabel& label : layout.labels) {
        const bool ofSeries = label.series >= 0;
        const Ink ink =
            ofSeries ? inkOf(plot.series[static_cast<std::size_t>(label.series)]) : kFaint;
        if (label.leader) {
            canvas.ink(ink);
            canvas.line(glm::clamp(label.anchor, label.box.lo, label.box.hi), label.anchor, 0.8);
        }
        canvas.ink(ofSeries ? darkened(ink) : kFaint);
        canvas.text(label.box.lo, label.text);
    }
}

void draw(Canvas& canvas, const Plot& plot) {
    canvas.font(kLabelSize);
    const PlotLayout layout =
        layOut(plot, [&](const std::string& text) { return canvas.textSize(text); });

    canvas.ink(kPaper);
    cairo_paint(canvas.get());
    canvas.ink(kText);
    canvas.font(kTitleSize, true);
    canvas.text({layout.area.lo.x, 14.0}, plot.title);
    canvas.font(kNoteSize);
    canvas.ink(kFaint);
    canvas.text({layout.area.lo.x, 43.0}, plot.note);

    drawAxes(canvas, plot, layout);
    canvas.ink(kBand);
    polyline(canvas, layout, plot.band, 9.0);
    if (plot.floor) {
        const double y = layout.y(*plot.floor);
        canvas.ink(kFaint);
        canvas.dashes(2.0);
        canvas.line({layout.area.lo.x, y}, {layout.area.hi.x, y}, 1.2);
        canvas.dashes(0.0);
    }
    for (const PlotSeries& series : plot.series) {
        canvas.ink(inkOf(series));
        canvas.dashes(series.dashed ? 6.0 : 0.0);
        polyline(canvas, layout, series.line, 2.2);
        canvas.dashes(0.0);
    }
    for (const bool marked : {false, true})
        for (const PlotSeries& series : plot.series)
            for (const PlotPoint& p : series.points)
                if (p.marked == marked) drawPoint(canvas, layout, series, p);
    drawLabels(canvas, plot, layout);
    check(cairo_status(canvas.get()), "plot");
}

cairo_status_t append(void* text, const unsigned char* bytes, unsigned count) {
    static_cast<std::string*>(text)->append(reinterpret_cast<const char*>(bytes), count);
    return CAIRO_STATUS_SUCCESS;
}

/// cairo numbers its surfaces through the process; the first of a file is the file's.
void replaceSurfaceId(std::string& svg) {
    constexpr std::string_view kId = "id=\"surface";
    const std::size_t at = svg.find(kId);
    if (at == std::string::npos) return;
    const std::size_t begin = at + kId.size();
    svg.erase(begin, svg.find('"', begin) - begin);
}

}  // namespace

std::string plotSvg(const Plot& plot) {
    std::string svg;
    {
        const Surface surface(
            cairo_svg_surface_create_for_stream(append, &svg, kPlotWidth, kPlotHeight),
            &cairo_surface_destroy);
        check(cairo_surface_status(surface.get()), "plot: SVG");
        Canvas canvas(surface.get());
        draw(canvas, plot);
        cairo_surface_finish(surface.get());
        check(cairo_surface_status(surface.get()), "plot: SVG");
    }
    replaceSurfaceId(svg);
    std::string labels;
    for (const PlotSeries& series : plot.series)
        if (!series.points.empty()) labels += (labels.empty() ? "" : ", ") + series.label;
    const std::size_t root = svg.find("<svg");
    svg.insert(
        svg.find('>', root) + 1,
        fmt::format("\n<title>{}</title>\n<desc>{} against {}: {}</desc>", xmlEscaped(plot.title),
                    xmlEscaped(plot.yLabel), xmlEscaped(plot.xLabel), xmlEscaped(labels)));
    return svg;
}

std::string plotPng(const Plot& plot) {
    const Surface surface(
        cairo_image_surface_create(CAIRO_FORMAT_RGB24, static_cast<int>(kPngScale * kPlotWidth),
                                   static_cast<int>(kPngScale * kPlotHeight)),
        &cairo_surface_destroy);
    check(cairo_surface_status(surface.get()), "plot: PNG");
    Canvas canvas(surface.get());
    canvas.scale(kPngScale);
    draw(canvas, plot);
    std::string png;
    check(cairo_surface_write_to_png_stream(surface.get(), append, &png), "plot: PNG");
    return png;
}

}  // namespace penumbra
