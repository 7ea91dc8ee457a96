#include "study/error_study.h"

#include "render/trace.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

namespace kagero {
namespace {

/// Number of rays whose energy errors are recorded step by step.
constexpr std::size_t drift_rays = 8;
/// A quick study measures errors on all rays and threads. It times one block of adjacent rays out of `blocks_per_one`.
constexpr std::size_t rays_in_a_block = 64, blocks_per_one = 4;
/// Total time of the repeated runs of each point, seconds. There are at least StudyOptions::repeats runs, and at most
/// four times as many.
constexpr double seconds_per_point = 0.15;
/// Total time of the runs of each point in a quick study, seconds.
constexpr double seconds_per_quick_point = 0.25;
/// Greatest width of the pictures that are compared, pixels.
constexpr std::uint32_t picture_width = 128;

/// Returns the limit of steps for runs without surfaces: the number that 99 % of the rays need with surfaces. Without
/// this limit, rays on closed orbits would run to the scene's limit.
std::uint32_t step_limit_of(const std::vector<RayEnd>& ends) {
    std::vector<double> steps;
    for (const RayEnd& end : ends) steps.push_back(end.steps);
    return static_cast<std::uint32_t>(percentiles_of(std::move(steps)).p99) + 1;
}

/// Returns the plan without surfaces and with at most `max_steps` steps per ray. A plan that has no surfaces is
/// returned unchanged.
Plan without_surfaces(Plan plan, std::uint32_t max_steps) {
    if (!plan.scene->geometry->kernel_view()) return plan;
    plan.run.surfaces = false;
    plan.run.max_steps = std::min(plan.run.max_steps, max_steps);
    return plan;
}

/// A point of the study and the data for timing it repeatedly.
struct TimedPoint {
    Variant variant;
    std::size_t curve, point;               ///< Index of the curve, and of the point on it.
    double estimate = 0;                    ///< Estimated time of one run with and one without surfaces, seconds.
    unsigned repeats = 0;                   ///< Number of runs to time.
    std::uint32_t max_steps = 0;            ///< Limit of steps without surfaces.
    std::vector<double> with{}, without{};  ///< Nanoseconds per ray, with and without surfaces.
};

/// Runs one error study.
class Study {
public:
    Study(const Plan& plan, const StudyOptions& options, const Progress& progress, const std::atomic<bool>* stop)
        : progress_(progress), stop_(stop), builder_(plan, options, stop) {
        study_.options = options;
    }

    ErrorStudy run();

private:
    const Plan& plan() const { return builder_.plan(); }
    bool stopped() const { return builder_.stopped(); }
    double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count(); }
    /// Returns the estimated share of the study's time that `measure_ladders` takes, for the progress report.
    double share_of_ladders() const { return study_.options.quick ? 0.6 : 0.3; }
    void report(double done) const {
        if (progress_) progress_(done, seconds());
    }
    Plan plan_for_timing(const Variant& variant) const;
    void choose_drift_rays();
    void choose_timed_rays();
    void measure_ladders();
    bool estimate_time(const Variant& variant, std::size_t curve, StudyPoint& point, const RunReport& run,
                       const std::vector<RayEnd>& ends);
    void choose_shown_curves();
    void repeat_timing();
    void store_times();
    void choose_cheapest();
    Cheapest cheapest(double error, const char* measure, Percentiles RayErrors::*quantity) const;
    void trace_energy();
    void compare_pictures();
    double gradients_of(const TimedPoint& timed) const {
        return study_.curves[timed.curve].points[timed.point].gradients;
    }
    const TimedPoint* nearest_in_work(const std::string& method, double gradients) const;
    std::vector<const TimedPoint*> points_of_equal_work() const;

