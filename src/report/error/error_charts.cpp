#include "report/error/error_charts.h"

#include "plan/names.h"
#include "report/error/method_style.h"
#include "report/text/numbers.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace kagero {
namespace {

std::string short_number(double value) {
    char buffer[40];
    return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::general, 3).ptr};
}

std::string tooltip_of(const StudyCurve& curve, const StudyPoint& point) {
    const std::string time = std::isfinite(point.time.median) ? rounded(point.time.median) + " ns" : "not timed";
    return curve.method + " " + name_of(curve.precision) + (curve.info->adaptive ? ", tolerance " : ", step ") +
           short_number(point.stated_step) + ": " + time + ", " + rounded(point.gradients) +
           " gradients per ray; error of at most " + short_number(point.errors.pixels.p90) +
           " pixel for 90 % of the rays";
}

/// Returns true for the method of the scene and for the representative method of the family `recipe`.
bool is_emphasized(const StudyCurve& curve) {
    return curve.is_scene_method || (curve.info->family == MethodFamily::recipe && curve.info->representative);
}

Series series_of(const ErrorStudy& study, const StudyCurve& curve, Work work) {
    const MethodStyle style = style_of(*curve.info);
    Series series{curve.method, style.color, style.mark,
                  false,        false,       is_emphasized(curve) && study.is_main(curve) && !curve.has_loose_solver,
                  {},           {}};
    if (curve.has_loose_solver) {
        series.label += " loose";
        series.dotted = true;
    }
    if (curve.precision == Precision::float32) {
        series.label += " float";
        series.dashed = true;
    }
    for (const StudyPoint& point : curve.points) {
        series.points.push_back(
            {work == Work::nanoseconds ? point.time.median : point.gradients, point.errors.pixels.p90});
        series.tooltips.push_back(tooltip_of(curve, point));
    }
    return series;
}

const char* color_of(Strategy strategy) {
    return strategy == Strategy::scalar ? "var(--soft)" : strategy == Strategy::per_ray ? "#c9741f" : "#2f6fb0";
}

/// Returns true if the work-precision charts contain this curve. They contain few curves, so that the lines remain
/// distinct.
bool is_in_overview(const ErrorStudy& study, std::size_t index) {
    const StudyCurve& curve = study.curves[index];
    if (curve.strategy != study.main_strategy) return false;
    if (curve.is_scene_method) return true;
    for (const CheapestPoint& best : study.cheapest)
        if (best.found && best.curve == index) return true;
    return curve.precision == study.main_precision && !curve.has_loose_solver && curve.info->representative;
}

std::string chart_of(const Plan& plan, const ErrorStudy& study, const std::vector<const StudyCurve*>& curves,
                     Work work) {
    LineChart chart;
    const bool time = work == Work::nanoseconds;
    chart.title = std::string("Pixel error against ") + (time ? "run time" : "gradient evaluations") + " for " +
                  plan.description().path;
    chart.x.title = time ? "run time per ray, ns (median)" : "gradient evaluations per ray";
    chart.y.title = "error of 90 % of the rays, pixels";
    for (const StudyCurve* curve : curves) chart.series.push_back(series_of(study, *curve, work));
    chart.horizontal_lines = {{0.25, "¼ pixel"}, {1e-3, "1/1000 pixel"}};
    chart.shaded_below = study.reference.pixels.p90;
    chart.shaded_label = "below the uncertainty of the reference";
    chart.least_y = std::max(1e-15, 0.1 * study.reference.pixels.p90);
    return svg_of(chart);
}

}  // namespace

std::string work_precision_chart(const Plan& plan, const ErrorStudy& study, Work work) {
    std::vector<const StudyCurve*> curves;
    for (std::size_t i = 0; i < study.curves.size(); ++i) {
        const StudyCurve& curve = study.curves[i];
        // The number of gradient evaluations is about the same in both precisions. Its chart shows only the main one.
        if (curve.precision != study.main_precision && work == Work::gradients) continue;
        if (is_in_overview(study, i)) curves.push_back(&curve);
    }
    return chart_of(plan, study, curves, work);
}

std::string family_chart(const Plan& plan, const ErrorStudy& study, MethodFamily family) {
    std::vector<const StudyCurve*> curves;
    bool has_other_curves = false;
    for (std::size_t i = 0; i < study.curves.size(); ++i) {
        const StudyCurve& curve = study.curves[i];
        if (curve.strategy != study.main_strategy || curve.info->family != family) continue;
        curves.push_back(&curve);
        has_other_curves |= !is_in_overview(study, i);
    }
    return has_other_curves ? chart_of(plan, study, curves, Work::nanoseconds) : "";
}

std::string energy_chart(const Plan& plan, const ErrorStudy& study) {
    LineChart chart;
    chart.title = "Error of H along one ray of " + plan.description().path;
    chart.x = {"parameter λ along the ray", false};
    chart.y.title = "|H − H₀| relative";
    for (const EnergyTrace& trace : study.energy_traces) {
        const MethodStyle style = style_of(*trace.info);
        const bool is_scene_method = trace.info->name == plan.method().name;
        Series series{trace.info->name,
                      style.color,
                      trace.points.size() > 60 ? Mark::none : style.mark,
                      false,
                      false,
                      is_scene_method,
                      {},
                      {}};
        // Point 0, the ray start, is left out, because its error is a rounding error. Near a change of sign the error
        // can be arbitrarily small. The lower bound of 1e-17 limits the range of the axis.
        for (std::size_t i = 1; i < trace.points.size(); ++i)
            series.points.push_back({trace.points[i][0], std::max(std::abs(trace.points[i][1]), 1e-17)});
        series.label += (trace.info->adaptive ? ", tolerance " : ", step ") + short_number(trace.step) + ", " +
                        rounded(trace.gradients) + " gradients";
        chart.series.push_back(std::move(series));
    }
    chart.least_y = 1e-17;
    return svg_of(chart);
}

std::string strategy_chart(const ErrorStudy& study) {
    BarChart chart;
    chart.title = "Run time per ray by strategy and instruction set";
    double baseline = 0;  // Time of the first scalar kernel in double; 0 if there is none.
    for (const StrategyTime& timed : study.strategies) {
        const KernelInfo& kernel = *timed.kernel;
        const bool scalar = kernel.strategy == Strategy::scalar;
        if (baseline == 0 && scalar && kernel.precision == Precision::float64) baseline = timed.time.median;
    }
    for (const StrategyTime& timed : study.strategies) {
        if (!std::isfinite(timed.time.median)) continue;
        const KernelInfo& kernel = *timed.kernel;
        std::string label = timed.isa + " " + name_of(kernel.strategy);
        if (kernel.form != Form::none) label += std::string(" ") + name_of(kernel.form);
        std::string value_text = short_number(std::round(timed.time.median)) + " ns";
        if (timed.time.median >= 1000) value_text = short_number(timed.time.median / 1000) + " µs";
        if (baseline > 0) value_text += " · " + short_number(baseline / timed.time.median) + "×";
        chart.bars.push_back({label + ", " + name_of(kernel.precision), color_of(kernel.strategy), value_text,
                              timed.time.median, timed.time.min, timed.time.max});
    }
    return svg_of(chart);
}

}  // namespace kagero
