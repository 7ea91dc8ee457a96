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
const char* name_of(Schedule schedule) {
    return schedule_names()[static_cast<std::size_t>(schedule)].c_str();
}
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

ObserverKind observer_named(const std::string& name) {
    const std::vector<std::string>& names = observer_names();
    const auto known = std::find(names.begin(), names.end(), name);
    if (known != names.end()) return static_cast<ObserverKind>(known - names.begin());
    std::string there_are;
    for (const std::string& other : names) enumerate(there_are, other);
    throw InputError("there is no observer '" + name + "'; known are " + there_are);
}

const char* describe(Failure failure) {
    switch (failure) {
        case Failure::none: return "";
        case Failure::zero_direction: return "the direction has length zero";
        case Failure::nonfinite_start: return "start or direction is not finite";
        case Failure::singular_start: return "the Hamiltonian is singular at the start";
        case Failure::too_far: return "the start is too far out for numbers of this precision";
        case Failure::no_observer: return "the space has no such observer, or none can be at rest here";
        case Failure::no_rest_frame: return "the Hamiltonian is not that of light in a spacetime";
        case Failure::no_momentum: return "no momentum with this direction is found here";
        case Failure::not_converged: return "a step has no solution, or none within its tolerance, however short it is";
        case Failure::not_landed: return "its last step, however short, leads to no place on what it meets";
        case Failure::not_finite: return "the state left the range of the number type";
        case Failure::no_pace: return "integrator.rescale is not greater than 0 at the start";
        case Failure::no_bounds:
            return "space.domain, space.capture or space.length_scale is no number at the start, or that length is not "
                   "greater than 0";
        case Failure::untraced: return "interrupted before this ray was traced";
        case Failure::energy_lost:
            return "the Hamiltonian's value is lost, and half the step, however often, does not mend it: take shorter "
                   "steps, or a smaller tolerance, from the start";
        case Failure::needs_double: return "so near a horizon float cannot hold the momentum; --precision double can";
    }
    return "unknown";
}

}  // namespace kagero