    const Progress& progress_;
    const std::atomic<bool>* stop_;
    const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
    CurveBuilder builder_;
    ErrorStudy study_;
    std::vector<RayStart> drift_rays_, timed_rays_;
    std::size_t energy_ray_ = 0;  ///< Index of the ray along which the energy trace is recorded.
    std::vector<TimedPoint> timed_;
};

ErrorStudy Study::run() {
    builder_.prepare();
    choose_drift_rays();
    choose_timed_rays();
    measure_ladders();
    static_cast<ErrorCurves&>(study_) = builder_.finish();
    choose_shown_curves();
    repeat_timing();
    choose_cheapest();
    study_.strategies = strategy_times(plan(), study_.sample.starts, study_.options.threads, stop_);
    trace_energy();
    compare_pictures();
    study_.interrupted = stopped();
    study_.seconds = seconds();
    return std::move(study_);
}

/// Returns the plan of a variant with the number of threads that the options state for timed runs.
Plan Study::plan_for_timing(const Variant& variant) const {
    Plan timed = plan_with_variant(plan(), variant);
    timed.run.threads = study_.options.threads;
    return timed;
}

/// Chooses up to `drift_rays` well-conditioned rays from all parts of the picture. The energy error of an
/// ill-conditioned ray would depend more on the ray than on the method. The energy trace is recorded along the
/// well-conditioned ray with the greatest conditioning.
void Study::choose_drift_rays() {
    const ReferenceRays& rays = builder_.reference_rays();
    constexpr double max_conditioning = 100;
    std::vector<std::size_t> candidates;
    for (std::size_t i = 0; i < rays.ends.size(); ++i) {
        const Status status = rays.ends[i].status;
        if (!rays.confirmed[i] || (status != Status::hit && status != Status::escaped)) continue;
        if (!(rays.conditioning[i] < max_conditioning)) continue;
        if (candidates.empty() || rays.conditioning[i] > rays.conditioning[energy_ray_]) energy_ray_ = i;
        candidates.push_back(i);
    }
    const std::size_t target = std::min(drift_rays, candidates.size());
    for (std::size_t k = 0; k < target; ++k)
        drift_rays_.push_back(
            builder_.curves().sample.starts[candidates[(2 * k + 1) * candidates.size() / (2 * target)]]);
}

/// Chooses the rays that are timed: all, or one block out of several in a quick study.
void Study::choose_timed_rays() {
    const std::vector<RayStart>& all = builder_.curves().sample.starts;
    for (std::size_t i = 0; i < all.size(); ++i)
        if (!study_.options.quick || i / rays_in_a_block % blocks_per_one == 0) timed_rays_.push_back(all[i]);
}

void Study::measure_ladders() {
    const auto estimate = [&](const Variant& variant, std::size_t curve, StudyPoint& point, const RunReport& run,
                              const std::vector<RayEnd>& ends) {
        return estimate_time(variant, curve, point, run, ends);
    };
    builder_.measure_ladders([&](double done) { report(share_of_ladders() * done); }, estimate);
}

/// Estimates the time of a point and measures its energy errors. `run` is the report of the run that measured the
/// errors of its ray ends. In a quick study, the timed rays are traced once more, and this run counts as the first
/// timed run. Returns false if a run was interrupted.
bool Study::estimate_time(const Variant& variant, std::size_t curve, StudyPoint& point, const RunReport& run,
                          const std::vector<RayEnd>& ends) {
    TimedPoint timed{variant, curve, builder_.curves().curves[curve].points.size(), 0, 0, step_limit_of(ends)};
    const bool quick = study_.options.quick;
    double seconds = run.seconds;
    std::vector<RayEnd> unused;
    if (quick) {
        const RunReport timed_run = trace(plan_for_timing(variant), timed_rays_, unused, builder_.control());
        if (timed_run.interrupted) return false;
        seconds = timed_run.seconds;
    }
    const Plan plan_without =
        without_surfaces(quick ? plan_for_timing(variant) : plan_with_variant(plan(), variant), timed.max_steps);
    const RunReport without = trace(plan_without, timed_rays_, unused, builder_.control());
    if (without.interrupted) return false;
    const double timed_rays = double(timed_rays_.size());
    point.steps_without_surfaces = double(without.counters.steps) / timed_rays;
    timed.estimate = (seconds + without.seconds) * plan_without.run.threads / study_.options.threads;
    if (quick) {
        timed.with = {1e9 * seconds / timed_rays};
        timed.without = {1e9 * without.seconds / timed_rays};
    }
    point.drift = energy_drift(plan(), variant, drift_rays_);
    timed_.push_back(std::move(timed));
    return true;
}

/// Chooses strategy and precision of the curves that the order table and the charts show: the first that were measured
/// of packets in double, packets in float, scalar double and scalar float.
void Study::choose_shown_curves() {
    const auto studied = [&](Strategy strategy, Precision precision) {
        return std::any_of(study_.curves.begin(), study_.curves.end(), [&](const StudyCurve& curve) {
            return curve.strategy == strategy && curve.precision == precision;
        });
    };
    for (const Strategy strategy : {Strategy::packet, Strategy::scalar})
        for (const Precision precision : {Precision::float64, Precision::float32})
            if (studied(strategy, precision)) {
                study_.strategy = strategy;
                study_.precision = precision;
                return;
            }
}

/// Repeats the timed runs. They are interleaved, so that a temporary disturbance of the machine affects every method.
void Study::repeat_timing() {
    double total = 0, done = 0;
    unsigned max_repeats = 0;
    for (TimedPoint& timed : timed_) {
        // Short runs are repeated more often, because a disturbance changes their times more.
        const double target = std::min(4.0, std::ceil(seconds_per_point / (timed.estimate * study_.options.repeats)));
        timed.repeats = study_.options.repeats * static_cast<unsigned>(std::max(1.0, target));
        if (study_.options.quick)
            timed.repeats =
                static_cast<unsigned>(std::clamp(seconds_per_quick_point / timed.estimate, 1.0, double(timed.repeats)));
        total += timed.estimate * timed.repeats;
        done += timed.estimate * double(timed.with.size());
        max_repeats = std::max(max_repeats, timed.repeats);
    }
    if (study_.options.quick) study_.options.repeats = 1;
    const double rays = double(timed_rays_.size());
    for (unsigned repeat = 0; repeat < max_repeats; ++repeat)
        for (TimedPoint& timed : timed_) {
            if (stopped()) return store_times();
            if (repeat >= timed.repeats || repeat < timed.with.size()) continue;
            std::vector<RayEnd> ends;
            const RunReport with = trace(plan_for_timing(timed.variant), timed_rays_, ends, builder_.control());
            const RunReport without = trace(without_surfaces(plan_for_timing(timed.variant), timed.max_steps),
                                            timed_rays_, ends, builder_.control());
            if (with.interrupted || without.interrupted) return store_times();
            timed.with.push_back(1e9 * with.seconds / rays);
            timed.without.push_back(1e9 * without.seconds / rays);
            done += timed.estimate;
            report(share_of_ladders() + (0.95 - share_of_ladders()) * done / total);
        }
    store_times();
}

/// Stores the statistics of the times in the points.
void Study::store_times() {
    for (const TimedPoint& timed : timed_) {
        StudyPoint& point = study_.curves[timed.curve].points[timed.point];
        point.time = timing_of(timed.with);
        point.time_without_surfaces = timing_of(timed.without);
    }
}

/// Returns the fastest point whose error is within a bound.
Cheapest Study::cheapest(double error, const char* measure, Percentiles RayErrors::*quantity) const {
    Cheapest best{error, measure, 0, 0, false};
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t c = 0; c < study_.curves.size(); ++c)
        for (std::size_t p = 0; p < study_.curves[c].points.size(); ++p) {
            const StudyPoint& point = study_.curves[c].points[p];
            if (!is_within(point, error, quantity, study_.reference) || !(point.time.median < least)) continue;
            least = point.time.median;
            best.curve = c;
            best.point = p;
            best.found = true;
        }
    return best;
}

