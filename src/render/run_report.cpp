#include "render/run_report.h"

#include <functional>

namespace kagero {

void RunTotals::add(const TileReport& report) {
    sums.rays += report.rays;
    sums.counters = combine(sums.counters, report.counters, std::plus{});
    sums.path_lengths.add(report.path_lengths);
    if (sums.generations.size() < report.generations.size()) sums.generations.resize(report.generations.size());
    for (std::size_t i = 0; i < report.generations.size(); ++i) sums.generations[i].add(report.generations[i]);
    for (std::size_t i = 0; i < failure_count; ++i) sums.failures[i] += report.failures[i];
    energy_errors.add(report.energy_errors);
    sums.pixels += report.pixels;
    sums.interpolated_pixels += report.interpolated_pixels;
    interpolation_errors.add(report.interpolation_errors);
}

void RunTotals::write_to(RunReport& report) const {
    report.rays = sums.rays;
    report.counters = sums.counters;
    report.path_lengths = sums.path_lengths;
    report.generations = sums.generations;
    report.failures = sums.failures;
    report.energy_error = energy_errors.percentiles();
    report.pixels = sums.pixels;
    report.interpolated_pixels = sums.interpolated_pixels;
    report.interpolation_error = interpolation_errors.percentiles();
}

}  // namespace kagero
