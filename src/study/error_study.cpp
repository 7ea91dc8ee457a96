#include "study/error_study.h"

#include "render/trace.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

namespace kagero {
namespace {

/// Total time of the repeated runs of each point, seconds. There are at least StudyOptions::repeats runs, and at most
/// four times as many.
constexpr double seconds_per_point = 0.15;
/// Total time of the runs of each point in a quick study, seconds.
constexpr double seconds_per_quick_point = 0.25;
/// Greatest width of the compared pictures, pixels.
constexpr std::uint32_t picture_width = 128;

/// Runs one error study.
class Study {
public:
    Study(const Plan& plan, const StudyOptions& options, const Progress& progress, const std::atomic<bool>* stop)
        : progress_(progress), stop_(stop), points_(plan, options, stop) {
        study_.options = options;
    }

    ErrorStudy run();

private:
    const Plan& plan() const { return points_.builder().plan(); }
    bool stopped() const { return points_.builder().stopped(); }
    RunControl control() const { return points_.builder().control(); }
    double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count(); }
    /// Returns the estimated share of the study's time that `measure_ladders` takes, for the progress report.
    double share_of_ladders() const { return study_.options.quick ? 0.6 : 0.3; }
    void report_progress(double done) const {
        if (progress_) progress_(done, seconds());
    }
    void measure_points();
    void choose_main_curves();
    void repeat_timing();
    void store_times();
    void choose_cheapest();
    CheapestPoint cheapest_within(double bound, const char* quantity, Percentiles RayErrors::*errors) const;
    void trace_energy();
    void compare_pictures();
    /// Returns the gradient evaluations per ray of a point.
    double gradients_of(const TimedPoint& timed) const {
        return study_.curves[timed.curve].points[timed.point].gradients;
    }
    const TimedPoint* nearest_in_work(const std::string& method, double gradients) const;
    std::vector<const TimedPoint*> points_of_equal_work() const;

