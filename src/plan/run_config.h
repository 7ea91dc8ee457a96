/// How the rays of a scene are traced: kernel, method, step and precision. A value that is copied and changed freely.
#pragma once

#include "plan/kernels.h"
#include "plan/view.h"

#include <limits>

namespace kagero {

/// Lengths are in the scene's unit.
struct RunConfig {
    MethodChoice method;
    double step = 0;              ///< in the unit of step_kind(); adaptive methods start with it
    double tolerance = 0;         ///< local error of adaptive methods, relative to 1 + |value|
    double solver_tolerance = 0;  ///< of implicit equations, relative; 0: to rounding
    std::uint32_t max_steps = 0;
    double longest_share = std::numeric_limits<double>::infinity();  ///< greatest step of adaptive methods over the
                                                                     ///< distance from the centre
    bool use_symmetry = true;
    HitModel hit = HitModel::hermite;
    double chord_tolerance = 0;
    bool surfaces = true;      ///< false: rays meet nothing, and run on until they leave the scene
    Refill refill = Refill::automatic;
    bool scanlines = false;    ///< packets of a camera are runs of a row
    double parameter_limit = std::numeric_limits<double>::infinity();  ///< λ at which every listed ray ends
    std::uint32_t outputs = 0;  ///< OutputBits
    KernelWish wish;            ///< what the caller asked of the kernel
    const KernelInfo* kernel = nullptr;
    unsigned threads = 1;
    std::optional<Schedule> schedule;  ///< empty: chosen for the picture
};

/// The configuration that scene and options state, with the defaults of the space where they state nothing; no trial
/// rays are traced. Throws InputError for a method or a kernel that cannot serve the scene.
RunConfig default_run(const Scene& scene, const Options& options, Purpose purpose);

/// The argument of a kernel. It points into the scene and the view, which must live as long.
Job job_of(const Scene& scene, const View& view, const RunConfig& run);

/// The step as the scene would state it.
double stated_step(const Scene& scene, const RunConfig& run);

}  // namespace kagero
