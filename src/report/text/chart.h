/// Small charts as SVG: lines over logarithmic or linear axes with a label at the end of each, and bars.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace kagero {

/// Marks tell lines apart without colour.
enum class Mark { none, circle, square, triangle, diamond, cross };

/// 10 to a whole power, in raised figures.
std::string power_of_ten(int exponent);

struct Series {
    std::string label;
    std::string color;  ///< CSS
    Mark mark = Mark::circle;
    bool dashed = false, dotted = false;
    bool strong = false;                        ///< drawn thicker, and above the others
    std::vector<std::array<double, 2>> points;  ///< those that an axis cannot show are left out
    std::vector<std::string> tips;              ///< shown over each point; may be empty
    bool scattered = false;                     ///< marks alone
};

struct Axis {
    std::string title;
    bool logarithmic = true;
};

/// A horizontal line with a meaning.
struct Bound {
    double y;
    std::string label;
};

struct LineChart {
    std::string title;  ///< for those who cannot see the picture
    Axis x, y;
    std::vector<Series> series;
    std::vector<Bound> bounds;
    double doubtful = 0;  ///< values of y below are shaded: they mean nothing
    std::string doubtful_label;
    double least_y = 0;  ///< a logarithmic y axis shows nothing below; 0: everything
};

/// Empty where there is no point that the axes can show.
std::string svg_of(const LineChart& chart);

struct Bar {
    std::string label, color, value_text;
    double value = 0, least = 0, greatest = 0;  ///< least and greatest as a whisker, if greatest > 0
};

struct BarChart {
    std::string title;
    std::vector<Bar> bars;
};

std::string svg_of(const BarChart& chart);

}  // namespace kagero
