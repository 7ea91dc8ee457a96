#include "report/error/error_html.h"

#include "plan/names.h"
#include "report/error/error_charts.h"
#include "report/error/error_map.h"
#include "report/error/method_style.h"
#include "report/machine.h"
#include "report/text/numbers.h"
#include "report/text/page.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace kagero {
namespace {

using Cells = std::vector<std::string>;
using Rows = std::vector<Cells>;

std::string percent_or_dash(double share) { return std::isfinite(share) ? html_number(100 * share) + " %" : "–"; }

std::string step_text(bool adaptive, double step) { return (adaptive ? "tolerance " : "step ") + html_number(step); }

std::string nanoseconds_text(double nanoseconds) {
    if (nanoseconds >= 1e6) return html_number(nanoseconds / 1e6) + " ms";
    return nanoseconds >= 1e4 ? html_number(nanoseconds / 1e3) + " µs" : html_number(nanoseconds) + " ns";
}

std::string bound_text(const CheapestPoint& best) {
    if (best.quantity == std::string("direction")) return html_number(best.bound) + " rad in direction";
    return best.bound == 0.25 ? "¼ pixel" : html_number(best.bound) + " pixel";
}

/// Returns true if some rays have an end point whose error can be measured. Captured rays have none.
bool has_end_points(const ErrorStudy& study) { return std::isfinite(study.reference.uncertainty.p99); }

std::string facts(const Plan& plan, const ErrorStudy& study) {
    const ReferenceSummary& reference = study.reference;
    std::string text = "<div class=\"facts\">\n";
    text += html_fact(html_number(double(study.sample.starts.size())) + " rays",
                      "through the middles of a grid of " + std::to_string(study.sample.width) + " × " +
                          std::to_string(study.sample.height) + " pixels of the film");
    text += html_fact(html_text(plan.description().space.hamiltonian),
                      "space; the method of the scene is " + html_text(plan.method().name));
    if (has_end_points(study))
        text += html_fact(html_number(reference.uncertainty.p99) + " units",
                          "uncertainty of the reference for 99 % of the rays: difference of " +
                              html_text(reference.method) + " and " + html_text(reference.confirming_method));
    text += html_fact(html_text(plan.module().isa) + ", " + std::to_string(study.options.threads) +
                          (study.options.threads == 1 ? " thread" : " threads"),
                      html_text(processor_name()) + "; kernels compiled by " + html_text(plan.module().compiler));
    return text + "</div>\n";
}

std::string cheapest_section(const ErrorStudy& study) {
    Rows rows;
    for (const CheapestPoint& best : study.cheapest) {
        if (!best.found) {
            rows.push_back({bound_text(best), "not reached", "", "", "", ""});
            continue;
        }
        const StudyCurve& curve = study.curves[best.curve];
        const StudyPoint& point = curve.points[best.point];
        rows.push_back({bound_text(best),
                        "<b>" + html_text(curve.method) + "</b>" +
                            (curve.has_loose_solver ? ", solver tolerance " + html_number(point.solver_tolerance) : ""),
                        name_of(curve.precision), step_text(curve.info->adaptive, point.stated_step),
                        nanoseconds_text(point.time.median), html_number(point.gradients)});
    }
    return "<section class=\"keep\"><h2>Cheapest method for an error bound</h2>\n" +
           html_table({"error bound", "method", "precision", "step", "time per ray", "gradients per ray"}, rows, 4) +
           "<p class=\"note\">The fastest of all measured points whose 99th percentile of the error is within the "
           "bound. In addition, at most 1 % of the rays may be flips: rays with another status or object than the "
           "reference.</p></section>\n";
}

std::string legend(const ErrorStudy& study) {
    std::string text = "<p class=\"note\">";
    for (const FamilyStyle& family : family_styles()) {
        if (std::none_of(study.curves.begin(), study.curves.end(),
                         [&](const StudyCurve& curve) { return curve.info->family == family.family; }))
            continue;
        text += "<span class=\"key\"><span style=\"color:" + family.color() + "\">■</span> " + html_text(family.name) +
                "</span> ";
    }
    return text + "</p>\n";
}

/// Returns one chart per family of methods, for families with methods that the first chart leaves out.
std::string families_section(const Plan& plan, const ErrorStudy& study) {
    std::string text;
    for (const FamilyStyle& family : family_styles())
        if (const std::string svg = family_chart(plan, study, family.family); !svg.empty())
            text += html_figure(std::string("Error against run time: ") + family.name, svg,
                                "All methods of this family. Dashed: single precision. Dotted: with a solver tolerance "
                                "of a hundredth of the direction error at the same step.");
    return text;
}

std::string order_section(const ErrorStudy& study) {
    Rows rows;
    for (const StudyCurve& curve : study.curves) {
        if (!study.is_main(curve) || curve.has_loose_solver) continue;
        rows.push_back({"<span style=\"color:" + style_of(*curve.info).color + "\">■</span> " +
                            html_text(curve.method) + (curve.is_scene_method ? " <b>(method of the scene)</b>" : ""),
                        html_text(curve.info->what), curve.rescaled ? "yes" : "no",
                        curve.info->adaptive ? "adaptive" : std::to_string(curve.info->order),
                        curve.order ? fixed(*curve.order, 2) : "–", curve.floor ? html_number(*curve.floor) : "–"});
    }
    return "<section><h2>Observed order</h2>\n" +
           html_table({"method", "description", "time rescaling", "stated order", "observed order", "least error"},
                      rows, 2) +
           "<p class=\"note\">Observed order: the slope of log(error) against log(step) at the smallest steps whose "
           "error is above rounding. The error is the 90th percentile of the position error. For a method of order p, "
           "half the step divides the error by 2<sup>p</sup>. Least error: the smallest error that was reached, in "
           "scene units. If rays start and end where they are nearly straight, leading error terms may cancel, and the "
           "observed order is then greater. Time rescaling: the method integrates Ω·(H − H₀), so that a fixed step is "
           "short where rays are strongly curved and long elsewhere.</p></section>\n";
}

std::string pictures_section(const ErrorStudy& study) {
    if (study.pictures.empty()) return "";
    Rows rows;
    for (const PictureError& picture : study.pictures)
        rows.push_back({html_text(picture.method), step_text(picture.adaptive, picture.step),
                        html_number(picture.gradients), percent_or_dash(picture.wrong_pixels), html_number(picture.rms),
                        picture.psnr ? fixed(*picture.psnr, 1) + " dB" : "∞",
                        html_number(1000 * picture.seconds) + " ms"});
    return "<section class=\"keep\"><h2>Errors of the picture</h2>\n" +
           html_table({"method", "step", "gradients per ray", "wrong pixels", "RMS", "PSNR", "render time"}, rows, 2) +
           "<p class=\"note\">Pictures of the scene, at most 128 pixels wide, compared with a picture by the reference "
           "method. Each method has the measured step whose gradient evaluations per ray are nearest to those of the "
           "scene's method. The numbers can still differ much. A pixel is wrong if a linear colour differs by more "
           "than 1/255 of white. RMS is the root mean square difference of the linear colours; white is "
           "1.</p></section>\n";
}

Cells point_cells(const StudyPoint& point) {
    const RayErrors& e = point.errors;
    return {html_number(point.stated_step),
            html_number(point.time.median),
            html_number(point.time_without_surfaces.median),
            html_number(point.gradients),
            html_number(point.steps),
            html_number(e.position.p50),
            html_number(e.position.p90),
            html_number(e.position.p99),
            html_number(e.position.max),
            html_number(e.direction.p99),
            html_number(e.pixels.p99),
            percent_or_dash(e.above_quarter_pixel),
            e.flips ? "<span class=\"bad\">" + std::to_string(e.flips) + "</span>" : "0",
            e.compared_ill_conditioned ? html_number(e.ill_conditioned_pixels.max) : "–",
            html_number(point.drift.max)};
}

std::string curve_details(const StudyCurve& curve) {
    Rows rows;
    for (const StudyPoint& point : curve.points) rows.push_back(point_cells(point));
    return "<details><summary>" + html_text(curve.method) + ", " + name_of(curve.strategy) + ", " +
           name_of(curve.precision) + (curve.has_loose_solver ? ", loose solver tolerance" : "") + "<small>" +
           html_text(curve.stop_reason) + "</small></summary>\n" +
           html_table({curve.info->adaptive ? "tolerance" : "step", "ns", "ns, no surfaces", "gradients", "steps",
                       "position p50", "p90", "p99", "max", "direction p99", "pixels p99", "&gt; ¼ pixel", "flips",
                       "ill-cond.", "drift of H"},
                      rows, 0) +
           "</details>\n";
}

std::string data_section(const ErrorStudy& study) {
    std::string text =
        "<section><h2>All points</h2>\n<p class=\"note\">Times and counts are per ray. Position errors are in scene "
        "units, direction errors in radians. Flips: rays with another status or object than the reference; they are "
        "left out of all percentiles. Ill-cond.: ill-conditioned rays, for which the angle between neighbouring rays "
        "grows by a factor above 1000 (" +
        std::to_string(study.ill_conditioned_rays) +
        " rays of the sample). The column shows their greatest pixel error divided by that factor. In the percentiles "
        "of pixels, their errors are divided by a thousandth of the factor; all other percentiles leave them out. No "
        "surfaces: the same rays in a scene without surfaces. They end when they leave the scene, or after the number "
        "of steps within which 99 % of the rays end in the scene with surfaces.</p>\n";
    for (const StudyCurve& curve : study.curves) text += curve_details(curve);
    if (!study.refused.empty()) {
        text += "<p class=\"note\">Methods that cannot integrate this space:";
        for (const std::string& name : study.refused) text += " <code>" + html_text(name) + "</code>";
        text += "</p>\n";
    }
    return text + "</section>\n";
}

std::string map_section(const ErrorStudy& study) {
    if (study.map.truth.empty() || !has_end_points(study)) return "";
    const double within = share_within_factor(study.map, 3);
    return html_figure(
        "Error map of the picture", error_map_svg(study.map),
        "Left: the picture with the method and step of the scene. Middle: the error that rendering estimates "
        "(layer position_error). Right: the distance to the reference, with the same colour scale. Grey "
        "pixels have no error, because the second trace of the ray has another status or object. "
        "Captured rays are black. Up to 0.3 % of the values lie beyond either end of the scale. The "
        "estimate is within a factor of 3 of the true error in " +
            fixed(100 * within, 1) + " % of the pixels whose true error is known and above rounding.");
}

std::string reference_section(const ErrorStudy& study) {
    const ReferenceSummary& r = study.reference;
    return "<section><h2>Method of measurement</h2>\n<p>The rays of the scene's camera are traced by the kernels and "
           "the loop that <code>render</code> uses; only the method, its step and the precision change. The reference "
           "is " +
           html_text(r.method) + (r.adaptive ? " at tolerance " : " at step ") + html_number(r.step) +
           ". A second method confirms it: " + html_text(r.confirming_method) +
           (r.confirming_adaptive ? " at tolerance " : " at step ") + html_number(r.confirming_step) +
           (has_end_points(study) ? ". The distance of their end points is " + html_number(r.uncertainty.p50) +
                                        " (median), " + html_number(r.uncertainty.p99) + " (99th percentile) and " +
                                        html_number(r.uncertainty.max) + " (maximum), in scene units. "
                                  : std::string(". ")) +
           (r.unconfirmed ? html_number(double(r.unconfirmed)) +
                                " rays are left out, because the two methods disagree on their status or object. "
                          : std::string("Both agree on the status and object of every ray. ")) +
           (study.options.repeats == 1
                ? std::string("Times are medians of interleaved runs; long runs are not repeated. They were measured "
                              "on ")
                : "Times are medians of at least " + std::to_string(study.options.repeats) +
                      " interleaved runs. They were measured on ") +
           (study.options.quick ? std::string("a quarter of the rays (blocks of 64 neighbouring rays), with ")
                                : std::string()) +
           std::to_string(study.options.threads) + (study.options.threads == 1 ? " thread" : " threads") +
           ".</p></section>\n";
}

}  // namespace

