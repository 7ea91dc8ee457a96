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

std::string tip_of(const StudyCurve& curve, const StudyPoint& point) {
    const std::string time = std::isfinite(point.time.median) ? rounded(point.time.median) + " ns" : "not timed";
    return curve.method + " " + name_of(curve.precision) + (curve.info->adaptive ? ", tolerance " : ", step ") +
           short_number(point.stated_step) + ": " + time + ", " + rounded(point.gradients) +
           " gradients per ray; 90 % of the rays within " + short_number(point.errors.pixels.p90) + " pixel";
}

bool emphasised(const StudyCurve& curve) {
    return curve.own || (curve.info->family == Family::recipe && curve.info->typical);
}

Series series_of(const ErrorStudy& study, const StudyCurve& curve, Work work) {
    const MethodStyle style = style_of(*curve.info);
    Series series{curve.method, style.color, style.mark,
                  false,        false,       emphasised(curve) && study.shows(curve) && !curve.loose,
                  {},           {}};
    if (curve.loose) series.label += " loose", series.dotted = true;
    if (curve.precision == Precision::float32) series.label += " float", series.dashed = true;
    for (const StudyPoint& point : curve.points) {
        series.points.push_back(
            {work == Work::nanoseconds ? point.time.median : point.gradients, point.errors.pixels.p90});
        series.tips.push_back(tip_of(curve, point));
    }
    return series;
}

const char* color_of(Strategy strategy) {
    return strategy == Strategy::scalar ? "var(--soft)" : strategy == Strategy::per_ray ? "#c9741f" : "#2f6fb0";
}

/// Curves that the first charts show: few enough to be told apart.
bool represents(const ErrorStudy& study, std::size_t index) {
    const StudyCurve& curve = study.curves[index];
    if (curve.strategy != study.strategy) return false;
    if (curve.own) return true;
    for (const Cheapest& best : study.cheapest)
        if (best.found && best.curve == index) return true;
    return curve.precision == study.precision && !curve.loose && curve.info->typical;
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
    chart.bounds = {{0.25, "¼ pixel"}, {1e-3, "1/1000 pixel"}};
    chart.doubtful = study.reference.pixels.p90;
    chart.doubtful_label = "below the reference's own uncertainty";
    chart.least_y = std::max(1e-15, 0.1 * study.reference.pixels.p90);
    return svg_of(chart);
}

}  // namespace

std::string work_precision_chart(const Plan& plan, const ErrorStudy& study, Work work) {
    std::vector<const StudyCurve*> curves;
    for (std::size_t i = 0; i < study.curves.size(); ++i) {
        const StudyCurve& curve = study.curves[i];
        // Work does not depend on precision; drawing both would only double the lines.
        if (curve.precision != study.precision && work == Work::gradients) continue;
        if (represents(study, i)) curves.push_back(&curve);
    }
    return chart_of(plan, study, curves, work);
}

std::string family_chart(const Plan& plan, const ErrorStudy& study, Family family) {
    std::vector<const StudyCurve*> curves;
    bool more = false;
    for (std::size_t i = 0; i < study.curves.size(); ++i) {
        const StudyCurve& curve = study.curves[i];
        if (curve.strategy != study.strategy || curve.info->family != family) continue;
        curves.push_back(&curve);
        more |= !represents(study, i);
    }
    return more ? chart_of(plan, study, curves, Work::nanoseconds) : "";
}

std::string energy_chart(const Plan& plan, const ErrorStudy& study) {
    LineChart chart;
    chart.title = "Error of H along one ray of " + plan.description().path;
    chart.x = {"parameter λ along the ray", false};
    chart.y.title = "|H − H₀| relative";
    for (const EnergyTrace& trace : study.energy) {
        const MethodStyle style = style_of(*trace.info);
        const bool own = trace.info->name == plan.method().name;
        Series series{trace.info->name,
                      style.color,
                      trace.points.size() > 60 ? Mark::none : style.mark,
                      false,
                      false,
                      own,
                      {},
                      {}};
        // Points where the error changes sign are accidents; the floor keeps them from ruling the axis.
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
    double yardstick = 0;
    for (const StrategyTime& one : study.strategies) {
        const KernelInfo& kernel = *one.kernel;
        const bool scalar = kernel.strategy == Strategy::scalar;
        if (yardstick == 0 && scalar && kernel.precision == Precision::float64) yardstick = one.time.median;
    }
    for (const StrategyTime& one : study.strategies) {
        if (!std::isfinite(one.time.median)) continue;
        const KernelInfo& kernel = *one.kernel;
        std::string what = one.isa + " " + name_of(kernel.strategy);
        if (kernel.form != Form::none) what += std::string(" ") + name_of(kernel.form);
        std::string words = short_number(std::round(one.time.median)) + " ns";
        if (one.time.median >= 1000) words = short_number(one.time.median / 1000) + " µs";
        if (yardstick > 0) words += " · " + short_number(yardstick / one.time.median) + "×";
        chart.bars.push_back({what + ", " + name_of(kernel.precision), color_of(kernel.strategy), words,
                              one.time.median, one.time.min, one.time.max});
    }
    return svg_of(chart);
}

}  // namespace kagero
