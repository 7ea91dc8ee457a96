#include "report/error/error_table.h"

#include "plan/names.h"
#include "report/text/numbers.h"

#include <cmath>

namespace kagero {
namespace {

void append(std::string& row, double value) {
    row += ',';
    row += std::isfinite(value) ? shortest(value) : std::string();
}

void append(std::string& row, const Percentiles& spread) {
    for (const double value : {spread.p50, spread.p90, spread.p99, spread.max}) append(row, value);
}

void append(std::string& row, const Timing& time) {
    for (const double value : {time.median, time.min, time.max}) append(row, value);
}

std::string row_of(const StudyCurve& curve, const StudyPoint& point) {
    std::string row = curve.method + ',' + name_of(curve.strategy) + ',' + name_of(curve.precision);
    append(row, point.stated_step);
    append(row, point.time);
    append(row, point.gradients);
    append(row, point.steps);
    append(row, point.errors.position);
    append(row, point.errors.direction);
    append(row, point.errors.pixels);
    append(row, point.errors.above_quarter_pixel);
    row += ',' + std::to_string(point.errors.flips);
    for (const double value : {point.drift.max, point.drift.first_tenth, point.drift.last_tenth}) append(row, value);
    append(row, point.time_without_surfaces);
    append(row, point.queries);
    append(row, point.iterations);
    append(row, point.occupancy);
    append(row, point.solver_tolerance);
    row += curve.has_loose_solver ? ",yes" : ",no";
    return row + '\n';
}

constexpr const char* columns =
    "method,strategy,precision,step,ns_median,ns_min,ns_max,gradients,steps,"
    "position_p50,position_p90,position_p99,position_max,direction_p50,direction_p90,direction_p99,direction_max,"
    "pixels_p50,pixels_p90,pixels_p99,pixels_max,above_quarter_pixel,flips,"
    "drift_max,drift_first_tenth,drift_last_tenth,"
    "ns_without_surfaces_median,ns_without_surfaces_min,ns_without_surfaces_max,queries,iterations,lane_occupancy,"
    "solver_tolerance,loose\n";

}  // namespace

std::string error_text(const ErrorStudy& study) {
    std::string text;
    for (const CheapestPoint& best : study.cheapest) {
        text += "error of 99 % of the rays at most " + shortest(best.bound) +
                (std::string(best.quantity) == "pixels" ? " pixel: " : " rad: ");
        if (!best.found) {
            text += "not reached by any measured point\n";
            continue;
        }
        const StudyCurve& curve = study.curves[best.curve];
        const StudyPoint& point = curve.points[best.point];
        text += curve.method + (curve.info->adaptive ? ", tolerance " : ", step ") + shortest(point.stated_step) +
                ", " + name_of(curve.precision) +
                (curve.has_loose_solver ? ", solver_tolerance " + rounded(point.solver_tolerance) : "") + ", " +
                rounded(1e-3 * point.time.median) + " \u00b5s per ray\n";
    }
    return text;
}

std::string error_csv(const ErrorStudy& study) {
    std::string text = columns;
    for (const StudyCurve& curve : study.curves)
        for (const StudyPoint& point : curve.points) text += row_of(curve, point);
    return text;
}

std::string error_plot(const Plan& plan, const ErrorStudy& study) {
    // The script refers to columns of results.csv by number, counted from 1: 1 method, 2 strategy, 3 precision,
    // 5 ns_median, 11 position_p90, 34 loose.
    std::string title;
    for (const char c : plan.description().path) title += c == '\'' ? std::string("''") : std::string(1, c);
    std::string text =
        "# Plots error against run time from results.csv in this directory: `gnuplot plot.gp` writes plot.svg.\n"
        "set terminal svg size 900,620 font 'sans,12' background rgb 'white'\n"
        "set output 'plot.svg'\n"
        "set datafile separator ','\n"
        "set logscale xy\nset format y '10^{%L}'\nset grid\nset key outside right\n"
        "set title '" +
        title +
        "' noenhanced\n"
        "set xlabel 'ns per ray'\nset ylabel 'position error of 90 % of the rays, scene units'\n"
        "pick(method, precision, loose) = strcol(1) eq method && strcol(2) eq '" +
        std::string(name_of(study.main_strategy)) + "' && strcol(3) eq precision && strcol(34) eq loose\n";
    const char* between = "plot \\\n    ";
    for (const StudyCurve& curve : study.curves) {
        if (curve.strategy != study.main_strategy) continue;
        const std::string precision = name_of(curve.precision);
        text += std::string(between) + "'results.csv' skip 1 using (pick('" + curve.method + "', '" + precision +
                "', '" + (curve.has_loose_solver ? "yes" : "no") +
                "') ? $5 : 1/0):(column(11) > 0 ? column(11) : 1/0) with linespoints title '" + curve.method +
                (curve.precision == Precision::float32 ? " float"
                 : curve.has_loose_solver              ? " loose"
                                                       : "") +
                "' noenhanced";
        between = ", \\\n    ";
    }
    return text + "\n";
}

}  // namespace kagero
