#include "film/standard_error.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kagero {

StandardError summarize_standard_error(const Film& film) {
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    StandardError summary{unknown, unknown, unknown};
    if (!film.has("standard_error")) return summary;
    const std::size_t count = 3 * std::size_t{film.width()} * film.height();
    const float* errors = film.plane("standard_error");
    const float* colors = film.has("color") ? film.plane("color") : nullptr;
    double square = 0, greatest = 0, light = 0;
    std::size_t known = 0;
    for (std::size_t i = 0; i < count; ++i) {
        if (!std::isfinite(errors[i])) continue;
        ++known;
        square += double(errors[i]) * double(errors[i]);
        greatest = std::max(greatest, double(errors[i]));
        if (colors) light += double(colors[i]);
    }
    if (known == 0) return summary;
    summary.rms = std::sqrt(square / double(known));
    summary.max = greatest;
    if (light > 0) summary.relative = summary.rms * double(known) / light;
    return summary;
}

}  // namespace kagero
