#include "report/text/chart.h"

#include "report/text/numbers.h"
#include "report/text/page.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

namespace kagero {

std::string power_of_ten(int exponent) {
    static const char* const superscripts[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
    if (exponent >= 0 && exponent <= 5) return std::string("1") + std::string(static_cast<std::size_t>(exponent), '0');
    std::string text = exponent < 0 ? "10⁻" : "10";
    for (const char c : std::to_string(std::abs(exponent))) text += superscripts[c - '0'];
    return text;
}

namespace {

// Sizes are in SVG units; the picture is scaled to the width of the page.
constexpr double chart_width = 940, chart_height = 520;
constexpr double plot_left = 72, plot_top = 14, plot_bottom = chart_height - 52;
constexpr double label_height = 13, letter_width = 6.2, label_margin = 18;

/// Returns a number with at most six significant digits.
std::string tick_number(double value) {
    char buffer[40];
    return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::general, 6).ptr};
}

/// The scale of one axis. It maps the values from `least` to `greatest` to the SVG coordinates from `begin` to `end`.
struct Scale {
    bool logarithmic;
    double least, greatest, begin, end;
    double coordinate(double value) const {
        const double share = logarithmic ? std::log10(value / least) / std::log10(greatest / least)
                                         : (value - least) / (greatest - least);
        return begin + share * (end - begin);
    }
    bool contains(double value) const { return std::isfinite(value) && value >= least && value <= greatest; }
};

struct Tick {
    double value;
    std::string label;
};

/// Returns at most about ten ticks at powers of ten. If the scale spans less than 3.5 decades, 2 and 5 times powers of
/// ten have ticks too.
std::vector<Tick> logarithmic_ticks(const Scale& scale) {
    const int first = static_cast<int>(std::floor(std::log10(scale.least))),
              last = static_cast<int>(std::floor(std::log10(scale.greatest) + 1e-9));
    const int stride = std::max(1, (last - first + 9) / 10);
    const bool subdivided = std::log10(scale.greatest / scale.least) < 3.5;
    std::vector<Tick> ticks;
    for (int e = first; e <= last; ++e)
        for (const int digit : {1, 2, 5}) {
            const double value = digit * std::pow(10.0, e);
            if (value < scale.least * (1 - 1e-9) || value > scale.greatest * (1 + 1e-9)) continue;
            if (digit == 1 && (e - first) % stride == 0) ticks.push_back({value, power_of_ten(e)});
            if (digit != 1 && subdivided)
                ticks.push_back(
                    {value, e >= 0 && e <= 5 ? tick_number(value) : std::to_string(digit) + "·" + power_of_ten(e)});
        }
    return ticks;
}

/// Returns about six ticks at multiples of 1, 2 or 5 times a power of ten.
std::vector<Tick> linear_ticks(const Scale& scale) {
    const double span = scale.greatest - scale.least;
    const double sixth = span / 6, unit = std::pow(10.0, std::floor(std::log10(sixth)));
    const double step = unit * (sixth / unit > 5 ? 10 : sixth / unit > 2 ? 5 : sixth / unit > 1 ? 2 : 1);
    std::vector<Tick> ticks;
    for (double v = std::ceil(scale.least / step) * step; v <= scale.greatest * (1 + 1e-12); v += step)
        ticks.push_back({v, tick_number(std::abs(v) < 1e-9 * span ? 0 : v)});
    return ticks;
}

std::vector<Tick> ticks_of(const Scale& scale) {
    return scale.logarithmic ? logarithmic_ticks(scale) : linear_ticks(scale);
}

/// Returns the scale of axis 0 (x) or 1 (y) that contains the points of all series. `begin` and `end` are its SVG
/// coordinates.
Scale scale_of(const LineChart& chart, int axis, double begin, double end) {
    const bool logarithmic = (axis == 0 ? chart.x : chart.y).logarithmic;
    double least = std::numeric_limits<double>::infinity(), greatest = -least;
    for (const Series& series : chart.series)
        for (const auto& point : series.points) {
            double value = point[static_cast<std::size_t>(axis)];
            if (!std::isfinite(value) || (logarithmic && !(value > 0))) continue;
            if (axis == 1 && logarithmic) value = std::max(value, chart.least_y);
            least = std::min(least, value);
            greatest = std::max(greatest, value);
        }
    if (!(least <= greatest)) {
        least = logarithmic ? 1 : 0;
        greatest = 10;
    }
    if (logarithmic) {
        // The y axis covers whole decades. The x axis has a margin of a factor of 1.25 at both ends.
        if (axis == 1)
            return {true, std::pow(10.0, std::floor(std::log10(least))),
                    std::pow(10.0, std::ceil(std::log10(greatest) + 1e-9)), begin, end};
        return {true, least / 1.25, greatest * 1.25, begin, end};
    }
    return {false, least, greatest > least ? greatest : least + 1, begin, end};
}

std::string line(double x1, double y1, double x2, double y2, const std::string& style) {
    return "<line x1=\"" + fixed(x1) + "\" y1=\"" + fixed(y1) + "\" x2=\"" + fixed(x2) + "\" y2=\"" + fixed(y2) +
           "\" style=\"" + style + "\"/>\n";
}

/// Returns a text element. `attributes` are further attributes, with a leading space.
std::string text(double x, double y, const std::string& anchor, const std::string& css_class,
                 const std::string& content, const std::string& attributes = "") {
    return "<text x=\"" + fixed(x) + "\" y=\"" + fixed(y) + "\" text-anchor=\"" + anchor + "\" class=\"" + css_class +
           "\"" + attributes + ">" + html_text(content) + "</text>\n";
}

/// Returns the start tag of a point mark; `closing_tag` returns the end tag. The tooltip is a child element between
/// them.
std::string opening_tag(const Series& series, double x, double y) {
    const double r = series.strong ? 4.2 : 3.2;
    const auto polygon = [&](std::initializer_list<std::array<double, 2>> corners) {
        std::string points;
        for (const auto& [dx, dy] : corners) points += fixed(x + r * dx) + "," + fixed(y + r * dy) + " ";
        return "<polygon points=\"" + points + "\" style=\"fill:" + series.color + "\">";
    };
    switch (series.mark) {
        case Mark::circle:
            return "<circle cx=\"" + fixed(x) + "\" cy=\"" + fixed(y) + "\" r=\"" + fixed(r) +
                   "\" style=\"fill:" + series.color + "\">";
        case Mark::square: return polygon({{-.9, -.9}, {.9, -.9}, {.9, .9}, {-.9, .9}});
        case Mark::triangle: return polygon({{0, -1.2}, {1.1, .8}, {-1.1, .8}});
        case Mark::diamond: return polygon({{0, -1.25}, {1.25, 0}, {0, 1.25}, {-1.25, 0}});
        case Mark::cross:
            return polygon({{-1, -.4},
                            {-.4, -.4},
                            {-.4, -1},
                            {.4, -1},
                            {.4, -.4},
                            {1, -.4},
                            {1, .4},
                            {.4, .4},
                            {.4, 1},
                            {-.4, 1},
                            {-.4, .4},
                            {-1, .4}});
        case Mark::none: return "<g>";
    }
    return "<g>";
}

const char* closing_tag(Mark mark) {
    return mark == Mark::none ? "</g>" : mark == Mark::circle ? "</circle>" : "</polygon>";
}

std::string draw_series(const Series& series, const Scale& x, const Scale& y) {
    std::string path, marks;
    bool pen_down = false;
    for (std::size_t i = 0; i < series.points.size(); ++i) {
        const auto& [a, b] = series.points[i];
        if (!x.contains(a) || !y.contains(b)) {
            pen_down = false;
            continue;
        }
        path += (pen_down ? "L" : "M") + fixed(x.coordinate(a)) + " " + fixed(y.coordinate(b)) + " ";
        pen_down = true;
        if (series.mark == Mark::none) continue;
        marks += opening_tag(series, x.coordinate(a), y.coordinate(b));
        if (i < series.tooltips.size()) marks += "<title>" + html_text(series.tooltips[i]) + "</title>";
        marks += std::string(closing_tag(series.mark)) + "\n";
    }
    if (series.marks_only) return marks;
    return "<path d=\"" + path + "\" style=\"fill:none;stroke:" + series.color +
           ";stroke-width:" + (series.strong ? "2.8" : "1.4") + ";stroke-linejoin:round" +
           (series.dashed   ? ";stroke-dasharray:5 4"
            : series.dotted ? ";stroke-dasharray:1.5 3"
                            : "") +
           "\"/>\n" + marks;
}

/// The label of a line: the end point (x, y) of the line and the y coordinate of the text, in SVG units.
struct Label {
    const Series* series;
    double x, y, text_y;
};

/// Draws the labels in one column to the right of the plot, sorted by the y coordinates of the line ends. Labels are
/// moved vertically so that they do not overlap.
std::string draw_labels(const LineChart& chart, const Scale& x, const Scale& y) {
    std::vector<Label> labels;
    for (const Series& series : chart.series)
        for (std::size_t i = series.points.size(); i-- > 0;)
            if (const auto& [a, b] = series.points[i]; x.contains(a) && y.contains(b)) {
                labels.push_back({&series, x.coordinate(a), y.coordinate(b), y.coordinate(b)});
                break;
            }
    std::stable_sort(labels.begin(), labels.end(), [](const Label& a, const Label& b) { return a.y < b.y; });
    const double gaps = std::max(1.0, double(labels.size()) - 1),
                 spacing = std::min(label_height, (plot_bottom - plot_top) / gaps);
    for (std::size_t i = 0; i < labels.size(); ++i)
        labels[i].text_y = std::max(labels[i].text_y, i ? labels[i - 1].text_y + spacing : plot_top + 6);
    for (std::size_t i = labels.size(); i-- > 0;)
        labels[i].text_y =
            std::min(labels[i].text_y, i + 1 < labels.size() ? labels[i + 1].text_y - spacing : plot_bottom);
    std::string svg;
    for (const Label& label : labels) {
        svg += "<path d=\"M" + fixed(label.x + 5) + " " + fixed(label.y) + " L" + fixed(x.end + 6) + " " +
               fixed(label.text_y) + " h8\" style=\"fill:none;stroke:" + label.series->color +
               ";stroke-width:.7;opacity:.45\"/>\n";
        svg += text(x.end + label_margin, label.text_y + 4, "start", label.series->strong ? "label strong" : "label",
                    label.series->label, " style=\"fill:" + label.series->color + "\"");
    }
    return svg;
}

std::string draw_axes(const LineChart& chart, const Scale& x, const Scale& y) {
    std::string svg;
    if (chart.shaded_below > y.least && chart.y.logarithmic) {
        const double edge = y.coordinate(std::min(chart.shaded_below, y.greatest));
        svg += "<rect x=\"" + fixed(plot_left) + "\" y=\"" + fixed(edge) + "\" width=\"" + fixed(x.end - x.begin) +
               "\" height=\"" + fixed(plot_bottom - edge) + "\" style=\"fill:var(--soft);opacity:.12\"/>\n";
        svg += text(plot_left + 8, std::min(edge + 15, plot_bottom - 4), "start", "label", chart.shaded_label);
    }
    for (const Tick& tick : ticks_of(x)) {
        svg += line(x.coordinate(tick.value), plot_top, x.coordinate(tick.value), plot_bottom, "stroke:var(--grid)");
        svg += text(x.coordinate(tick.value), plot_bottom + 18, "middle", "tick", tick.label);
    }
    for (const Tick& tick : ticks_of(y)) {
        svg += line(plot_left, y.coordinate(tick.value), x.end, y.coordinate(tick.value), "stroke:var(--grid)");
        svg += text(plot_left - 8, y.coordinate(tick.value) + 4, "end", "tick", tick.label);
    }
    svg += line(plot_left, plot_bottom, x.end, plot_bottom, "stroke:var(--ink)") +
           line(plot_left, plot_top, plot_left, plot_bottom, "stroke:var(--ink)");
    svg += text(0.5 * (x.begin + x.end), chart_height - 10, "middle", "axis", chart.x.title);
    svg += text(0, 0, "middle", "axis", chart.y.title,
                " transform=\"translate(16 " + fixed(0.5 * (plot_top + plot_bottom)) + ") rotate(-90)\"");
    for (const HorizontalLine& horizontal : chart.horizontal_lines) {
        if (!y.contains(horizontal.y)) continue;
        svg += line(plot_left, y.coordinate(horizontal.y), x.end, y.coordinate(horizontal.y),
                    "stroke:var(--soft);stroke-dasharray:2 3");
        svg += text(plot_left + 8, y.coordinate(horizontal.y) - 4, "start", "label", horizontal.label);
    }
    return svg;
}

/// Returns the start tag of an SVG picture of w × h units.
std::string svg_tag(double w, double h, const std::string& title) {
    return "<svg viewBox=\"0 0 " + fixed(w, 0) + " " + fixed(h, 0) + "\" role=\"img\" aria-label=\"" +
           html_text(title) + "\" xmlns=\"http://www.w3.org/2000/svg\">\n";
}

}  // namespace

