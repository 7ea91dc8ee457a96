/// An error study while it is made: error_study.cpp chooses its rays and climbs the ladders of steps, study_times.cpp takes the times,
/// study_rivals.cpp sets a few methods of about the same work side by side.
#pragma once

#include "study/error_study.h"
#include "accuracy/step_ladder.h"

#include <chrono>
#include <limits>

namespace kagero {

/// One point of the study with what is needed to time it again.
struct Timed {
    Variant variant;
    std::size_t curve, point;
    double estimate = 0;  ///< seconds of one run with and one without surfaces
    unsigned repeats = 0;
    std::uint32_t most_steps = 0;  ///< without surfaces
    std::vector<double> with, without;  ///< ns per ray
};

class Study {
public:
    Study(Plan& plan, const StudyOptions& options, const Progress& progress, const std::atomic<bool>* stop)
        : plan_(plan), progress_(progress), stop_(stop) {
        study_.options = options;
    }

    ErrorStudy run();

private:
    bool stopped() const { return (stop_ && stop_->load(std::memory_order_relaxed)) || study_.options.deadline.passed(); }
    Watch watch() const { return {.stop = stop_, .time_limit = study_.options.deadline.left()}; }
    double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count(); }
    /// The share of the time that passes before any run is repeated.
    double climbing() const { return study_.options.pixel_bound ? 1 : study_.options.quick ? 0.6 : 0.3; }
    void tell(double done) const {
        if (progress_) progress_(done, seconds());
    }
    void bound_steps();
    void keep_decided();
    void choose_drift_rays();
    void choose_timed_rays();
    void climb_all();
    void climb(const Ladder& ladder);
    void close_in(StudyCurve& curve, Variant variant);
    void choose_shown();
    bool set_loose_tolerance(Variant& variant) const;
    std::optional<StudyPoint> measure(Timed& timed);
    void take_times();
    void keep_times();
    void choose_cheapest();
    Cheapest cheapest(double error, const char* measure, Spread RayErrors::*spread) const;
    void follow_energy();
    void compare_pictures();
    double gradients_of(const Timed& timed) const { return study_.curves[timed.curve].points[timed.point].gradients; }
    const Timed* nearest_in_work(const std::string& method, double gradients) const;
    std::vector<const Timed*> rivals() const;

    Plan& plan_;
    const Progress& progress_;
    const std::atomic<bool>* stop_;
    const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
    ErrorStudy study_;
    ReferenceRays reference_;
    std::vector<RayStart> drift_rays_, timed_rays_;
    std::size_t most_bent_ = 0;  ///< of the calm rays of the sample: the one whose energy is drawn
    std::vector<Timed> timed_;
    double least_work_ = std::numeric_limits<double>::infinity();
};

}  // namespace kagero
