#include "scene/load_integrator.h"

#include "scene/load_formula.h"

#include "formula/nodes.h"
#include "formula/parser.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string_view>

namespace kagero {
namespace {

/// How many rays a packet shall have, or 0 for "auto"; whether there are such packets the kernels know.
std::uint32_t to_lanes(const Value& lanes) {
    if (lanes.kind == Value::Kind::string) {
        if (lanes.string == "auto") return 0;
        throw InputError(lanes.place, "integrator.lanes = " + written(lanes.string) +
                                          " is neither a whole number, 1 <= value <= 1024, nor known" +
                                          suggestion(lanes.string, {"auto"}));
    }
    return to_count(lanes, "integrator.lanes", 1, 1024);
}

/// Whether rays are followed in the plane of their orbit unasked: where the space has one, and the scene says nothing
/// that belongs to another way.
bool follows_orbits(const Section& section, const IntegratorDescription& integrator, const HamiltonianInfo& info) {
    if (!integrator.use_symmetry || !info.orbit_method) return false;
    for (const char* key : {"method", "step", "tolerance", "solver_tolerance", "rescale"})
        if (find(section, key)) return false;
    return true;
}

/// The default method; adaptive, where one serves, if the scene states a tolerance, for which only those have a use, or
/// does without the space's rescaling and states no step: then steps of one length may be too long beside a hole.
std::string default_method(const Section& section, const HamiltonianInfo& info, const Catalogue& catalogue) {
    constexpr const char* adaptive = "dp85";
    const IntegratorInfo* const all = catalogue.integrators;
    const bool is_adaptive = std::find_if(all, all + catalogue.integrator_count, [&](const IntegratorInfo& one) {
        return one.name == std::string_view(info.method);
    })->adaptive;
    const Value* rescale = find(section, "rescale");
    const bool wants_control =
        find(section, "tolerance") || (rescale && rescale->string == "none" && info.rescales && !find(section, "step"));
    return wants_control && !is_adaptive && !info.discontinuous ? adaptive : info.method;
}

/// What a formula in the parameters of a space, and escape_radius, comes to. They stand for variables: numbers may be
/// infinite on the way.
double value_of(const char* formula, const HamiltonianInfo& info, const std::function<double(std::size_t)>& parameter,
                double escape_radius) {
    FormulaScope scope = formula_scope();
    std::array<double, 7> values{};
    auto add = [&, next = 0](const char* name, double value) mutable {
        values.at(static_cast<std::size_t>(next)) = value;
        define(scope, name, next++, {});
    };
    for (std::size_t i = 0; i < info.parameter_count; ++i) add(info.parameters[i].name, parameter(i));
    add("escape_radius", escape_radius);
    return evaluate(scope, parse_formula(scope, {formula, "step_goes_with", {}}), values);
}

/// The default steps, by kind.
///
/// Lengths are in proportion to that which the space names, and to the inverse of the medium's index, as what counts is
/// the way of a step. What hardly bends light is crossed in steps as long as the escape sphere is wide, no longer. Of a
/// spacetime the default is that of the rescaled H; without rescaling it goes with the first of its lengths.
std::array<double, 3> default_steps(const HamiltonianInfo& info, const SpaceDescription& space, double escape_radius) {
    const auto stated = [&](std::size_t i) { return space.parameters[i].second; };
    const auto fallback = [&](std::size_t i) { return info.parameters[i].fallback; };
    const auto over_default = [&](const char* formula) {
        const double standard = formula ? value_of(formula, info, fallback, IntegratorDescription().escape_radius) : 1;
        return formula ? value_of(formula, info, stated, escape_radius) / standard : 1;
    };
    const double way = info.step * over_default(info.step_goes_with);
    const double length =
        (info.step_goes_with ? std::min(way, escape_radius) : way) / over_default(info.index_parameter);
    const double angle = info.orbit_method ? info.orbit_step : 0.2;
    if (!info.spacetime || !info.rescales) return {length, length, angle};
    const ParameterInfo* const end = info.parameters + info.parameter_count;
    const ParameterInfo* const size =
        std::find_if(info.parameters, end, [](const ParameterInfo& one) { return one.unit == Unit::length; });
    return {size == end || stated(std::size_t(size - info.parameters)) == 0 ? length
                                                                            : length * over_default(size->name),
            length, angle};
}

/// Of a method about a space, whose H is rescaled unless the scene says otherwise.
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

IntegratorDescription load_integrator(const Section& section, SpaceDescription& space, const Catalogue& catalogue) {
    only_keys(section, {"method", "step", "tolerance", "solver_tolerance", "max_steps", "escape_radius", "hit", "cull",
                        "rescale", "refill", "symmetry", "lanes", "max_pixel_error"});

    IntegratorDescription integrator;
    const HamiltonianInfo& info = *catalogue.hamiltonian_named(space.hamiltonian);
    integrator.method = default_method(section, info, catalogue);
    read(section, "escape_radius", integrator.escape_radius, positive_length);
    integrator.default_step = default_steps(info, space, integrator.escape_radius);
    if (const Value* symmetry = find(section, "symmetry")) {
        integrator.use_symmetry = to_choice(*symmetry, "integrator.symmetry", {"auto", "none"}) == 0;
    }
    if (follows_orbits(section, integrator, info)) integrator.method = info.orbit_method;
    const auto methods = names_of(catalogue.integrators, catalogue.integrator_count);
    if (const Value* method = find(section, "method")) {
        const std::size_t chosen = to_choice(*method, "integrator.method", methods);
        integrator.method = methods[chosen], integrator.method_place = method->place;
        if (!integrator.use_symmetry && catalogue.integrators[chosen].angular)
            throw InputError(
                method->place,
                "integrator.method = \"" + methods[chosen] +
                    "\" follows rays in the plane of their orbit, which integrator.symmetry = \"none\" forbids");
    }
    const auto method = std::size_t(std::find(methods.begin(), methods.end(), integrator.method) - methods.begin());
    integrator.step = integrator.default_step[std::size_t(kind_of_step(section, info, method, catalogue))];
    read(section, "step", integrator.step, {0, 1e12, true});
    if (const Value* step = find(section, "step")) integrator.step_place = step->place;
    read(section, "tolerance", integrator.tolerance, {0, 1, true, true});
    if (const Value* tolerance = find(section, "tolerance")) integrator.tolerance_place = tolerance->place;
    read(section, "solver_tolerance", integrator.solver_tolerance, {0, 1, false, true});
    read(section, "max_pixel_error", integrator.max_pixel_error, {0, 1e6, true});
    if (const Value* steps = find(section, "max_steps")) {
        integrator.max_steps = to_count(*steps, "integrator.max_steps", 1, std::numeric_limits<std::uint32_t>::max());
    }
    if (const Value* hit = find(section, "hit")) {
        integrator.hit =
            to_choice(*hit, "integrator.hit", {"chord", "hermite"}) == 0 ? HitModel::chord : HitModel::hermite;
    }
    if (const Value* cull = find(section, "cull"))
        integrator.cull = to_choice(*cull, "integrator.cull", {"auto", "none"}) == 0;
    if (const Value* lanes = find(section, "lanes"))
        integrator.lanes = to_lanes(*lanes), integrator.lanes_place = lanes->place;
    if (const Value* refill = find(section, "refill")) {
        integrator.refill = static_cast<Refill>(to_choice(*refill, "integrator.refill", refill_names()));
    }
    if (const Value* rescale = find(section, "rescale")) {
        integrator.rescale = to_text(*rescale, "integrator.rescale");
        load_rescaling(*rescale, space, integrator);
    }
    return integrator;
}

}  // namespace kagero
