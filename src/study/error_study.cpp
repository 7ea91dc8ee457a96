#include "study/error_study.h"

#include "render/trace.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

namespace kagero {
namespace {

/// Rays whose energy is followed step by step.
constexpr std::size_t drift_rays = 8;
/// A quick study measures errors on all rays and threads, but times one block of neighbours in so many.
constexpr std::size_t rays_in_a_block = 64, blocks_per_one = 4;
/// Seconds to spend on the repeated runs of each point, if four times the asked repetitions reach so far.
constexpr double seconds_per_point = 0.15;
/// The same of a quick study.
constexpr double seconds_per_quick_point = 0.25;
/// Of the pictures that are compared, in pixels.
constexpr std::uint32_t picture_width = 128;

/// As many steps as 99 % of the rays take: what a ray may go on for where nothing stops it. In a space where light runs
/// in circles it would else go round for as long as the scene allows.
std::uint32_t enough_steps(const std::vector<RayEnd>& ends) {
    std::vector<double> steps;
    for (const RayEnd& end : ends) steps.push_back(end.steps);
    return static_cast<std::uint32_t>(spread_of(std::move(steps)).p99) + 1;
}

/// The plan with rays that meet nothing, and take so many steps at most; a plan without surfaces stays as it is.
Plan without_surfaces(Plan plan, std::uint32_t most_steps) {
    if (!plan.scene->geometry->kernel_view()) return plan;
    plan.run.surfaces = false;
    plan.run.max_steps = std::min(plan.run.max_steps, most_steps);
    return plan;
}

/// One point of the study with what is needed to time it again.
struct Timed {
    Variant variant;
    std::size_t curve, point;
    double estimate = 0;  ///< seconds of one run with and one without surfaces
    unsigned repeats = 0;
    std::uint32_t most_steps = 0;  ///< without surfaces
    std::vector<double> with{}, without{};  ///< ns per ray
};

/// An error study while it is made.
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
    /// The share of the time that passes before any run is repeated.
    double climbing() const { return study_.options.quick ? 0.6 : 0.3; }
    void report(double done) const {
        if (progress_) progress_(done, seconds());
    }
    Plan on_timed_threads(const Variant& variant) const;
    void choose_drift_rays();
    void choose_timed_rays();
    void climb_all();
    bool time(const Variant& variant, std::size_t curve, StudyPoint& point, const RunReport& report,
              const std::vector<RayEnd>& ends);
    void choose_shown();
    void take_times();
    void keep_times();
    void choose_cheapest();
    Cheapest cheapest(double error, const char* measure, Spread RayErrors::*spread) const;
    void follow_energy();
    void compare_pictures();
    double gradients_of(const Timed& timed) const { return study_.curves[timed.curve].points[timed.point].gradients; }
    const Timed* nearest_in_work(const std::string& method, double gradients) const;
    std::vector<const Timed*> rivals() const;

