/// The points of an error study: their errors, and the first estimates of their times.
#pragma once

#include "study/kept_points.h"

namespace kagero {

/// Options of a study.
struct StudyOptions : CurveOptions {
    unsigned threads = 1;  ///< Number of threads of the timed runs.
    /// Storage of points whose errors were measured. Times of long studies are always measured again, because times of
    /// different runs are not comparable.
    PointStore store;
    unsigned repeats = 5;  ///< Smallest number of timed runs per point. In a quick study, long runs are timed once.
    /// The methods whose points this process measures before the study continues. Other processes measure the others.
    MethodShare share;
    /// Waits until the other processes have measured their points, and `store` contains them. Empty without a share.
    std::function<void()> await_others = {};
};

/// Measures the points of a study.
class PointMeasurements {
public:
    PointMeasurements(const Plan& plan, const StudyOptions& options, const std::atomic<bool>* stop)
        : options_(options), builder_(plan, options, stop) {}

    /// Traces the reference, and chooses the rays for energy errors and times. Throws as CurveBuilder::prepare.
    void prepare();
    /// Measures the points of a share of the methods, except those that are stored. Replaces the points of an earlier
    /// call. Calls `progress` with the finished share, from 0 to 1.
    void measure(const MethodShare& share, const std::function<void(double)>& progress);

    CurveBuilder& builder() { return builder_; }
    const CurveBuilder& builder() const { return builder_; }
    /// Returns the measured points in the order of curves and points.
    std::vector<TimedPoint>& timed() { return timed_; }
    const std::vector<TimedPoint>& timed() const { return timed_; }
    /// Returns the rays that are timed: all sampled rays, or a part of them in a quick study.
    const std::vector<RayStart>& timed_rays() const { return timed_rays_; }
    /// Returns the rays on which the energy errors are measured.
    const std::vector<RayStart>& drift_rays() const { return drift_rays_; }
    /// Returns the index of the sample ray along which the energy traces are recorded.
    std::size_t energy_ray() const { return energy_ray_; }
    /// Returns the plan of a variant with the number of threads that the options state for timed runs.
    Plan plan_for_timing(const Variant& variant) const;

private:
    const Plan& plan() const { return builder_.plan(); }
    void choose_drift_rays();
    void choose_timed_rays();
    std::optional<StudyPoint> restored_point(const Variant& variant);
    bool add_timed_point(const Variant& variant, std::size_t curve, StudyPoint& point, const RunReport& run,
                         const std::vector<RayEnd>& ends);

    const StudyOptions& options_;
    CurveBuilder builder_;
    std::vector<RayStart> drift_rays_, timed_rays_;
    std::size_t energy_ray_ = 0;
    std::vector<TimedPoint> timed_;
};

/// Returns the plan without surfaces and with at most `max_steps` steps per ray; unchanged if it has no surfaces.
Plan without_surfaces(Plan plan, std::uint32_t max_steps);

}  // namespace kagero
