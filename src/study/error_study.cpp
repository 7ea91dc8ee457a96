#include "render/operation_count.h"
#include "study/study.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

/// The share of the rays that may end otherwise than they should, or nobody knows how, where the others are within a bound.
constexpr double most_astray = 0.01;
/// Rays whose energy is followed step by step.
constexpr std::size_t drift_rays = 8;
/// Points that do more work per ray than this many times the cheapest are not worth their wait.
constexpr double absurd_work = 200, absurd_work_quick = 60;
/// Gradients and steps of all rays beyond which a quick study takes no finer step: counted, as a clock would not choose the same
/// points twice.
constexpr double most_work_quick = 2e7;
/// The same before a method has shown as many steps as others, but enough for its order.
constexpr double hopeless_work_quick = 4e8;
constexpr std::size_t steps_for_order = 3;
/// A finer step gains nothing where the error, below this share of the scene, falls to no less than so much of what it was.
constexpr double resolved = 1e-5, hardly_less = 0.7;
/// Work rises where a point does so many times that of the one before; the next will, of a tenth of the tolerance or half the step.
constexpr double rises_by = 1.2, next_tolerance = 1.5, next_halving = 2;
/// A quick study measures errors on all rays and threads, but times one block of neighbours in so many.
constexpr std::size_t rays_in_a_block = 64, blocks_per_one = 4;
/// A ray that takes so many times as many steps as the middle one of those that end does not end; but never fewer steps than
/// this.
constexpr double far_beyond = 30;
constexpr std::uint32_t least_steps = 1000;

/// As many steps as 99 % of the rays take: what a ray may go on for where nothing stops it. In a space where light runs in circles it would
/// else go round for as long as the scene allows.
std::uint32_t enough_steps(const std::vector<RayEnd>& ends) {
    std::vector<double> steps;
    for (const RayEnd& end : ends) steps.push_back(end.steps);
    return static_cast<std::uint32_t>(spread_of(std::move(steps)).p99) + 1;
}

}  // namespace

ErrorStudy Study::run() {
    study_.sample = sample_rays(plan_, study_.options.width, study_.options.height);
    bound_steps();
    reference_ = trace_reference(plan_, study_.sample, study_.reference, study_.options.deadline, stop_);
    keep_decided();
    for (std::size_t i = 0; i < reference_.ends.size(); ++i)
        study_.ill_conditioned += reference_.decided[i] && reference_.conditioning[i] > ill_conditioned;
    choose_drift_rays();
    choose_timed_rays();
    if (!study_.options.pixel_bound || is_known(study_.reference)) climb_all();
    choose_shown();
    if (!study_.options.pixel_bound) {
        take_times();
        choose_cheapest();
        study_.strategies = strategy_times(plan_, study_.sample.starts, study_.options.threads, stop_);
        follow_energy();
        compare_pictures();
    }
    study_.interrupted = stopped();
    study_.seconds = seconds();
    return std::move(study_);
}

/// Where light can circle for ever, rays would run to the scene's limit of steps at every point of the study. They end far beyond
/// what the middle one of those needs that end by themselves.
void Study::bound_steps() {
    std::vector<RayEnd> ends;
    trace(plan_, study_.sample.starts, ends, watch());
    std::vector<double> steps;
    for (const RayEnd& end : ends)
        if (end.status != Status::step_limit) steps.push_back(end.steps);
    const auto enough = static_cast<std::uint32_t>(std::min(1e9, far_beyond * spread_of(std::move(steps)).p50));
    plan_.job.max_steps = std::min(plan_.job.max_steps, std::max(least_steps, enough));
}

/// Rays without a reference have no error; they would only take time.
void Study::keep_decided() {
    std::size_t kept = 0;
    SampleRays& sample = study_.sample;
    for (std::size_t i = 0; i < reference_.ends.size(); ++i) {
        if (!reference_.decided[i]) continue;
        sample.starts[kept] = sample.starts[i], sample.pixels[kept] = sample.pixels[i];
        reference_.ends[kept] = reference_.ends[i], reference_.conditioning[kept] = reference_.conditioning[i];
        ++kept;
    }
    if (kept == 0) throw RunError("no ray of this scene ends in a way that two methods agree on: there is no error to measure");
    sample.starts.resize(kept), sample.pixels.resize(kept);
    reference_.ends.resize(kept), reference_.conditioning.resize(kept);
    reference_.decided.assign(kept, true);
}

/// Spread over the picture, and well-conditioned: their energy says something of the method, not of the ray.
void Study::choose_drift_rays() {
    constexpr double calm = 100;
    std::vector<std::size_t> good;
    for (std::size_t i = 0; i < reference_.ends.size(); ++i) {
        const Status status = reference_.ends[i].status;
        if (!reference_.decided[i] || (status != Status::hit && status != Status::escaped)) continue;
        if (!(reference_.conditioning[i] < calm)) continue;
        if (good.empty() || reference_.conditioning[i] > reference_.conditioning[most_bent_]) most_bent_ = i;
        good.push_back(i);
    }
    const std::size_t wanted = std::min(drift_rays, good.size());
    for (std::size_t k = 0; k < wanted; ++k)
        drift_rays_.push_back(study_.sample.starts[good[(2 * k + 1) * good.size() / (2 * wanted)]]);
}