    const Progress& progress_;
    const std::atomic<bool>* stop_;
    const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
    CurveBuilder builder_;
    ErrorStudy study_;
    std::vector<RayStart> drift_rays_, timed_rays_;
    std::size_t most_bent_ = 0;  ///< of the calm rays of the sample: the one whose energy is drawn
    std::vector<Timed> timed_;
};

ErrorStudy Study::run() {
    builder_.prepare();
    choose_drift_rays();
    choose_timed_rays();
    climb_all();
    static_cast<ErrorCurves&>(study_) = builder_.take();
    choose_shown();
    take_times();
    choose_cheapest();
    study_.strategies = strategy_times(plan(), study_.sample.starts, study_.options.threads, stop_);
    follow_energy();
    compare_pictures();
    study_.interrupted = stopped();
    study_.seconds = seconds();
    return std::move(study_);
}

Plan Study::on_timed_threads(const Variant& variant) const {
    Plan timed = plan_by(plan(), variant);
    timed.run.threads = study_.options.threads;
    return timed;
}

/// Spread over the picture, and well-conditioned: their energy says something of the method, not of the ray.
void Study::choose_drift_rays() {
    const ReferenceRays& rays = builder_.reference_rays();
    constexpr double calm = 100;
    std::vector<std::size_t> good;
    for (std::size_t i = 0; i < rays.ends.size(); ++i) {
        const Status status = rays.ends[i].status;
        if (!rays.decided[i] || (status != Status::hit && status != Status::escaped)) continue;
        if (!(rays.conditioning[i] < calm)) continue;
        if (good.empty() || rays.conditioning[i] > rays.conditioning[most_bent_]) most_bent_ = i;
        good.push_back(i);
    }
    const std::size_t wanted = std::min(drift_rays, good.size());
    for (std::size_t k = 0; k < wanted; ++k)
        drift_rays_.push_back(builder_.curves().sample.starts[good[(2 * k + 1) * good.size() / (2 * wanted)]]);
}

void Study::choose_timed_rays() {
    const std::vector<RayStart>& all = builder_.curves().sample.starts;
    for (std::size_t i = 0; i < all.size(); ++i)
        if (!study_.options.quick || i / rays_in_a_block % blocks_per_one == 0) timed_rays_.push_back(all[i]);
}

void Study::climb_all() {
    builder_.climb_all([&](double done) { report(climbing() * done); },
                       [&](const Variant& variant, std::size_t curve, StudyPoint& point, const RunReport& run,
                           const std::vector<RayEnd>& ends) { return time(variant, curve, point, run, ends); });
}

/// A first time of a point, and how well its method keeps H. False where there was no time.
bool Study::time(const Variant& variant, std::size_t curve, StudyPoint& point, const RunReport& run,
                 const std::vector<RayEnd>& ends) {
    Timed timed{variant, curve, builder_.curves().curves[curve].points.size(), 0, 0, enough_steps(ends)};
    const bool quick = study_.options.quick;
    double seconds = run.seconds;
    std::vector<RayEnd> unused;
    if (quick) {
        const RunReport alone = trace(on_timed_threads(variant), timed_rays_, unused, builder_.watch());
        if (alone.interrupted) return false;
        seconds = alone.seconds;
    }
    const Plan bare = without_surfaces(quick ? on_timed_threads(variant) : plan_by(plan(), variant), timed.most_steps);
    const RunReport without = trace(bare, timed_rays_, unused, builder_.watch());
    if (without.interrupted) return false;
    const double timed_rays = double(timed_rays_.size());
    point.steps_without = double(without.counters.steps) / timed_rays;
    timed.estimate = (seconds + without.seconds) * bare.run.threads / study_.options.threads;
    if (quick) timed.with = {1e9 * seconds / timed_rays}, timed.without = {1e9 * without.seconds / timed_rays};
    point.drift = energy_drift(plan(), variant, drift_rays_);
    timed_.push_back(std::move(timed));
    return true;
}

/// Packets in double precision; where they were not studied, what was.
void Study::choose_shown() {
    const auto studied = [&](Strategy strategy, Precision precision) {
        return std::any_of(study_.curves.begin(), study_.curves.end(), [&](const StudyCurve& curve) {
            return curve.strategy == strategy && curve.precision == precision;
        });
    };
    for (const Strategy strategy : {Strategy::packet, Strategy::scalar})
        for (const Precision precision : {Precision::float64, Precision::float32})
            if (studied(strategy, precision)) {
                study_.strategy = strategy, study_.precision = precision;
                return;
            }
}

/// The repetitions are interleaved: what disturbs the machine for a while disturbs every method.
void Study::take_times() {
    double total = 0, done = 0;
    unsigned most = 0;
    for (Timed& timed : timed_) {
        // Short runs are disturbed more easily, and cost little to repeat.
        const double wanted = std::min(4.0, std::ceil(seconds_per_point / (timed.estimate * study_.options.repeats)));
        timed.repeats = study_.options.repeats * static_cast<unsigned>(std::max(1.0, wanted));
        if (study_.options.quick)
            timed.repeats =
                static_cast<unsigned>(std::clamp(seconds_per_quick_point / timed.estimate, 1.0, double(timed.repeats)));
        total += timed.estimate * timed.repeats, done += timed.estimate * double(timed.with.size());
        most = std::max(most, timed.repeats);
    }
    if (study_.options.quick) study_.options.repeats = 1;
    const double rays = double(timed_rays_.size());
    for (unsigned repeat = 0; repeat < most; ++repeat)
        for (Timed& timed : timed_) {
            if (stopped()) return keep_times();
            if (repeat >= timed.repeats || repeat < timed.with.size()) continue;
            std::vector<RayEnd> ends;
            const RunReport with = trace(on_timed_threads(timed.variant), timed_rays_, ends, builder_.watch());
            const RunReport without = trace(without_surfaces(on_timed_threads(timed.variant), timed.most_steps),
                                            timed_rays_, ends, builder_.watch());
            if (with.interrupted || without.interrupted) return keep_times();
            timed.with.push_back(1e9 * with.seconds / rays), timed.without.push_back(1e9 * without.seconds / rays);
            done += timed.estimate;
            report(climbing() + (0.95 - climbing()) * done / total);
        }
    keep_times();
}

void Study::keep_times() {
    for (const Timed& timed : timed_) {
        StudyPoint& point = study_.curves[timed.curve].points[timed.point];
        point.time = timing_of(timed.with), point.time_without = timing_of(timed.without);
    }
}

Cheapest Study::cheapest(double error, const char* measure, Spread RayErrors::*spread) const {
    Cheapest best{error, measure, 0, 0, false};
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t c = 0; c < study_.curves.size(); ++c)
        for (std::size_t p = 0; p < study_.curves[c].points.size(); ++p) {
            const StudyPoint& point = study_.curves[c].points[p];
            if (!is_within(point, error, spread, study_.reference) || !(point.time.median < least)) continue;
            least = point.time.median;
            best.curve = c, best.point = p, best.found = true;
        }
    return best;
}

