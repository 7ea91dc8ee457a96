#include "scene/load/load_integrator.h"

#include "scene/load/load_formula.h"

#include "formula/nodes.h"
#include "formula/parser.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string_view>

namespace kagero {
namespace {

/// Returns the number of rays per packet, or 0 for "auto". The number is accepted even if no kernel has it.
std::uint32_t to_lanes(const Value& lanes, const std::string& name) {
    if (lanes.kind == Value::Kind::string) {
        if (lanes.string == "auto") return 0;
        throw InputError(lanes.location, name + " = " + to_toml(lanes.string) +
                                             " is not legal: it must be \"auto\" or a whole number with "
                                             "1 <= value <= 1024" +
                                             suggestion(lanes.string, {"auto"}));
    }
    return to_count(lanes, name, 1, 1024);
}

/// Returns true if the default method is the orbit method of the space. This is the case if the space has one and the
/// scene states none of the keys method, step, tolerance, solver_tolerance and rescale. These keys select a method, or
/// apply to methods in three dimensions.
bool uses_orbit_method(const Section& section, const IntegratorDescription& integrator, const HamiltonianInfo& info) {
    if (!integrator.use_symmetry || !info.orbit_method) return false;
    for (const char* key : {"method", "step", "tolerance", "solver_tolerance", "rescale"})
        if (find(section, key)) return false;
    return true;
}

/// Returns the default method, which the Hamiltonian declares. There are three exceptions, in which the default is an
/// adaptive method unless the Hamiltonian has a discontinuity. In the first, the scene states a tolerance, which only
/// adaptive methods use. In the second, the scene disables the rescaling of the space and states no step: steps of
/// constant length may be too long near a hole. In the third, the space is a formula and the scene states no step: the
/// lengths over which a formula changes are unknown.
std::string default_method(const Section& section, const HamiltonianInfo& info, const Catalogue& catalogue) {
    constexpr const char* adaptive_method = "dp85";
    const IntegratorInfo* const begin = catalogue.integrators;
    const IntegratorInfo* const end = begin + catalogue.integrator_count;
    const bool is_adaptive = std::find_if(begin, end, [&](const IntegratorInfo& entry) {
                                 return entry.name == std::string_view(info.method);
                             })->adaptive;
    const Value* rescale = find(section, "rescale");
    const bool is_formula = info.name == std::string_view("formula");
    const bool needs_step_control =
        find(section, "tolerance") ||
        (!find(section, "step") && (is_formula || (rescale && rescale->string == "none" && info.rescales)));
    return needs_step_control && !is_adaptive && !info.discontinuous ? adaptive_method : info.method;
}

/// Returns the value of a formula that depends on the parameters of a space and on escape_radius. These are defined as
/// the variables of the formula, not as constants, because the parser rejects constant expressions that are not finite.
double value_of(const char* formula, const HamiltonianInfo& info, const std::function<double(std::size_t)>& parameter,
                double escape_radius) {
    FormulaScope scope = formula_scope();
    std::array<double, 7> values{};
    auto define_variable = [&, next = 0](const char* name, double value) mutable {
        values.at(static_cast<std::size_t>(next)) = value;
        define(scope, name, next++, {});
    };
    for (std::size_t i = 0; i < info.parameter_count; ++i) define_variable(info.parameters[i].name, parameter(i));
    define_variable("escape_radius", escape_radius);
    return evaluate(scope, parse_formula(scope, {formula, "step_goes_with", {}}), values);
}

/// Returns the unit of the method's step. H of a spacetime is rescaled unless the scene disables rescaling or the
/// method does not support it.
StepKind kind_of_step(const Section& section, const HamiltonianInfo& info, std::size_t method,
                      const Catalogue& catalogue) {
    if (catalogue.integrators[method].angular) return StepKind::angle;
    const Value* rescale = find(section, "rescale");
    const bool rescaled = info.spacetime && info.rescales && !(rescale && rescale->string == "none") &&
                          !(catalogue.refusal && catalogue.refusal(std::uint32_t(&info - catalogue.hamiltonians),
                                                                   std::uint32_t(method), true));
    return rescaled ? StepKind::number : StepKind::length;
}

}  // namespace

std::array<double, 3> default_steps(const HamiltonianInfo& info, const SpaceDescription& space, double escape_radius) {
    const auto value_in_scene = [&](std::size_t i) { return space.parameters[i].second; };
    const auto default_of = [&](std::size_t i) { return info.parameters[i].default_value; };
    const auto ratio_to_default = [&](const char* formula) {
        const double radius = IntegratorDescription().escape_radius;
        const double default_value = formula ? value_of(formula, info, default_of, radius) : 1;
        return formula ? value_of(formula, info, value_in_scene, escape_radius) / default_value : 1;
    };
    const double scaled_step = info.step * ratio_to_default(info.step_goes_with);
    const double limited_step = info.step_goes_with ? std::min(scaled_step, escape_radius) : scaled_step;
    const double length = limited_step / ratio_to_default(info.index_parameter);
    const double angle = info.orbit_method ? info.orbit_step : 0.2;
    if (!info.spacetime || !info.rescales) return {length, length, angle};
    const ParameterInfo* const end = info.parameters + info.parameter_count;
    const ParameterInfo* const size_parameter =
        std::find_if(info.parameters, end, [](const ParameterInfo& entry) { return entry.unit == Unit::length; });
    const bool size_is_nonzero =
        size_parameter != end && value_in_scene(std::size_t(size_parameter - info.parameters)) != 0;
    return {size_is_nonzero ? length * ratio_to_default(size_parameter->name) : length, length, angle};
}

IntegratorDescription load_integrator(const Section& section, SpaceDescription& space, const Catalogue& catalogue,
                                      double default_escape_radius) {
    check_keys(section, {"method", "step", "tolerance", "solver_tolerance", "max_steps", "escape_radius", "hit", "cull",
                         "rescale", "refill", "symmetry", "lanes", "max_pixel_error"});

    const auto name_of_key = [&](const char* key) { return full_name(section, key); };
    IntegratorDescription integrator;
    integrator.escape_radius = default_escape_radius;
    const HamiltonianInfo& info = *catalogue.hamiltonian_named(space.hamiltonian);
    integrator.method = default_method(section, info, catalogue);
    read(section, "escape_radius", integrator.escape_radius, positive_length);
    integrator.default_step = default_steps(info, space, integrator.escape_radius);
    if (const Value* symmetry = find(section, "symmetry")) {
        integrator.use_symmetry = to_choice(*symmetry, name_of_key("symmetry"), {"auto", "none"}) == 0;
    }
    if (uses_orbit_method(section, integrator, info)) integrator.method = info.orbit_method;
    const auto methods = names_of(catalogue.integrators, catalogue.integrator_count);
    if (const Value* method = find(section, "method")) {
        const std::size_t chosen = to_choice(*method, name_of_key("method"), methods);
        integrator.method = methods[chosen];
        integrator.method_location = method->location;
        if (!integrator.use_symmetry && catalogue.integrators[chosen].angular)
            throw InputError(method->location,
                             name_of_key("method") + " = \"" + methods[chosen] +
                                 (catalogue.integrators[chosen].separated
                                      ? "\" integrates the separated motion of rays, which "
                                      : "\" integrates rays in their orbit plane, which ") +
                                 name_of_key("symmetry") +
                                 " = \"none\" forbids; choose another method, or symmetry = \"auto\"");
    }
    const auto method = std::size_t(std::find(methods.begin(), methods.end(), integrator.method) - methods.begin());
    integrator.step = integrator.default_step[std::size_t(kind_of_step(section, info, method, catalogue))];
    read(section, "step", integrator.step, {0, 1e12, true});
    if (const Value* step = find(section, "step")) integrator.step_location = step->location;
    read(section, "tolerance", integrator.tolerance, {0, 1, true, true});
    if (const Value* tolerance = find(section, "tolerance")) integrator.tolerance_location = tolerance->location;
    read(section, "solver_tolerance", integrator.solver_tolerance, {0, 1, false, true});
    read(section, "max_pixel_error", integrator.max_pixel_error, {0, 1e6, true});
    if (const Value* steps = find(section, "max_steps")) {
        integrator.max_steps = to_count(*steps, name_of_key("max_steps"), 1, std::numeric_limits<std::uint32_t>::max());
    }
    if (const Value* hit = find(section, "hit")) {
        integrator.hit =
            to_choice(*hit, name_of_key("hit"), {"chord", "hermite"}) == 0 ? HitModel::chord : HitModel::hermite;
    }
    if (const Value* cull = find(section, "cull"))
        integrator.cull = to_choice(*cull, name_of_key("cull"), {"auto", "none"}) == 0;
    if (const Value* lanes = find(section, "lanes")) {
        integrator.lanes = to_lanes(*lanes, name_of_key("lanes"));
        integrator.lanes_location = lanes->location;
    }
    if (const Value* refill = find(section, "refill")) {
        integrator.refill = static_cast<Refill>(to_choice(*refill, name_of_key("refill"), refill_names()));
    }
    if (const Value* rescale = find(section, "rescale")) {
        integrator.rescale = to_text(*rescale, name_of_key("rescale"));
        load_rescaling(*rescale, name_of_key("rescale"), space, integrator);
    }
    return integrator;
}

}  // namespace kagero