void Study::choose_timed_rays() {
    const std::vector<RayStart>& all = study_.sample.starts;
    for (std::size_t i = 0; i < all.size(); ++i)
        if (!study_.options.quick || i / rays_in_a_block % blocks_per_one == 0) timed_rays_.push_back(all[i]);
}

void Study::climb_all() {
    const StudyOptions& options = study_.options;
    const LadderChoice choice{options.quick, options.full, options.strategy, options.precision, options.pixel_bound > 0};
    const auto ladders = choose_ladders(plan_, choice, study_.refused);
    for (std::size_t i = 0; i < ladders.size() && !stopped(); ++i) {
        if (options.pixel_bound && ladders[i].variant.kernel->strategy != Strategy::packet) continue;
        climb(ladders[i]);
        tell(climbing() * double(i + 1) / double(ladders.size()));
    }
}

/// Finer and finer steps until rounding stops the method, or its cost is absurd.
void Study::climb(const Ladder& ladder) {
    StudyCurve& curve = study_.curves.emplace_back();
    curve.info = &info_of(plan_, ladder.variant), curve.method = curve.info->name;
    curve.strategy = ladder.variant.kernel->strategy, curve.precision = ladder.variant.kernel->precision;
    curve.rescaled = ladder.variant.rescaled, curve.own = ladder.own, curve.loose = ladder.loose;
    const double size = scene_size(plan_);
    std::vector<double> steps, errors;
    Variant variant = ladder.variant;
    double work_before = 0;
    for (std::size_t n = 0; n < ladder.steps.size() && !stopped(); ++n) {
        variant.step = ladder.steps[n];
        if (ladder.loose && !set_loose_tolerance(variant)) break;
        Timed timed{variant, study_.curves.size() - 1, curve.points.size(), 0, 0, 0, {}, {}};
        const auto measured = measure(timed);
        if (!measured) break;
        const StudyPoint& point = *measured;
        curve.points.push_back(point), timed_.push_back(std::move(timed));
        steps.push_back(variant.step), errors.push_back(point.errors.position.p90);
        const double work = std::max(point.gradients, point.steps);
        if (point.errors.compared > 0) least_work_ = std::min(least_work_, work);
        const bool enough = n + 1 >= ladder.least;
        const double error = errors.back(), before = n > 0 ? errors[n - 1] : error;
        if (enough && error < resolved * size && error > hardly_less * before) {
            curve.stopped = "rounding: a finer step gains nothing";
            break;
        }
        const double limit = study_.options.quick ? absurd_work_quick : absurd_work;
        // Long steps of implicit methods may cost more than shorter ones, whose equations are solved sooner.
        const bool rises = n > 0 && work > rises_by * work_before;
        work_before = work;
        const double next = (curve.info->adaptive ? next_tolerance : next_halving) * work;
        if (enough && rises && next > limit * least_work_) {
            curve.stopped =
                "a finer step would do more than " + std::to_string(std::lround(limit)) + " times the work of the cheapest point";
            break;
        }
        const double most_work = enough ? most_work_quick : hopeless_work_quick;
        if (rises && study_.options.quick && n + 1 >= steps_for_order && next * double(study_.sample.starts.size()) > most_work) {
            curve.stopped = "a finer step is too much work for a quick study";
            break;
        }
    }
    const Slope slope = slope_of(steps, errors, curve.info->order, size);
    curve.floor = slope.floor;
    if (!curve.info->adaptive) curve.order = slope.order;
    if (curve.points.empty()) study_.curves.pop_back();
    else if (study_.options.pixel_bound) close_in(curve, variant);
}

/// Bisects between the longest step that is within the bound and the next longer one, which is not.
void Study::close_in(StudyCurve& curve, Variant variant) {
    constexpr int doublings = 3, bisections = 4;
    const auto measured = [&](double step) {
        variant.step = step;
        Timed timed{variant, 0, 0, 0, 0, 0, {}, {}};
        return measure(timed);
    };
    const auto within = [&](const StudyPoint& point) { return is_within(point, study_.options.pixel_bound, &RayErrors::pixels, study_.reference); };
    auto longest = std::find_if(curve.points.begin(), curve.points.end(), within);
    if (longest == curve.points.end()) return;
    if (curve.loose) variant.solver_tolerance = longest->solver_tolerance;
    const auto insert = [&](double step) {
        const auto point = measured(step);
        if (!point) return false;
        longest = curve.points.insert(longest, *point);
        if (!within(*point)) ++longest;
        return true;
    };
    for (int i = 0; i < doublings && longest == curve.points.begin(); ++i)
        if (!insert(2 * longest->step)) return;
    for (int i = 0; i < bisections && longest != curve.points.begin(); ++i)
        if (!insert(std::sqrt(std::prev(longest)->step * longest->step))) return;
}

