#include "plan/names.h"

#include "error.h"
#include "scene/description.h"

#include <algorithm>

namespace kagero {

const char* name_of(Strategy strategy) {
    constexpr const char* names[] = {"scalar", "per-ray", "packet"};
    return names[static_cast<int>(strategy)];
}
const char* name_of(Precision precision) { return precision == Precision::float64 ? "double" : "float"; }
const char* name_of(Status status) {
    constexpr const char* names[status_count] = {"hit", "escaped", "captured", "step_limit", "failed"};
    return names[static_cast<int>(status)];
}
const char* name_of(Schedule schedule) { return schedule_names()[static_cast<std::size_t>(schedule)].c_str(); }
const char* name_of(Form form) {
    constexpr const char* names[] = {"", "gradient", "stages", "auto-vectorized", "gang"};
    return names[static_cast<int>(form)];
}
const char* name_of(Unit unit) {
    constexpr const char* names[] = {"1", "whole number", "scene lengths", "1/length", "1/length^2", "1/length^3"};
    return names[static_cast<int>(unit)];
}

std::optional<Strategy> strategy_named(const std::string& name) {
    for (const Strategy strategy : {Strategy::scalar, Strategy::per_ray, Strategy::packet})
        if (name == name_of(strategy)) return strategy;
    return std::nullopt;
}
std::optional<Precision> precision_named(const std::string& name) {
    for (const Precision precision : {Precision::float64, Precision::float32})
        if (name == name_of(precision)) return precision;
    return std::nullopt;
}
std::optional<Schedule> schedule_named(const std::string& name) {
    const auto& names = schedule_names();
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) return std::nullopt;
    return static_cast<Schedule>(found - names.begin());
}
const std::vector<std::string>& schedule_names() {
    static const std::vector<std::string> names{"scanline", "tiles", "predicted"};
    return names;
}

const std::vector<std::string>& integral_names() {
    static const std::vector<std::string> names{"action", "time"};
    return names;
}
void request_integral(Options& options, const std::string& name) {
    (name == integral_names().front() ? options.action : options.time) = true;
}

ObserverKind observer_named(const std::string& name) {
    const std::vector<std::string>& names = observer_names();
    const auto found = std::find(names.begin(), names.end(), name);
    if (found != names.end()) return static_cast<ObserverKind>(found - names.begin());
    std::string existing;
    for (const std::string& other : names) append_to_list(existing, other);
    throw InputError("there is no observer '" + name + "'; the observers are: " + existing);
}

const char* describe(Failure failure) {
    switch (failure) {
        case Failure::none: return "";
        case Failure::zero_direction: return "the direction has length zero";
        case Failure::nonfinite_start: return "a coordinate of the start or of the direction is infinite or NaN";
        case Failure::singular_start: return "the Hamiltonian is singular at the start";
        case Failure::too_far: return "the start is too far from the origin for numbers of this precision";
        case Failure::no_observer: return "the space has no such observer, or nothing can move like it there";
        case Failure::no_rest_frame: return "the Hamiltonian is not that of light in a spacetime";
        case Failure::no_momentum: return "no momentum has this direction at this position";
        case Failure::not_converged: return "a step has no solution within its tolerance, at any step length";
        case Failure::not_refined: return "the end of the ray cannot be refined, at any length of the last step";
        case Failure::not_finite: return "the state left the range of the number type";
        case Failure::bad_time_rescaling: return "integrator.rescale is not greater than 0 at the start";
        case Failure::invalid_bounds:
            return "space.domain, space.capture or space.length_scale is NaN at the start, or space.length_scale is "
                   "not greater than 0 there";
        case Failure::untraced: return "the run was interrupted before this ray was traced";
        case Failure::energy_lost:
            return "a step changes the value of the Hamiltonian too much, at any step length; choose a smaller step or "
                   "a smaller tolerance";
        case Failure::needs_double:
            return "the momentum this close to a horizon is too large for float; choose --precision double";
        case Failure::momentum_diverges:
            return "the momentum grows without bound, as at a horizon in coordinates that are singular there; rays run "
                   "backward in time, so flip the sign of the null vector of an ingoing form, or state space.capture "
                   "outside the horizon";
        case Failure::steps_vanish:
            return "the steps become so short that the ray makes no progress; H may be singular or may jump here: "
                   "state space.domain or space.capture before this point";
        case Failure::no_continuation:
            return "the light can neither pass this surface nor be reflected: no momentum along its normal has H = H0";
        case Failure::left_medium:
            return "the ray left its medium without meeting the medium's boundary; check that boundaries are closed "
                   "and "
                   "that interior and exterior of touching objects agree";
        case Failure::hamiltonian_jumps:
            return "H jumps here, where a min, max, abs or where changes its branch, and no ray can cross a jump; "
                   "replace it by a steep but continuous change or, to refract light, by a [[medium]] in a boundary "
                   "surface, or end the rays here by space.domain or space.capture";
    }
    return "unknown failure";
}

}  // namespace kagero
