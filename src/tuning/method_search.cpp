#include "tuning/method_search.h"

#include "error.h"
#include "pixels/shade.h"
#include "render/operation_count.h"
#include "render/trace.h"
#include "tuning/precision.h"
#include "tuning/scattered_sample.h"
#include "tuning/shadow_edge.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace kagero {
namespace {

/// Number of rays along each edge of the trial's grid.
constexpr std::uint32_t search_grid = 16;
/// Greatest 99th percentile of the trial's errors, as a share of the bound. The percentile of 256 rays differs from
/// that of all rays of a picture by less than a factor of two.
constexpr double safe_share = 0.5;
/// Greatest error of a single trial ray, as a multiple of the greatest 99th percentile.
constexpr double outlier_ratio = 10;
/// Greatest share of trial rays that may end differently from the reference, or have no confirmed reference.
constexpr double max_wrong_share = 0.01;
/// Greatest number of operations of the search: a share of those of the picture, and a number of operations that takes
/// some hundredths of a second, so that small pictures can be searched too.
constexpr double max_picture_share = 1.0 / 3, min_search_operations = 3e8;
/// Cost of an operation in float, in operations in double. A register has twice as many lanes in float.
constexpr double float_cost = 0.5;
/// Limit of steps of the trial, as a multiple of the median over the rays that end, and its smallest value.
constexpr double step_limit_over_median = 30;
constexpr std::uint32_t least_step_limit = 1000;

/// Methods among which a search chooses: the most efficient ones of bench/defaults, in the order in which they are
/// tried. The plan's default method is tried first.
constexpr const char* candidates[] = {"orbit-srkn6", "orbit-srkn11", "mino-srkn6", "mino-srkn11", "dp85",
                                      "dp54",        "srkn6",        "dp5",        "rk4",         "gauss4"};

/// Two methods whose agreement confirms the reference.
struct ReferencePair {
    const char* method;
    double step;  ///< Multiple of the reference tolerance, or of the default step.
    const char* confirming_method;
    double confirming_step;
};
// The first pair is for spinning holes: the separated motion is much more accurate than H in coordinates for rays that
// turn close to the horizon. The error estimates of both adaptive methods see every stage of a step, so that neither
// passes over a jump of a derivative. The last pair is for spaces whose discontinuity only collocation methods support.
constexpr ReferencePair reference_pairs[] = {{"mino-srkn14", 0.25, "dp85", 0.1},
                                             {"dp85", 0.1, "dp54", 1},
                                             {"gauss12", 0.5, "gauss8", 0.35}};

/// Returns the tolerance of the reference: a thousandth of the bound, as an angle in radians.
double reference_tolerance(double bound, double pixel_angle) {
    constexpr double share = 1e-3, least = 1e-11, greatest = 1e-7;
    return std::clamp(share * bound * pixel_angle, least, greatest);
}

}  // namespace

/// Traces rays and counts the operations. Throws Interrupted if the caller cancels the trial.
std::vector<RayEnd> MethodSearch::trace_rays(const Plan& plan, const std::vector<RayStart>& starts,
                                             double* operations) {
    std::vector<RayEnd> ends;
    const RunReport report = trace(plan, starts, ends, {.stop = control_.stop});
    if (report.interrupted) throw Interrupted();
    const double counted = operations_of(plan, report.counters);
    spent_ += counted;
    if (operations) *operations = counted / double(starts.size());
    return ends;
}

/// Returns the number of rays of the picture.
double MethodSearch::picture_rays() const {
    const FilmDescription& film = plan_.description().film;
    return double(film.width) * film.height * film.spp;
}

/// Returns the operations per ray, weighted by the precision in which a picture would use the method.
double MethodSearch::cost(const MeasuredMethod& measured) const {
    const bool is_too_fine =
        info_of(plan_, measured.variant).adaptive && measured.variant.step < min_float_tolerance;
    return measured.operations * (may_use_float_ && !is_too_fine ? float_cost : 1);
}

/// Returns true if the picture may use float, as far as this is known without a trial.
bool MethodSearch::has_float() const {
    if (plan_.run.kernel_request.precision == Precision::float64) return false;
    for (const std::string& layer : plan_.description().film.layers)
        if (needs_of(layer) & (need_any_error | need_footprint)) return false;
    return plan_.run.kernel->strategy == Strategy::packet;
}

/// Compares the reference with the ends by another method. Returns true if both agree.
bool MethodSearch::confirm_reference(const std::vector<RayEnd>& confirming, const char* method,
                                     const char* confirming_method) {
    const std::size_t unconfirmed = confirm(reference_, confirming);
    if (double(unconfirmed) > max_wrong_share * double(rays)) {
        failure_reason = "no two methods agree on the ends of " + std::to_string(unconfirmed) + " of " +
                         std::to_string(rays) + " rays; at most 1 % may differ";
        return false;
    }
    uncertainty = compare_rays(plan_, reference_, confirming).pixels.p99;
    if (uncertainty > safe_share * bound_) {
        failure_reason = "the 99th percentile of the distances between the ends of " + std::string(method) + " and " +
                         confirming_method + " is " + plain_number(uncertainty) + " pixels";
        return false;
    }
    is_confirmed = true;
    if (!std::isfinite(uncertainty)) uncertainty = 0;  // all rays are captured
    failure_reason.clear();
    return true;
}