std::string error_page(const Plan& plan, const ErrorStudy& study) {
    const std::string name = std::filesystem::path(plan.description().path).stem().string();
    std::string body;
    if (study.interrupted)
        body += "<p class=\"bad\">The study was interrupted: some points are missing or have fewer timed runs.</p>\n";
    if (plan.scene->straight)
        body +=
            "<p>Every ray of this scene is a straight line, so that no integrator runs. All errors are rounding "
            "errors.</p>\n";
    else if (!has_end_points(study))
        body +=
            "<p>Every ray of this scene is captured or fails, so that there are no end points whose error could be "
            "measured.</p>\n";
    body += facts(plan, study) + cheapest_section(study);
    body +=
        html_figure(
            "Error against run time", work_precision_chart(plan, study, Work::nanoseconds),
            "Each mark is one step size, or one tolerance of an adaptive method. Lower marks are more accurate; marks "
            "further left are faster. The best method for an error is the leftmost line at that height. Dashed: single "
            "precision. Dotted: with a solver tolerance of a hundredth of the direction error at the same step instead "
            "of that of the scene. Thick: the method of the scene, and the recipe as printed in Satoh (2003).") +
        legend(study);
    body += html_figure(
        "Error against work", work_precision_chart(plan, study, Work::gradients),
        "The same errors against the number of gradient evaluations of H, which does not depend on the machine. A "
        "method that is further left in this chart than in the chart above spends much of its time on other work, such "
        "as intersections and the solution of implicit equations.");
    body += order_section(study);
    body += families_section(plan, study);
    if (!study.energy_traces.empty())
        body += html_figure(
            "H along one ray", energy_chart(plan, study),
            "One well-conditioned ray of the sample: the one at which the angle between neighbouring rays grows most, "
            "by a factor below 100. Each method has the measured step whose gradient evaluations per ray (see the "
            "labels) are nearest to those of the scene's method. On the exact ray H is constant. The error is "
            "|H − H₀| / (½|p|² + |H₀|) with the momentum p at the start of the ray. A small error of H does not imply "
            "a small error of the path.");
    body += html_figure("Strategies and instruction sets", strategy_chart(study),
                        "Run time per ray with the method and step of the scene, for every instruction set that this "
                        "machine supports and kagero was built for. The whisker spans the fastest and the slowest run. "
                        "Scalar: one ray at a time without SIMD. Per-ray: one ray at a time, whose gradient components "
                        "or stages are in the lanes. Packet: one ray in every lane. Factors are speedups over the "
                        "first scalar bar in double precision.");
    body += map_section(study) + pictures_section(study) + reference_section(study) + data_section(study);
    return html_page("Error against run time: " + name, plan.description().path + " · " + plan.scene->space.info().what,
                     body);
}

}  // namespace kagero