    const Progress& progress_;
    const std::atomic<bool>* stop_;
    const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
    PointMeasurements points_;
    ErrorStudy study_;
};

ErrorStudy Study::run() {
    points_.prepare();
    measure_points();
    static_cast<ErrorCurves&>(study_) = points_.builder().finish();
    choose_main_curves();
    repeat_timing();
    choose_cheapest();
    study_.strategies = strategy_times(plan(), study_.sample.starts, study_.options.threads, stop_);
    trace_energy();
    compare_pictures();
    study_.interrupted = stopped();
    study_.seconds = seconds();
    return std::move(study_);
}

/// Measures the points of all methods. With a share, those of other methods are measured by other processes first.
void Study::measure_points() {
    const auto progress = [&](double done) { report_progress(share_of_ladders() * done); };
    if (study_.options.share.count > 1) {
        points_.measure(study_.options.share, progress);
        study_.options.await_others();
    }
    points_.measure({}, progress);
}

/// Chooses strategy and precision of the main curves: the first combination with a measured curve, in the order packets
/// in double, packets in float, scalar in double, scalar in float.
void Study::choose_main_curves() {
    const auto has_curve = [&](Strategy strategy, Precision precision) {
        return std::any_of(study_.curves.begin(), study_.curves.end(), [&](const StudyCurve& curve) {
            return curve.strategy == strategy && curve.precision == precision;
        });
    };
    for (const Strategy strategy : {Strategy::packet, Strategy::scalar})
        for (const Precision precision : {Precision::float64, Precision::float32})
            if (has_curve(strategy, precision)) {
                study_.main_strategy = strategy;
                study_.main_precision = precision;
                return;
            }
}

/// Repeats the timed runs. They are interleaved, so that a temporary disturbance of the machine affects every method.
void Study::repeat_timing() {
    double total_seconds = 0, done_seconds = 0;  // Estimates, for the progress report.
    unsigned max_repeats = 0;
    for (TimedPoint& timed : points_.timed()) {
        // Short runs are repeated more often, because a disturbance changes their times more.
        const double factor = std::min(4.0, std::ceil(seconds_per_point / (timed.estimate * study_.options.repeats)));
        timed.repeats = study_.options.repeats * static_cast<unsigned>(std::max(1.0, factor));
        if (study_.options.quick)
            timed.repeats =
                static_cast<unsigned>(std::clamp(seconds_per_quick_point / timed.estimate, 1.0, double(timed.repeats)));
        total_seconds += timed.estimate * timed.repeats;
        done_seconds += timed.estimate * double(timed.with_surfaces.size());
        max_repeats = std::max(max_repeats, timed.repeats);
    }
    if (study_.options.quick) study_.options.repeats = 1;  // The smallest number of runs, which the reports state.
    const double rays = double(points_.timed_rays().size());
    for (unsigned repeat = 0; repeat < max_repeats; ++repeat)
        for (TimedPoint& timed : points_.timed()) {
            if (stopped()) return store_times();
            if (repeat >= timed.repeats || repeat < timed.with_surfaces.size()) continue;
            std::vector<RayEnd> ends;
            const RunReport with = trace(points_.plan_for_timing(timed.variant), points_.timed_rays(), ends, control());
            const RunReport without = trace(without_surfaces(points_.plan_for_timing(timed.variant), timed.max_steps),
                                            points_.timed_rays(), ends, control());
            if (with.interrupted || without.interrupted) return store_times();
            timed.with_surfaces.push_back(1e9 * with.seconds / rays);
            timed.without_surfaces.push_back(1e9 * without.seconds / rays);
            done_seconds += timed.estimate;
            // The last 5 % of the progress are the energy traces and pictures.
            report_progress(share_of_ladders() + (0.95 - share_of_ladders()) * done_seconds / total_seconds);
        }
    store_times();
}

/// Stores the statistics of the times in the points.
void Study::store_times() {
    for (const TimedPoint& timed : points_.timed()) {
        StudyPoint& point = study_.curves[timed.curve].points[timed.point];
        point.time = timing_of(timed.with_surfaces);
        point.time_without_surfaces = timing_of(timed.without_surfaces);
    }
}

/// Returns the fastest point whose error is within a bound. `quantity` is the name of `errors`.
CheapestPoint Study::cheapest_within(double bound, const char* quantity, Percentiles RayErrors::*errors) const {
    CheapestPoint best{bound, quantity, 0, 0, false};
    double least_time = std::numeric_limits<double>::infinity();
    for (std::size_t c = 0; c < study_.curves.size(); ++c)
        for (std::size_t p = 0; p < study_.curves[c].points.size(); ++p) {
            const StudyPoint& point = study_.curves[c].points[p];
            if (!is_within(point, bound, errors, study_.reference) || !(point.time.median < least_time)) continue;
            least_time = point.time.median;
            best.curve = c;
            best.point = p;
            best.found = true;
        }
    return best;
}

void Study::choose_cheapest() {
    study_.cheapest = {cheapest_within(0.25, "pixels", &RayErrors::pixels),
                       cheapest_within(1e-3, "pixels", &RayErrors::pixels),
                       cheapest_within(1e-6, "direction", &RayErrors::direction)};
}

/// Returns the point of a method whose number of gradient evaluations per ray is nearest to `gradients`. Considers only
/// the main curves with the solver tolerance of the scene. Returns null if the method has no such point.
const TimedPoint* Study::nearest_in_work(const std::string& method, double gradients) const {
    const TimedPoint* nearest = nullptr;
    double least = std::numeric_limits<double>::infinity();
    for (const TimedPoint& timed : points_.timed()) {
        const StudyCurve& curve = study_.curves[timed.curve];
        if (curve.method != method || curve.has_loose_solver || !study_.is_main(curve)) continue;
        const double distance = std::abs(std::log(std::max(1.0, gradients_of(timed)) / gradients));
        if (distance < least) {
            least = distance;
            nearest = &timed;
        }
    }
    return nearest;
}

/// Returns points that need about equally many gradients per ray. The first is the point of the scene's method whose
/// step is nearest to the scene's step. The others are points of representative methods with a fixed step and an order
/// of at most 4. The list is empty if the scene's method was not measured.
std::vector<const TimedPoint*> Study::points_of_equal_work() const {
    const std::string scene_method = plan().method().name;
    const TimedPoint* scene_point = nullptr;
    double least = std::numeric_limits<double>::infinity();
    for (const TimedPoint& timed : points_.timed()) {
        const StudyCurve& curve = study_.curves[timed.curve];
        if (!curve.is_scene_method || curve.has_loose_solver || !study_.is_main(curve)) continue;
        const double target = curve.info->adaptive ? plan().run.tolerance : plan().run.step;
        const double distance = std::abs(std::log(timed.variant.step / target));
        if (distance < least) {
            least = distance;
            scene_point = &timed;
        }
    }
    if (!scene_point) return {};
    std::vector<const TimedPoint*> points{scene_point};
    const double gradients = gradients_of(*scene_point);
    constexpr std::uint32_t highest_order = 4;
    for (std::uint32_t i = 0; i < plan().module().integrator_count; ++i) {
        const IntegratorInfo& info = plan().module().integrators[i];
        if (!info.representative || info.adaptive || info.order > highest_order || info.name == scene_method) continue;
        if (const TimedPoint* point = nearest_in_work(info.name, gradients)) points.push_back(point);
    }
    return points;
}

/// Records the energy errors of the points of equal work along one ray.
void Study::trace_energy() {
    if (points_.drift_rays().empty() || plan().scene->straight) return;
    for (const TimedPoint* timed : points_of_equal_work()) {
        if (stopped()) return;
        study_.energy_traces.push_back(
            energy_trace(plan(), timed->variant, study_.sample.starts[points_.energy_ray()]));
        study_.energy_traces.back().gradients = gradients_of(*timed);
    }
}

/// Measures the picture errors of the points of equal work, and the error map of the scene's method and step.
void Study::compare_pictures() {
    if (plan().scene->straight || stopped()) return;
    const std::vector<const TimedPoint*> points = points_of_equal_work();
    std::vector<Variant> variants;
    for (const TimedPoint* timed : points) variants.push_back(timed->variant);
    study_.pictures = picture_errors(plan(), picture_width, study_.reference.variant, variants, stop_);
    for (std::size_t i = 0; i < study_.pictures.size(); ++i) study_.pictures[i].gradients = gradients_of(*points[i]);
    if (!stopped()) study_.map = error_map(plan(), picture_width, study_.reference.variant, stop_);
    report_progress(1);
}

}  // namespace

ErrorStudy study_error(const Plan& plan, const StudyOptions& options, const Progress& progress,
                       const std::atomic<bool>* stop) {
    return Study(plan, options, progress, stop).run();
}

}  // namespace kagero