/// Traces the reference ends with the first pair of methods that the space supports. If they do not agree, the
/// confirming method is tried again with a finer tolerance, because it is of lower order and usually less accurate.
/// Then both are. Returns false if no two methods agree, or if the budget does not suffice.
bool MethodSearch::trace_reference() {
    for (const ReferencePair& pair : reference_pairs) {
        const auto computing = find_variant(plan_, pair.method, Strategy::packet, Precision::float64, pair.step),
                   confirming = find_variant(plan_, pair.confirming_method, Strategy::packet, Precision::float64,
                                             pair.confirming_step);
        if (!computing || !confirming) continue;
        if (info_of(plan_, *computing).angular && !plan_.run.use_symmetry) continue;
        if (trace_reference_with(*computing, *confirming, 1)) return true;
        constexpr double finer = 1e-2;
        return is_affordable && info_of(plan_, *confirming).adaptive &&
               (confirm_with_finer(*confirming, finer) ||
                (info_of(plan_, *computing).adaptive && trace_reference_with(*computing, *confirming, finer)));
    }
    failure_reason = "this space does not support two methods that could confirm each other";
    return false;
}

/// Traces the reference ends with the first method, and confirms them with the second one. `refinement` multiplies the
/// tolerances. The default method of a compiled space, by which the rays have been traced already, may confirm them
/// too.
bool MethodSearch::trace_reference_with(Variant first, Variant second, double refinement) {
    for (Variant* variant : {&first, &second})
        variant->step *= info_of(plan_, *variant).adaptive
                             ? refinement * reference_tolerance(bound_, sample_.pixel_angle)
                             : default_step(plan_, *variant);
    Plan plan = plan_with_variant(plan_, first), confirming_plan = plan_with_variant(plan_, second);
    plan.run.value_weight = confirming_plan.run.value_weight = reference_value_weight;
    double operations = 0;
    const std::vector<RayEnd> ends = trace_rays(plan, sample_.starts, &operations);
    if (const double needed = spent_ + 3 * operations * double(rays); needed > budget_) {
        is_affordable = refinement < 1;
        if (is_affordable) return false;  // the coarser reference remains
        std::ostringstream reason;
        reason.precision(2);
        reason << "the trial needs at least " << needed << " operations, and the picture permits " << budget_;
        failure_reason = reason.str();
        return false;
    }
    reference_.ends = ends;
    reference_operations_ = operations;
    reference = first;
    reference_.conditioning = conditioning_of(plan_, sample_, reference_.ends, trace_rays(plan, sample_.right),
                                              trace_rays(plan, sample_.below));
    trace_shadow_edge(plan);
    const char *const method = info_of(plan_, first).name, *const confirming_method = info_of(plan_, second).name;
    const bool is_independent = !plan_.description().space.formula && method != std::string(plan_.method().name) &&
                                !(plan_.method().separated && info_of(plan_, first).separated);
    return (is_independent && confirm_reference(default_ends_, method, plan_.method().name)) ||
           confirm_reference(trace_rays(confirming_plan, sample_.starts, &confirming_operations_), method,
                             confirming_method);
}

/// Confirms the reference ends with an adaptive method whose tolerance is finer by the factor `refinement`. Returns
/// false if they do not agree, or if the budget does not suffice.
bool MethodSearch::confirm_with_finer(Variant confirming, double refinement) {
    const IntegratorInfo& info = info_of(plan_, confirming);
    const double more = std::pow(refinement, -1.0 / info.order);  // steps, relative to the coarser tolerance
    // Without a confirmation, the picture is rendered by the reference's method, unless the scene states another one.
    if (!plan_.description().integrator.method_location)
        budget_ = std::max(budget_, max_picture_share * picture_rays() * reference_operations_);
    if (spent_ + more * confirming_operations_ * double(rays) > budget_) return false;
    confirming.step *= refinement * reference_tolerance(bound_, sample_.pixel_angle);
    Plan plan = plan_with_variant(plan_, confirming);
    plan.run.value_weight = reference_value_weight;
    return confirm_reference(trace_rays(plan, sample_.starts), info_of(plan_, *reference).name, info.name);
}

/// Finds rays at the edge of a shadow and traces their reference ends.
void MethodSearch::trace_shadow_edge(const Plan& reference_plan) {
    const auto trace_with_default = [&](const std::vector<RayStart>& starts) { return trace_rays(plan_, starts); };
    edge_sample_ = sample_rays(plan_, points_at_shadow_edge(plan_, sample_, default_ends_, trace_with_default));
    edge_reference_.ends = trace_rays(reference_plan, edge_sample_.starts);
    edge_reference_.conditioning =
        conditioning_of(plan_, edge_sample_, edge_reference_.ends, trace_rays(reference_plan, edge_sample_.right),
                        trace_rays(reference_plan, edge_sample_.below));
    edge_reference_.confirmed.clear();
    for (const RayEnd& end : edge_reference_.ends) edge_reference_.confirmed.push_back(has_visible_end(end));
}