std::string svg_of(const LineChart& chart) {
    std::size_t label_length = 25;  // length of the longest label, but at least 25 letters
    for (const Series& series : chart.series) label_length = std::max(label_length, series.label.size());
    const double right = chart_width - label_margin - letter_width * double(label_length);
    const Scale x = scale_of(chart, 0, plot_left, right), y = scale_of(chart, 1, plot_bottom, plot_top);
    const auto shown = [&](const auto& point) { return x.contains(point[0]) && y.contains(point[1]); };
    if (std::none_of(chart.series.begin(), chart.series.end(),
                     [&](const Series& one) { return std::any_of(one.points.begin(), one.points.end(), shown); }))
        return "";
    std::string svg =
        svg_tag(chart_width, chart_height, chart.title) + draw_axes(chart, x, y) + draw_labels(chart, x, y);
    for (const bool strong : {false, true})
        for (const Series& series : chart.series)
            if (series.strong == strong) svg += draw_series(series, x, y);
    return svg + "</svg>\n";
}

std::string svg_of(const BarChart& chart) {
    constexpr double row_height = 30, bar_letter_width = 7.2, value_width = 150;
    double label_width = 190;
    for (const Bar& bar : chart.bars)
        label_width = std::max(label_width, bar_letter_width * double(bar.label.size()) + 10);
    const double height = row_height * double(chart.bars.size()) + 12, span = chart_width - label_width - value_width;
    double greatest = 0;
    for (const Bar& bar : chart.bars) greatest = std::max({greatest, bar.value, bar.greatest});
    const auto coordinate = [&](double value) {
        return label_width + (greatest > 0 && std::isfinite(value) ? span * value / greatest : 0);
    };
    std::string svg = svg_tag(chart_width, height, chart.title);
    for (std::size_t i = 0; i < chart.bars.size(); ++i) {
        const Bar& bar = chart.bars[i];
        const double y = 6 + row_height * double(i), middle = y + 0.5 * row_height;
        svg += text(label_width - 10, middle + 4, "end", "axis", bar.label);
        svg += "<rect x=\"" + fixed(label_width) + "\" y=\"" + fixed(y + 5) + "\" width=\"" +
               fixed(coordinate(bar.value) - label_width) + "\" height=\"" + fixed(row_height - 10) +
               "\" rx=\"2\" style=\"fill:" + bar.color + "\"/>\n";
        if (bar.greatest > 0)
            svg += line(coordinate(bar.least), middle, coordinate(bar.greatest), middle,
                        "stroke:var(--ink);stroke-width:1.5");
        svg += text(std::max(coordinate(bar.value), coordinate(bar.greatest)) + 8, middle + 4, "start", "tick",
                    bar.value_text);
    }
    return svg + "</svg>\n";
}

}  // namespace kagero
