#include "report/error/error_map.h"

#include "film/image.h"
#include "film/png.h"
#include "report/text/chart.h"
#include "report/text/numbers.h"
#include "report/text/page.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace kagero {
namespace {

// Sizes are in SVG units, with the same width as the charts.
constexpr double page_width = 940, panel_gap = 14, bar_left = 868, bar_width = 14, heading_height = 24,
                 bottom_margin = 8;

std::string base64(const std::vector<unsigned char>& bytes) {
    constexpr const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const std::size_t available = std::min<std::size_t>(3, bytes.size() - i);
        unsigned group = 0;
        for (std::size_t k = 0; k < 3; ++k) group = group << 8 | (k < available ? bytes[i + k] : 0u);
        for (std::size_t k = 0; k < 4; ++k) text += k <= available ? digits[group >> (18 - 6 * k) & 63] : '=';
    }
    return text;
}

std::string image(double x, double y, double width, double height, const std::vector<unsigned char>& png,
                  const std::string& title) {
    return "<image x=\"" + fixed(x) + "\" y=\"" + fixed(y) + "\" width=\"" + fixed(width) + "\" height=\"" +
           fixed(height) +
           "\" preserveAspectRatio=\"none\" style=\"image-rendering:pixelated\" href=\"data:image/png;base64," +
           base64(png) + "\"><title>" + html_text(title) + "</title></image>\n";
}

std::string text_element(double x, double y, const std::string& css_class, const std::string& content) {
    return "<text x=\"" + fixed(x) + "\" y=\"" + fixed(y) + "\" class=\"" + css_class + "\">" + content + "</text>\n";
}

/// Range of the colour scale in whole decades. It contains the values of both maps, except at most 0.3 % at each end.
struct Decades {
    int least = 0, greatest = 1;

    explicit Decades(const ErrorMap& map) {
        std::vector<float> all;
        for (const auto* values : {&map.estimate, &map.truth})
            std::copy_if(values->begin(), values->end(), std::back_inserter(all),
                         [](float v) { return std::isfinite(v) && v > 0; });
        if (all.empty()) return;
        std::sort(all.begin(), all.end());
        constexpr double tail = 0.003;
        const auto quantile = [&](double share) {
            return std::log10(double(all[static_cast<std::size_t>(share * double(all.size() - 1))]));
        };
        greatest = static_cast<int>(std::ceil(quantile(1 - tail)));
        least = std::min(greatest - 1, static_cast<int>(std::floor(quantile(tail))));
    }
    /// Returns the position of a value on the scale: 0 at `least`, 1 at `greatest`. Returns 0 for smaller values, more
    /// than 1 for greater values, and −1 for values that are not finite.
    float position_of(float value) const {
        if (!std::isfinite(value)) return -1;
        return value > 0 ? std::max(0.0f, float((std::log10(double(value)) - least) / (greatest - least))) : 0;
    }
};

/// Returns a PNG image of one of the two error maps in false colours.
std::vector<unsigned char> colored(const ErrorMap& map, const std::vector<float>& values, const Decades& decades) {
    std::vector<float> positions;
    for (const float value : values) positions.push_back(decades.position_of(value));
    return png_of_false_colors(positions, static_cast<int>(map.width), static_cast<int>(map.height));
}

/// Returns the SVG of the colour scale with its labels.
std::string scale(const Decades& decades, double top, double height) {
    constexpr int shades = 64, max_labels = 7;
    std::vector<float> ramp;
    for (int i = 0; i < shades; ++i) ramp.push_back(1 - float(i) / (shades - 1));
    std::string text = image(bar_left, top, bar_width, height, png_of_false_colors(ramp, 1, shades), "pixels");
    const int count = decades.greatest - decades.least, stride = (count + max_labels - 1) / max_labels;
    for (int e = decades.least; e <= decades.greatest; e += stride) {
        const double y = top + height * (decades.greatest - e) / count;
        text +=
            text_element(bar_left + bar_width + 5, std::clamp(y + 4, top + 10, top + height), "label", power_of_ten(e));
    }
    return text;
}

}  // namespace

double share_within_factor(const ErrorMap& map, double factor) {
    constexpr float rounding = 1e-10f;
    std::size_t known = 0, within = 0;
    for (std::size_t i = 0; i < map.truth.size(); ++i) {
        const float estimate = map.estimate[i], truth = map.truth[i];
        if (!(truth > rounding) || std::isnan(estimate)) continue;
        ++known;
        within += estimate <= factor * truth && truth <= factor * estimate;
    }
    return known > 0 ? double(within) / double(known) : 1;
}

std::string error_map_svg(const ErrorMap& map) {
    const int w = static_cast<int>(map.width), h = static_cast<int>(map.height);
    const double width = (bar_left - 3 * panel_gap) / 3, height = width * h / w,
                 total = heading_height + height + bottom_margin;
    const Decades decades(map);
    std::string svg = "<svg viewBox=\"0 0 " + fixed(page_width) + " " + fixed(total) +
                      "\" role=\"img\" aria-label=\"The picture, its estimated and its true error\">\n";
    const auto panel = [&](int i, const char* heading, const std::vector<unsigned char>& png) {
        const double x = i * (width + panel_gap);
        svg += text_element(x, 14, "axis", heading) + image(x, heading_height, width, height, png, heading);
    };
    panel(0, "the picture", png_of_colors(map.color, w, h, map.tone));
    panel(1, "estimated error, pixels", colored(map, map.estimate, decades));
    panel(2, "true error, pixels", colored(map, map.truth, decades));
    return svg + scale(decades, heading_height, height) + "</svg>\n";
}

}  // namespace kagero
