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

// Sizes in SVG units, as those of charts.
constexpr double page_width = 940, panel_gap = 14, bar_place = 868, bar_width = 14, heading_height = 24, foot = 8;

std::string base64(const std::vector<unsigned char>& bytes) {
    constexpr const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const std::size_t there = std::min<std::size_t>(3, bytes.size() - i);
        unsigned group = 0;
        for (std::size_t k = 0; k < 3; ++k) group = group << 8 | (k < there ? bytes[i + k] : 0u);
        for (std::size_t k = 0; k < 4; ++k) text += k <= there ? digits[group >> (18 - 6 * k) & 63] : '=';
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

std::string words(double x, double y, const std::string& kind, const std::string& text) {
    return "<text x=\"" + fixed(x) + "\" y=\"" + fixed(y) + "\" class=\"" + kind + "\">" + text + "</text>\n";
}

/// Whole decades that hold all but a few of the values of both maps.
struct Decades {
    int least = 0, greatest = 1;

    explicit Decades(const ErrorMap& map) {
        std::vector<float> all;
        for (const auto* values : {&map.estimate, &map.truth})
            std::copy_if(values->begin(), values->end(), std::back_inserter(all),
                         [](float v) { return std::isfinite(v) && v > 0; });
        if (all.empty()) return;
        std::sort(all.begin(), all.end());
        constexpr double few = 0.003;
        const auto at = [&](double share) {
            return std::log10(double(all[static_cast<std::size_t>(share * double(all.size() - 1))]));
        };
        greatest = static_cast<int>(std::ceil(at(1 - few)));
        least = std::min(greatest - 1, static_cast<int>(std::floor(at(few))));
    }
    float share(float value) const {
        if (!std::isfinite(value)) return -1;
        return value > 0 ? std::max(0.0f, float((std::log10(double(value)) - least) / (greatest - least))) : 0;
    }
};

std::vector<unsigned char> colored(const ErrorMap& map, const std::vector<float>& values, const Decades& decades) {
    std::vector<float> shares;
    for (const float value : values) shares.push_back(decades.share(value));
    return png_of_shares(shares, static_cast<int>(map.width), static_cast<int>(map.height));
}

std::string scale(const Decades& decades, double top, double height) {
    constexpr int shades = 64, most_labels = 7;
    std::vector<float> ramp;
    for (int i = 0; i < shades; ++i) ramp.push_back(1 - float(i) / (shades - 1));
    std::string text = image(bar_place, top, bar_width, height, png_of_shares(ramp, 1, shades), "pixels");
    const int all = decades.greatest - decades.least, stride = (all + most_labels - 1) / most_labels;
    for (int e = decades.least; e <= decades.greatest; e += stride) {
        const double y = top + height * (decades.greatest - e) / all;
        text += words(bar_place + bar_width + 5, std::clamp(y + 4, top + 10, top + height), "label", power_of_ten(e));
    }
    return text;
}

}  // namespace

double share_within(const ErrorMap& map, double factor) {
    constexpr float rounding = 1e-10f;
    std::size_t known = 0, within = 0;
    for (std::size_t i = 0; i < map.truth.size(); ++i) {
        const float estimate = map.estimate[i], truth = map.truth[i];
        if (!(truth > rounding) || std::isnan(estimate)) continue;
        ++known, within += estimate <= factor * truth && truth <= factor * estimate;
    }
    return known > 0 ? double(within) / double(known) : 1;
}

std::string error_map_svg(const ErrorMap& map) {
    const int w = static_cast<int>(map.width), h = static_cast<int>(map.height);
    const double width = (bar_place - 3 * panel_gap) / 3, height = width * h / w,
                 total = heading_height + height + foot;
    const Decades decades(map);
    std::string svg = "<svg viewBox=\"0 0 " + fixed(page_width) + " " + fixed(total) +
                      "\" role=\"img\" aria-label=\"The picture, its estimated and its true error\">\n";
    const auto panel = [&](int i, const char* heading, const std::vector<unsigned char>& png) {
        const double x = i * (width + panel_gap);
        svg += words(x, 14, "axis", heading) + image(x, heading_height, width, height, png, heading);
    };
    panel(0, "the picture", png_of_colors(map.color, w, h));
    panel(1, "estimated error, pixels", colored(map, map.estimate, decades));
    panel(2, "true error, pixels", colored(map, map.truth, decades));
    return svg + scale(decades, heading_height, height) + "</svg>\n";
}

}  // namespace kagero
