/// Tracing of single rays through scenes.
#pragma once

#include <kagero/options.h>

#include <array>
#include <cstdint>
#include <optional>

namespace kagero {

/// Start and direction of a ray, in scene coordinates. The direction may have any length greater than zero.
struct Ray {
    std::array<double, 3> position, direction;
};

/// The end of a ray: the columns of `kagero trace`.
struct TracedRay {
    std::string status;  ///< "hit", "escaped", "captured", "step_limit" or "failed".
    std::string object;  ///< Name of the object that was hit; otherwise empty.
    std::array<double, 3> position, direction, momentum;  ///< At the end; `direction` is dq/dλ with unit length.
    double pt = 0;                ///< p_t, the momentum conjugate to time; 0 if the space has no p_t.
    double parameter = 0;         ///< λ, the parameter of Hamilton's equations.
    std::uint32_t steps = 0;      ///< Number of integration steps.
    std::uint32_t gradients = 0;  ///< Number of evaluations of the gradient of H.
    double energy_error = 0;      ///< Greatest |H − H0| / (|p·∂H/∂p| + |H0|) along the ray; H0 is the exact value of H.
    std::string reason;           ///< Reason why the ray failed or ended as `step_limit`; otherwise empty.
    std::optional<double> action{};  ///< ∫ p·dq along the ray, if requested; in a medium, the optical path length.
    std::optional<double> time{};    ///< ∫ ∂H/∂p_t dλ along the ray, if requested; in a spacetime, the coordinate time.
    std::uint32_t bounces = 0;       ///< Number of surfaces that have sent the ray on.
    std::string medium{"space"};     ///< Name of the medium at the end.
    double weight = 1;               ///< Factor of the light at the end: the mean of the weights of the three colours.
};

/// Options of a list of rays.
struct TraceOptions {
    std::string observer{};              ///< As the argument of trace_rays.
    std::uint32_t bounces = 0;           ///< Number of surfaces through which rays continue, 0 to 1000.
    std::vector<std::string> columns{};  ///< As the argument of trace_rays.
};

/// Traces rays; element i of the result belongs to ray i. Directions are in the rest frame of `observer` ("static",
/// "zamo", "falling" or "coordinate"). If `observer` is empty, directions are those of dq/dλ in scene coordinates.
/// `columns` requests integrals along the rays, as --columns does: "action" and "time". Throws InputError if the scene,
/// an option or a column is invalid, and RunError if the run fails.
KAGERO_PUBLIC std::vector<TracedRay> trace_rays(const SceneSource& source, const std::vector<Ray>& rays,
                                                const std::string& observer = {}, const RunOptions& options = {},
                                                const std::vector<std::string>& columns = {});

}  // namespace kagero