void Study::choose_cheapest() {
    study_.cheapest = {cheapest(0.25, "pixels", &RayErrors::pixels), cheapest(1e-3, "pixels", &RayErrors::pixels),
                       cheapest(1e-6, "direction", &RayErrors::direction)};
}

/// Returns the point of a method whose number of gradient evaluations per ray is nearest to `gradients`. Considers only
/// the shown curves with the solver tolerance of the scene. Returns null if there is none.
const TimedPoint* Study::nearest_in_work(const std::string& method, double gradients) const {
    const TimedPoint* nearest = nullptr;
    double least = std::numeric_limits<double>::infinity();
    for (const TimedPoint& timed : timed_) {
        const StudyCurve& curve = study_.curves[timed.curve];
        if (curve.method != method || curve.has_loose_solver || !study_.shows(curve)) continue;
        const double distance = std::abs(std::log(std::max(1.0, gradients_of(timed)) / gradients));
        if (distance < least) {
            least = distance;
            nearest = &timed;
        }
    }
    return nearest;
}

/// Returns points of approximately equal work: the scene's method near the scene's step, and representative methods of
/// low order. The list is empty if the scene's method was not measured.
std::vector<const TimedPoint*> Study::points_of_equal_work() const {
    const std::string scene_method = plan().method().name;
    const TimedPoint* scene_point = nullptr;
    double least = std::numeric_limits<double>::infinity();
    for (const TimedPoint& timed : timed_) {
        const StudyCurve& curve = study_.curves[timed.curve];
        if (!curve.is_scene_method || curve.has_loose_solver || !study_.shows(curve)) continue;
        const double target = curve.info->adaptive ? plan().run.tolerance : plan().run.step;
        const double distance = std::abs(std::log(timed.variant.step / target));
        if (distance < least) {
            least = distance;
            scene_point = &timed;
        }
    }
    if (!scene_point) return {};
    std::vector<const TimedPoint*> all{scene_point};
    const double work = gradients_of(*scene_point);
    constexpr std::uint32_t highest_order = 4;
    for (std::uint32_t i = 0; i < plan().module().integrator_count; ++i) {
        const IntegratorInfo& info = plan().module().integrators[i];
        if (!info.representative || info.adaptive || info.order > highest_order || info.name == scene_method) continue;
        if (const TimedPoint* point = nearest_in_work(info.name, work)) all.push_back(point);
    }
    return all;
}

