#include "view/sampled_error.h"

#include "accuracy/end_errors.h"
#include "rays/camera.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kagero {

double sampled_error(const Plan& plan) {
    constexpr std::uint32_t columns = 16, rows = 12;
    const FilmDescription& film = plan.description().film;
    TracedRays traced;
    for (std::uint32_t row = 0; row < rows; ++row)
        for (std::uint32_t column = 0; column < columns; ++column) {
            const CameraRay ray =
                camera_ray(plan, (column + 0.5) * film.width / columns, (row + 0.5) * film.height / rows);
            traced.list.starts.push_back(ray.start);
            traced.list.frequencies.push_back(ray.frequency);
        }
    const Tile tile{0, 0, columns * rows, 1};
    const Job job = plan.medium(plan.view.medium).job();
    PathCounters counters;
    trace_paths(plan, job, tile, branch_choice_of(plan), traced, counters);
    std::vector<double> errors;
    for (const EndError& error : EndErrors(plan, true, false).estimate(tile, traced, {}))
        if (std::isfinite(error.position)) errors.push_back(error.position);
    if (errors.empty()) return std::numeric_limits<double>::quiet_NaN();
    const auto percentile = errors.begin() + std::ptrdiff_t(0.99 * double(errors.size() - 1));
    std::nth_element(errors.begin(), percentile, errors.end());
    return *percentile;
}

}  // namespace kagero