/// Packets in double precision; where they were not studied, what was.
void Study::choose_shown() {
    const auto studied = [&](Strategy strategy, Precision precision) {
        return std::any_of(study_.curves.begin(), study_.curves.end(),
                           [&](const StudyCurve& curve) { return curve.strategy == strategy && curve.precision == precision; });
    };
    for (const Strategy strategy : {Strategy::packet, Strategy::scalar})
        for (const Precision precision : {Precision::float64, Precision::float32})
            if (studied(strategy, precision)) {
                study_.strategy = strategy, study_.precision = precision;
                return;
            }
}

/// To a hundredth of the error that the same method makes at the same step when its equations are solved exactly. False where
/// that was not measured, rounding is all there is, or this space leaves no equations to solve.
bool Study::set_loose_tolerance(Variant& variant) const {
    for (const StudyCurve& curve : study_.curves) {
        if (curve.info != &info_of(plan_, variant) || curve.loose || curve.precision != Precision::float64) continue;
        for (const StudyPoint& point : curve.points) {
            if (point.step != variant.step || !(point.errors.direction.p50 > 1e-13) || point.iterations == 0) continue;
            variant.solver_tolerance = 0.01 * std::min(1.0, point.errors.direction.p50);
            return true;
        }
    }
    return false;
}

/// Nothing where there was no time.
std::optional<StudyPoint> Study::measure(Timed& timed) {
    if (stopped()) return {};
    const Variant& variant = timed.variant;
    StudyPoint point;
    point.step = variant.step, point.stated_step = stated_step(plan_, variant);
    point.solver_tolerance = variant.solver_tolerance >= 0 ? variant.solver_tolerance : plan_.job.solver_tolerance;
    const double rays = double(study_.sample.starts.size());
    {
        PlanAs as(plan_, variant);
        std::vector<RayEnd> ends;
        const RunReport report = trace(plan_, study_.sample.starts, ends, watch());
        if (report.interrupted) return {};
        point.errors = compare_rays(plan_, reference_, ends);
        const Counters& work = report.counters;
        point.gradients = double(work.gradients) / rays, point.steps = double(work.steps) / rays;
        point.operations = operations_of(plan_, work) / rays;
        point.queries = double(work.queries) / rays, point.iterations = double(work.active_iterations) / rays;
        if (work.issued_lane_steps > 0) point.occupancy = double(work.active_lane_steps) / double(work.issued_lane_steps);
        if (study_.options.pixel_bound) return point;
        timed.most_steps = enough_steps(ends);
        double seconds = report.seconds;
        if (study_.options.quick) {
            as.on_threads(study_.options.threads);
            const RunReport alone = trace(plan_, timed_rays_, ends, watch());
            if (alone.interrupted) return {};
            seconds = alone.seconds;
        }
        as.without_surfaces(timed.most_steps);
        const RunReport without = trace(plan_, timed_rays_, ends, watch());
        if (without.interrupted) return {};
        const double timed_rays = double(timed_rays_.size());
        point.steps_without = double(without.counters.steps) / timed_rays;
        timed.estimate = (seconds + without.seconds) * plan_.threads / study_.options.threads;
        if (study_.options.quick) timed.with = {1e9 * seconds / timed_rays}, timed.without = {1e9 * without.seconds / timed_rays};
    }
    point.drift = energy_drift(plan_, variant, drift_rays_);
    return point;
}

bool is_known(const ReferenceStory& reference) {
    return double(reference.undecided) <= most_astray * double(reference.decided + reference.undecided);
}

std::string what_is_unknown(const ReferenceStory& reference) {
    return "no two methods agree on how " + std::to_string(reference.undecided) + " of " + std::to_string(reference.decided + reference.undecided) + " rays end";
}

bool is_within(const StudyPoint& point, double error, Spread RayErrors::*spread, const ReferenceStory& reference) {
    const RayErrors& e = point.errors;
    if (reference.decided == 0 || !is_known(reference) || double(e.flips) > most_astray * double(reference.decided)) return false;
    if (e.compared + e.ill == 0) return true;  // rays that are all captured end nowhere in particular
    // Of what is closer to the reference than that is to the truth nobody knows how close it is to that.
    const double unknown = spread == &RayErrors::pixels ? reference.pixels.p99 : spread == &RayErrors::position ? reference.uncertainty.p99 : reference.direction.p99;
    return (e.*spread).p99 <= error && unknown <= error;
}

ErrorStudy study_error(Plan& plan, const StudyOptions& options, const Progress& progress, const std::atomic<bool>* stop) {
    struct Restore {
        Plan& plan;
        std::uint32_t max_steps = plan.job.max_steps;
        ~Restore() { plan.job.max_steps = max_steps; }
    } const restore{plan};
    return Study(plan, options, progress, stop).run();
}

}  // namespace kagero