/// Traces the trial's rays with a variant. Returns nothing if the budget does not suffice.
std::optional<MeasuredMethod> MethodSearch::measure(Variant variant) {
    if (spent_ > budget_) return {};
    MeasuredMethod measured;
    measured.variant = variant;
    const Plan plan = plan_with_variant(plan_, variant);
    const std::vector<RayEnd> ends = trace_rays(plan, sample_.starts, &measured.operations);
    measured.errors = compare_rays(plan_, reference_, ends);
    const RayErrors& errors = measured.errors;
    const double greatest_p99 = safe_share * bound_, greatest = outlier_ratio * greatest_p99;
    const bool is_comparable = errors.compared + errors.compared_ill_conditioned > 0;
    measured.is_within = double(errors.flips) <= max_wrong_share * double(rays) &&
                         (!is_comparable || (errors.pixels.p99 <= greatest_p99 && errors.pixels.max <= greatest));
    if (measured.is_within && !edge_sample_.starts.empty())
        measured.is_within =
            !(compare_rays(plan_, edge_reference_, trace_rays(plan, edge_sample_.starts)).pixels.max > greatest);
    if (control_.progress) control_.progress(std::min(1.0, spent_ / budget_), seconds());
    return measured;
}

/// Measures one method with several steps, and keeps the cheapest one that is within the bound as `best`.
void MethodSearch::try_method(const char* name) {
    auto variant = find_variant(plan_, name, Strategy::packet, precision_, 0);
    if (!variant) return;
    const bool adaptive = info_of(plan_, *variant).adaptive;
    const double ratio = adaptive ? 10 : 2, finest = adaptive ? 1e-13 : 0;
    constexpr int max_measurements = 12;
    double step = adaptive ? 1e-4 : default_step(plan_, *variant);
    bool found = false, too_coarse = false;
    const auto try_step = [&](double tried) {
        variant->step = tried;
        const auto measured = measure(*variant);
        if (!measured) return false;
        if (measured->is_within) {
            found = true;
            if (!best || cost(*measured) < cost(*best)) best = measured;
        } else {
            too_coarse = true;
            // A finer step costs more, and would not become the best.
            if (best && cost(*measured) > cost(*best)) return false;
        }
        return true;
    };
    double longest = 0;  // the longest step that is within the bound
    for (int i = 0; i < max_measurements && !(found && too_coarse) && step > finest && step < 1e300; ++i) {
        const bool had_found = found;
        if (!try_step(step)) break;
        if (found && (!had_found || !too_coarse)) longest = step;
        step = found && !too_coarse ? step * ratio : step / ratio;
        if (adaptive && step > 0.1) break;
    }
    if (longest > 0 && too_coarse) try_step(longest * std::sqrt(ratio));
}

void MethodSearch::run() {
    sample_ = sample_rays(plan_, search_grid, search_grid);
    if (has_material(plan_.description(), Material::diffuse))
        add_scattered_rays(plan_, {.stop = control_.stop}, sample_);
    rays = sample_.starts.size();
    may_use_float_ = has_float();
    precision_ = plan_.run.kernel_request.precision.value_or(Precision::float64);
    const bool is_stated = plan_.description().integrator.method_location.has_value();
    double default_operations = 0;
    std::vector<double> steps;
    default_ends_ = trace_rays(plan_, sample_.starts, &default_operations);
    for (const RayEnd& end : default_ends_)
        if (end.status != Status::step_limit) steps.push_back(end.steps);
    if (steps.empty()) {
        failure_reason = "no ray of the trial ends within integrator.max_steps";
        return;
    }
    const double limit = step_limit_over_median * percentiles_of(std::move(steps)).p50;
    plan_.run.max_steps =
        std::min(plan_.run.max_steps, std::max(least_step_limit, std::uint32_t(std::min(1e9, limit))));
    budget_ = std::max(max_picture_share * picture_rays() * default_operations, min_search_operations);
    if (!trace_reference()) return;
    const std::string own = plan_.method().name;
    const bool only_adaptive = plan_.description().space.formula.has_value();
    try_method(own.c_str());
    for (const char* name : candidates) {
        const auto variant = find_variant(plan_, name, Strategy::packet, precision_, 0);
        if (is_stated || own == name || !variant) continue;
        if (only_adaptive && !info_of(plan_, *variant).adaptive) continue;
        const bool uses_orbit_plane = plan_.run.use_symmetry && !has_rays_from_surfaces(plan_.description());
        if (info_of(plan_, *variant).angular && !uses_orbit_plane) continue;
        try_method(name);
    }
    if (!best)
        failure_reason = "no " + (is_stated ? "step of " + own : std::string("method")) +
                         " that was measured meets the bound";
}

}  // namespace kagero
