/// The configuration of a run: kernel, method, step and precision. It is a value that is copied and changed freely.
#pragma once

#include "plan/kernels.h"
#include "plan/view.h"

#include <limits>

namespace kagero {

/// Lengths are in the scene's unit.
struct RunConfig {
    MethodChoice method;
    double step = 0;              ///< In the unit of step_kind(); the first step of methods with step control.
    double tolerance = 0;         ///< Local error of methods with step control, relative to 1 + |value|.
    double solver_tolerance = 0;  ///< Relative solver tolerance; 0: iterate to rounding.
    std::uint32_t max_steps = 0;
    /// Bound on the steps of methods with step control, in units of the distance from the centre of the space.
    double max_step_radius_ratio = std::numeric_limits<double>::infinity();
    bool use_symmetry = true;  ///< Updates cyclic coordinates once per step, if the method supports it.
    HitModel hit = HitModel::hermite;
    double chord_tolerance = 0;  ///< Greatest distance of a chord from the dense output, a length.
    bool surfaces = true;        ///< False: rays pass through surfaces until they leave the scene.
    Refill refill = Refill::automatic;
    bool scanlines = false;  ///< True: a packet of camera rays covers adjacent pixels of one row, not a block.
    double parameter_limit = std::numeric_limits<double>::infinity();  ///< λ at which every listed ray ends.
    std::uint32_t outputs = 0;                                         ///< OutputBits.
    KernelRequest kernel_request;                                      ///< Conditions that the options state.
    const KernelInfo* kernel = nullptr;
    unsigned threads = 1;
    std::optional<Schedule> schedule;  ///< Empty: chosen for the picture.
};

/// Returns the configuration that scene and options state, with the defaults of the space for the rest. Traces no trial
/// rays. Throws InputError if the method or every kernel refuses the scene.
RunConfig default_run(const Scene& scene, const Options& options, Purpose purpose);

/// Returns the argument of a kernel. It points into the scene and the view, which must outlive it.
Job job_of(const Scene& scene, const View& view, const RunConfig& run);

/// Returns the step in the unit of the scene file.
double stated_step(const Scene& scene, const RunConfig& run);

}  // namespace kagero
