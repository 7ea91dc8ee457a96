/// Where rays of the camera reach the sky: the direction on the sky as a function of the direction of view.
#pragma once

#include "plan/plan.h"
#include "render/run_report.h"

namespace kagero {

/// The end of a ray in a scene without objects.
struct SkyEnd {
    enum class Kind : std::uint8_t { first_sky, second_sky, captured, other };
    std::array<float, 3> direction{};  ///< Unit vector on the sky; zero if the ray reaches none.
    Kind kind = Kind::other;

    bool reaches_sky() const { return kind == Kind::first_sky || kind == Kind::second_sky; }
};

/// Traces rays from the camera and returns their ends. The directions are in the rest frame of the observer, with any
/// length. Adds the number of rays and the seconds to `rays` and `seconds`.
std::vector<SkyEnd> trace_sky_ends(const Plan& plan, const std::vector<Double3>& directions, std::uint64_t& rays,
                                   double& seconds);

}  // namespace kagero
