/// Charts as SVG: line charts with logarithmic or linear axes and a label at the end of each line, and bar charts.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace kagero {

/// Shape of the point marks of a series, which distinguishes lines without colour.
enum class Mark { none, circle, square, triangle, diamond, cross };

/// Returns a power of ten as text: plain digits for exponents from 0 to 5, else with a superscript such as 10⁻³.
std::string power_of_ten(int exponent);

/// One line of a line chart.
struct Series {
    std::string label;
    std::string color;  ///< CSS colour.
    Mark mark = Mark::circle;
    bool dashed = false, dotted = false;
    bool strong = false;                        ///< True for a thicker line that is drawn over the other lines.
    std::vector<std::array<double, 2>> points;  ///< Pairs (x, y). Points outside the axes are not drawn.
    std::vector<std::string> tooltips;          ///< One text per point, or empty.
    bool marks_only = false;                    ///< True for marks without a line.
};

/// One axis of a line chart.
struct Axis {
    std::string title;
    bool logarithmic = true;
};

/// A labelled horizontal line across a line chart.
struct HorizontalLine {
    double y;
    std::string label;
};

/// A line chart.
struct LineChart {
    std::string title;  ///< Text alternative for screen readers.
    Axis x, y;
    std::vector<Series> series;
    std::vector<HorizontalLine> horizontal_lines;
    double shaded_below = 0;   ///< On a logarithmic y axis, the area below this y is shaded; 0: none.
    std::string shaded_label;  ///< Label of the shaded area.
    double least_y = 0;        ///< On a logarithmic y axis, the range is not extended below this y; 0: no limit.
};

/// Returns the chart as SVG, or "" if no point lies within the axes.
std::string svg_of(const LineChart& chart);

/// One bar of a bar chart.
struct Bar {
    std::string label, color, value_text;
    double value = 0;                ///< Length of the bar.
    double least = 0, greatest = 0;  ///< Ends of a thin line over the bar; no line is drawn if `greatest` is 0.
};

/// A chart of horizontal bars.
struct BarChart {
    std::string title;  ///< Text alternative for screen readers.
    std::vector<Bar> bars;
};

/// Returns the chart as SVG.
std::string svg_of(const BarChart& chart);

}  // namespace kagero
