/// The configuration of a run: kernel, method, step and precision. It is a value that is copied and changed freely.
#pragma once

#include "plan/kernels.h"
#include "plan/view.h"

#include <limits>

namespace kagero {

/// The configuration of a run. Lengths are in Scene::unit, unless stated otherwise.
struct RunConfig {
    MethodChoice method;
    double step = 0;              ///< In the unit that step_kind() names; the first step of methods with step control.
    double tolerance = 0;         ///< Local error of methods with step control; its norm is that of Job::tolerance.
    double solver_tolerance = 0;  ///< Relative solver tolerance; 0: iterate to rounding.
    std::uint32_t max_steps = 0;  ///< Number of steps after which a ray ends as `step_limit`.
    /// Greatest step of methods with step control, divided by the distance from the centre of the space.
    double max_step_radius_ratio = std::numeric_limits<double>::infinity();
    double max_step_length = std::numeric_limits<double>::infinity();  ///< Bound on the same steps.
    double first_step_length = 0;  ///< Length of the first of these steps; 0: it is `step`.
    double position_scale = 1, momentum_scale = 1, value_weight = 1;  ///< See Job::tolerance.
    /// Bounds beyond which a ray cannot end any more, see Job.
    double max_momentum = std::numeric_limits<double>::infinity(), min_step_length = 0;
    bool use_symmetry = true;          ///< True: cyclic coordinates are updated once per step, if the method can.
    HitModel hit = HitModel::hermite;  ///< Curve inside a step that is intersected with surfaces.
    double chord_tolerance = 0;        ///< Greatest distance of a chord from the dense output, a length.
    bool surfaces = true;              ///< False: no surface ends a ray.
    Refill refill = Refill::automatic;
    bool scanlines = false;  ///< True: a packet of camera rays covers adjacent pixels of one row, not a block.
    /// λ at which every ray of a ray list ends, in the unit of the scene file.
    double parameter_limit = std::numeric_limits<double>::infinity();
    /// Interval of λ at which points of paths are reported, in the unit of the scene file; 0: they follow every step.
    double path_interval = 0;
    std::uint32_t outputs = 0;     ///< OutputBits.
    KernelRequest kernel_request;  ///< Conditions on `kernel` that scene and options state.
    const KernelInfo* kernel = nullptr;
    unsigned threads = 1;
    /// Number of surfaces after which a path is cut off; empty: all rays end at the first surface.
    std::optional<std::uint32_t> max_bounces;
    /// True: paths take random branches at surfaces although a pixel has one ray, because it is one of several samples.
    bool is_one_sample = false;
    /// Bound on the error of interpolated ray ends, in pixels; 0: the rays of all pixels are traced.
    double interpolation_bound = 0;
    std::optional<Schedule> schedule;  ///< Empty: schedule_of in render/schedule.h chooses one.
};

/// Returns the configuration that scene and options state. Values that they do not state are the defaults of the space.
/// No trial rays are traced. Throws InputError if the method or every kernel refuses the scene.
RunConfig default_run(const Scene& scene, const Options& options, Purpose purpose);

/// Returns a configuration for the rays of a list that circle a hole more often than `run`, the default, can follow:
/// with the method of the space whose steps are angles. Returns nothing if the space has none.
std::optional<RunConfig> circling_run_of(const Scene& scene, const RunConfig& run);

/// Returns the argument of a kernel. The job contains pointers into the scene and the view, which must outlive it.
Job job_of(const Scene& scene, const View& view, const RunConfig& run);

/// Returns the length of a step near the camera, in the unit of the scene file; 0 if the method has no steps of a fixed
/// length.
double step_length(const Scene& scene, const RunConfig& run);

/// Returns RunConfig::step in the unit of the scene file.
double stated_step(const Scene& scene, const RunConfig& run);

}  // namespace kagero