void Study::choose_cheapest() {
    study_.cheapest = {cheapest(0.25, "pixels", &RayErrors::pixels), cheapest(1e-3, "pixels", &RayErrors::pixels),
                       cheapest(1e-6, "direction", &RayErrors::direction)};
}

/// Of the points of a method that are shown, the one whose gradient evaluations per ray are nearest to so many.
const Timed* Study::nearest_in_work(const std::string& method, double gradients) const {
    const Timed* nearest = nullptr;
    double least = std::numeric_limits<double>::infinity();
    for (const Timed& timed : timed_) {
        const StudyCurve& curve = study_.curves[timed.curve];
        if (curve.method != method || curve.loose || !study_.shows(curve)) continue;
        const double off = std::abs(std::log(std::max(1.0, gradients_of(timed)) / gradients));
        if (off < least) least = off, nearest = &timed;
    }
    return nearest;
}

/// The scene's own method at about the scene's step, and what typical ones of low order do with about as much work.
std::vector<const Timed*> Study::rivals() const {
    const std::string own = plan().method().name;
    const Timed* mine = nullptr;
    double least = std::numeric_limits<double>::infinity();
    for (const Timed& timed : timed_) {
        const StudyCurve& curve = study_.curves[timed.curve];
        if (!curve.own || curve.loose || !study_.shows(curve)) continue;
        const double wanted = curve.info->adaptive ? plan().run.tolerance : plan().run.step;
        const double off = std::abs(std::log(timed.variant.step / wanted));
        if (off < least) least = off, mine = &timed;
    }
    if (!mine) return {};
    std::vector<const Timed*> all{mine};
    const double work = gradients_of(*mine);
    constexpr std::uint32_t highest_order = 4;
    for (std::uint32_t i = 0; i < plan().module().integrator_count; ++i) {
        const IntegratorInfo& info = plan().module().integrators[i];
        if (!info.typical || info.adaptive || info.order > highest_order || info.name == own) continue;
        if (const Timed* rival = nearest_in_work(info.name, work)) all.push_back(rival);
    }
    return all;
}

void Study::follow_energy() {
    if (drift_rays_.empty() || plan().scene->straight) return;
    for (const Timed* timed : rivals()) {
        if (stopped()) return;
        study_.energy.push_back(energy_trace(plan(), timed->variant, study_.sample.starts[most_bent_]));
        study_.energy.back().gradients = gradients_of(*timed);
    }
}

void Study::compare_pictures() {
    if (plan().scene->straight || stopped()) return;
    const std::vector<const Timed*> all = rivals();
    std::vector<Variant> variants;
    for (const Timed* timed : all) variants.push_back(timed->variant);
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