/// Records the energy errors of the points of equal work along one ray.
void Study::trace_energy() {
    if (drift_rays_.empty() || plan().scene->straight) return;
    for (const TimedPoint* timed : points_of_equal_work()) {
        if (stopped()) return;
        study_.energy.push_back(energy_trace(plan(), timed->variant, study_.sample.starts[energy_ray_]));
        study_.energy.back().gradients = gradients_of(*timed);
    }
}

void Study::compare_pictures() {
    if (plan().scene->straight || stopped()) return;
    const std::vector<const TimedPoint*> all = points_of_equal_work();
    std::vector<Variant> variants;
    for (const TimedPoint* timed : all) variants.push_back(timed->variant);
    study_.pictures = picture_errors(plan(), picture_width, study_.reference.variant, variants, stop_);
    for (std::size_t i = 0; i < study_.pictures.size(); ++i) study_.pictures[i].gradients = gradients_of(*all[i]);
    if (!stopped()) study_.map = error_map(plan(), picture_width, study_.reference.variant, stop_);
    report(1);
}

}  // namespace

ErrorStudy study_error(const Plan& plan, const StudyOptions& options, const Progress& progress,
                       const std::atomic<bool>* stop) {
    return Study(plan, options, progress, stop).run();
}

}  // namespace kagero
