#include "report/error/error_html.h"

#include "plan/names.h"
#include "report/error/error_charts.h"
#include "report/error/error_map.h"
#include "report/machine.h"
#include "report/error/method_style.h"
#include "report/text/numbers.h"
#include "report/text/page.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace kagero {
namespace {

using Cells = std::vector<std::string>;
using Rows = std::vector<Cells>;

std::string percent_or_dash(double share) {
    return std::isfinite(share) ? html_number(100 * share) + " %" : "–";
}

std::string step_text(bool adaptive, double step) {
    return (adaptive ? "tolerance " : "step ") + html_number(step);
}

std::string nanoseconds_text(double nanoseconds) {
    if (nanoseconds >= 1e6) return html_number(nanoseconds / 1e6) + " ms";
    return nanoseconds >= 1e4 ? html_number(nanoseconds / 1e3) + " µs" : html_number(nanoseconds) + " ns";
}

std::string bound_text(const Cheapest& best) {
    if (best.measure == std::string("direction")) return html_number(best.error) + " rad in direction";
    return best.error == 0.25 ? "¼ pixel" : html_number(best.error) + " pixel";
}

/// Whether any ray ends where two methods can be compared: captured rays do not.
bool has_ends(const ErrorStudy& study) {
    return std::isfinite(study.reference.uncertainty.p99);
}

std::string facts(const Plan& plan, const ErrorStudy& study) {
    const ReferenceStory& reference = study.reference;
    std::string text = "<div class=\"facts\">\n";
    text += html_fact(html_number(double(study.sample.starts.size())) + " rays",
                      "through a grid of " + std::to_string(study.sample.width) + " × " +
                          std::to_string(study.sample.height) + " pixels of the film");
    text += html_fact(html_text(plan.description().space.hamiltonian),
                      "bends the light; the scene's own method is " + html_text(plan.method().name));
    if (has_ends(study))
        text += html_fact(html_number(reference.uncertainty.p99) + " units",
                          "uncertainty of the reference: " + html_text(reference.method) + " against " +
                              html_text(reference.confirmed_by) + ", 99 % of the rays");
    text += html_fact(html_text(plan.module().isa) + ", " + std::to_string(study.options.threads) +
                          (study.options.threads == 1 ? " thread" : " threads"),
                      html_text(processor_name()) + "; kernels by compiler " + html_text(plan.module().compiler));
    return text + "</div>\n";
}

std::string cheapest_section(const ErrorStudy& study) {
    Rows rows;
    for (const Cheapest& best : study.cheapest) {
        if (!best.found) {
            rows.push_back({bound_text(best), "none of the points", "", "", "", ""});
            continue;
        }
        const StudyCurve& curve = study.curves[best.curve];
        const StudyPoint& point = curve.points[best.point];
        rows.push_back({bound_text(best),
                        "<b>" + html_text(curve.method) + "</b>" +
                            (curve.loose ? ", solved to " + html_number(point.solver_tolerance) : ""),
                        name_of(curve.precision), step_text(curve.info->adaptive, point.stated_step),
                        nanoseconds_text(point.time.median), html_number(point.gradients)});
    }
    return "<section class=\"keep\"><h2>Cheapest method for an error</h2>\n" +
           html_table({"99 % of the rays within", "method", "precision", "step", "per ray", "gradients"}, rows, 4) +
           "<p class=\"note\">The quickest point of all below whose 99th percentile stays within the bound, and of "
           "whose rays at "
           "most 1 % end "
           "otherwise than they should.</p></section>\n";
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

/// Every method beside its siblings, where the first chart shows one of them only.
std::string families_section(const Plan& plan, const ErrorStudy& study) {
    std::string text;
    for (const FamilyStyle& family : family_styles())
        if (const std::string svg = family_chart(plan, study, family.family); !svg.empty())
            text += html_figure(std::string("Run time, family by family: ") + family.name, svg,
                                "All methods of the family; dashed: single precision, dotted: loosely solved.");
    return text;
}

std::string order_section(const ErrorStudy& study) {
    Rows rows;
    for (const StudyCurve& curve : study.curves) {
        if (!study.shows(curve) || curve.loose) continue;
        rows.push_back({"<span style=\"color:" + style_of(*curve.info).color + "\">■</span> " +
                            html_text(curve.method) + (curve.own ? " <b>(the scene's)</b>" : ""),
                        html_text(curve.info->what), curve.rescaled ? "yes" : "no",
                        curve.info->adaptive ? "adaptive" : std::to_string(curve.info->order),
                        curve.order ? fixed(*curve.order, 2) : "–", curve.floor ? html_number(*curve.floor) : "–"});
    }
    return "<section><h2>Observed order</h2>\n" +
           html_table({"method", "", "rescaled time", "stated", "observed", "least error"}, rows, 2) +
           "<p class=\"note\">Observed order: the slope of log position error (90 % of the rays) over log step, at the "
           "finest "
           "steps above rounding. "
           "Halving the step of a method of order p divides its error by 2<sup>p</sup>. Least error: the smallest "
           "reached, in "
           "scene units. "
           "Where rays begin and end in what hardly bends them leading errors may cancel, and a method does better "
           "than its order. "
           "Rescaled time: the method follows Ω·H, by which a fixed step is short where light bends and long where it "
           "does "
           "not.</p></section>\n";
}

std::string pictures_section(const ErrorStudy& study) {
    if (study.pictures.empty()) return "";
    Rows rows;
    for (const PictureError& picture : study.pictures)
        rows.push_back({html_text(picture.method), step_text(picture.adaptive, picture.step),
                        html_number(picture.gradients), percent_or_dash(picture.wrong_pixels), html_number(picture.rms),
                        picture.psnr ? fixed(*picture.psnr, 1) + " dB" : "∞",
                        html_number(1000 * picture.seconds) + " ms"});
    return "<section class=\"keep\"><h2>What it does to the picture</h2>\n" +
           html_table({"method", "", "gradients per ray", "wrong pixels", "RMS", "PSNR", "rendering"}, rows, 2) +
           "<p class=\"note\">The scene at most 128 pixels wide, against the picture by the reference method; each "
           "method at that of its "
           "points below whose gradient evaluations per ray are nearest to those of the scene's own, which may still "
           "be far from them. A pixel is wrong where a colour is off by more than 1/255 (linear; white is "
           "1).</p></section>\n";
}

Cells point_cells(const StudyPoint& point) {
    const RayErrors& e = point.errors;
    return {html_number(point.stated_step),
            html_number(point.time.median),
            html_number(point.time_without.median),
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
            e.ill ? html_number(e.ill_pixels.max) : "–",
            html_number(point.drift.max)};
}

std::string curve_details(const StudyCurve& curve) {
    Rows rows;
    for (const StudyPoint& point : curve.points) rows.push_back(point_cells(point));
    return "<details><summary>" + html_text(curve.method) + ", " + name_of(curve.strategy) + ", " +
           name_of(curve.precision) + (curve.loose ? ", loosely solved" : "") + "<small>" + html_text(curve.stopped) +
           "</small></summary>\n" +
           html_table({curve.info->adaptive ? "tolerance" : "step", "ns", "ns, no surfaces", "gradients", "steps",
                       "position p50", "p90", "p99", "max", "direction p99", "pixels p99", "&gt; ¼ pixel", "flips",
                       "ill", "drift of H"},
                      rows, 0) +
           "</details>\n";
}

std::string data_section(const ErrorStudy& study) {
    std::string text =
        "<section><h2>All points</h2>\n<p class=\"note\">Per ray. Flips: rays that end otherwise than they should, or "
        "on another "
        "object; they enter no percentile. "
        "Ill: of rays that turn their neighbours apart more than a thousandfold (" +
        std::to_string(study.ill_conditioned) +
        " of the sample), the greatest pixel error over that factor; beyond a thousand it divides what they add to "
        "pixels, and they enter no other "
        "percentile. No surfaces: the same rays "
        "with nothing to meet, until they leave "
        "the scene or have taken as many steps as 99 % of those that meet something.</p>\n";
    for (const StudyCurve& curve : study.curves) text += curve_details(curve);
    if (!study.refused.empty()) {
        text += "<p class=\"note\">This space cannot be served by:";
        for (const std::string& name : study.refused) text += " <code>" + html_text(name) + "</code>";
        text += "</p>\n";
    }
    return text + "</section>\n";
}

std::string map_section(const ErrorStudy& study) {
    if (study.map.truth.empty() || !has_ends(study)) return "";
    const double within = share_within(study.map, 3);
    return html_figure("Where the picture is wrong", error_map_svg(study.map),
                       "The scene by its own method and step. In the middle what rendering can say of it (the layer "
                       "position_error), on the "
                       "right the distance to the reference; the colours mean the same. Grey: another object, or none, "
                       "when traced otherwise; "
                       "captured rays are black; a few values lie beyond the scale. In " +
                           fixed(100 * within, 1) +
                           " % of the pixels whose true error is known and above rounding the estimate is right within "
                           "a factor of 3.");
}

std::string reference_section(const ErrorStudy& study) {
    const ReferenceStory& r = study.reference;
    return "<section><h2>How it was measured</h2>\n<p>The rays of the scene's camera run through the kernels and the "
           "loop that "
           "<code>render</code> uses; only the integrator, its step "
           "and its precision change. Where they should end is told by " +
           html_text(r.method) + (r.adaptive ? " at tolerance " : " at step ") + html_number(r.step) +
           " and confirmed by " + html_text(r.confirmed_by) + (r.confirmed_adaptive ? " at tolerance " : " at step ") +
           html_number(r.confirmed_step) +
           (has_ends(study)
                ? ": their end points lie " + html_number(r.uncertainty.p50) + " apart (median), " +
                      html_number(r.uncertainty.p99) + " (99 %), " + html_number(r.uncertainty.max) + " at most. "
                : std::string(". ")) +
           (r.undecided ? html_number(double(r.undecided)) + " rays on which the two disagree are left out. "
                        : std::string("On how each ray ends they agree throughout. ")) +
           (study.options.repeats == 1
                ? std::string("Times are medians of interleaved runs, of long ones that of a single run, on ")
                : "Times are medians of at least " + std::to_string(study.options.repeats) + " interleaved runs on ") +
           (study.options.quick ? std::string("a quarter of the rays (blocks of 64 neighbours), on ") : std::string()) +
           std::to_string(study.options.threads) + (study.options.threads == 1 ? " thread" : " threads") +
           ".</p></section>\n";
}

}  // namespace

std::string error_page(const Plan& plan, const ErrorStudy& study) {
    const std::string name = std::filesystem::path(plan.description().path).stem().string();
    std::string body;
    if (study.interrupted)
        body += "<p class=\"bad\">Interrupted: some points are missing or were timed less often.</p>\n";
    if (plan.scene->straight)
        body +=
            "<p>Every ray of this scene is a straight line: no integrator runs, and there is no error but "
            "rounding.</p>\n";
    else if (!has_ends(study))
        body +=
            "<p>Every ray of this scene is captured or fails: there are no ends whose error could be measured.</p>\n";
    body += facts(plan, study) + cheapest_section(study);
    body +=
        html_figure(
            "Error against run time", work_precision_chart(plan, study, Work::nanoseconds),
            "Each mark is one step size, or one tolerance of an adaptive method, finer and finer along a line. Lower "
            "is more exact, further left is quicker: the "
            "best method for an error is the "
            "leftmost line at its height. Dashed: single precision. Dotted: implicit equations solved to a hundredth "
            "of the "
            "step's own error instead of as the scene asks. Thick: the scene's own method and the recipe as printed.") +
        legend(study);
    body += html_figure(
        "Error against work", work_precision_chart(plan, study, Work::gradients),
        "The same errors over evaluations of the gradient of H, which do not depend on the machine. Where a method is "
        "further left here than above, it spends its "
        "time on something else: intersection, solving equations.");
    body += order_section(study);
    body += families_section(plan, study);
    if (!study.energy.empty())
        body += html_figure(
            "H along one ray", energy_chart(plan, study),
            "The most bent of the well-conditioned rays; each method at that of its points whose gradient "
            "evaluations per ray (in the legend) are nearest to those of the scene's own. The exact ray keeps H. "
            "Relative to half the square of the momentum at the start plus |H₀|. A small error of H alone does not "
            "make a path right.");
    body += html_figure("Strategies and instruction sets", strategy_chart(study),
                        "Run time per ray of the scene's own method at its own step, by every instruction set that "
                        "this machine runs and "
                        "kagero was built for; the whisker spans the quickest and the slowest run. Scalar: one ray at "
                        "a time, the same code on "
                        "plain numbers. Per-ray: one ray, what it computes side by side in the lanes. Packet: one ray "
                        "in every lane. Factors are "
                        "over the first of the scalar ones in double precision.");
    body += map_section(study) + pictures_section(study) + reference_section(study) + data_section(study);
    return html_page("Error against run time: " + name,
                     plan.description().path + " · " + plan.scene->space.info().what, body);
}

}  // namespace kagero
