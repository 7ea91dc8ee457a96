/// Single rays through scenes.
#pragma once

#include <kagero/options.h>

#include <array>
#include <cstdint>

namespace kagero {

/// Start and direction of a ray in scene coordinates; the length of the direction does not matter.
struct Ray {
    std::array<double, 3> position, direction;
};

/// How a ray ended: the columns of `kagero trace`.
struct TracedRay {
    std::string status;  ///< "hit", "escaped", "captured", "step_limit" or "failed"
    std::string object;  ///< the name of the object, if hit
    std::array<double, 3> position, direction, momentum;  ///< of the end; the direction dq/dλ has unit length
    double pt = 0;         ///< 0 where the space has none
    double parameter = 0;  ///< λ
    std::uint32_t steps = 0, gradients = 0;
    double energy_error = 0;  ///< greatest |H − H0| / (|p · ∂H/∂p| + |H0|) on the way
    std::string reason;       ///< of a failed ray
};

/// Traces rays; result i belongs to ray i. `observer`: "static", "zamo" or "falling" reads directions in the rest frame
/// of that observer; empty: in coordinates. Throws InputError for a scene or an option that cannot be used, RunError.
KAGERO_PUBLIC std::vector<TracedRay> trace_rays(const SceneSource& source, const std::vector<Ray>& rays,
                                                const std::string& observer = {}, const RunOptions& options = {});

}  // namespace kagero
