#include "plan/decisions.h"

#include "error.h"
#include "film/film.h"
#include "plan/sampling.h"
#include "scene/sky_only.h"
#include "spaces/charts.h"
#include "spaces/formula_space.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace kagero {
namespace {

/// The decisions in the order in which they were added.
struct DecisionList {
    std::vector<Decision> decisions{};

    /// Adds a feature that is used, or that is left out for this reason.
    void add(bool used, const std::string& feature, const std::string& reason) {
        decisions.push_back({feature, used, reason});
    }
    void add_used(const std::string& feature) { decisions.push_back({feature, true, {}}); }
};

constexpr const char* all_rays_straight = "every ray is straight with these parameters";
constexpr const char* no_symmetry = "integrator.symmetry = \"none\"";

/// Returns the properties of the integrated Hamiltonian. The properties of a formula depend on the keys of the scene.
/// If the scene states an expression for Ω, no coordinate is treated as cyclic.
HamiltonianInfo integrated_properties(const Scene& scene) {
    HamiltonianInfo info = scene.space.info();
    if (const auto& formula = scene.description.space.formula) {
        info.bounded = !formula->domain.empty();
        info.captures = !formula->capture.empty();
        info.bounds_steps = !formula->length_scale.empty();
        info.rescales = formula->parsed.rescale >= 0;
        info.discontinuous = has_kinks(*formula);
    }
    if (!scene.integrated.is_of_space()) {
        info.rescales = true;
        std::fill_n(info.cyclic, 3, false);
    }
    return info;
}

/// Returns true if the integrated Hamiltonian has the form |p|²/2 + V(q). The Nyström methods, which are the methods
/// with `drift_kick`, support only this form.
bool is_separable(const Scene& scene, const RunConfig& run) {
    for (std::uint32_t i = 0; i < scene.module().integrator_count; ++i)
        if (scene.module().integrators[i].drift_kick) return !refusal_of(scene, i, run.method.rescaled);
    return false;
}

/// Returns the reason why a run does not integrate the separated motion, or the motion in the orbit plane.
std::string reason_against_angles(const Scene& scene, const HamiltonianInfo& properties, bool method_from_trial,
                                  bool separated) {
    if (scene.straight) return all_rays_straight;
    const char* const method = supported_angular_method(scene, separated);
    if (!method)
        return separated ? "the motion separates only in the space kerr"
                         : "the space declares no potential for the orbit plane";
    if (!properties.orbit_method)
        return std::string("it is not the default of the space; integrator.method = \"") + method + "\" selects it";
    if (!scene.description.integrator.use_symmetry) return no_symmetry;
    if (has_rays_from_surfaces(scene.description) && !scene.description.integrator.method_location)
        return "rays leave surfaces in all directions, also almost radially: one step of the angle can then pass a "
               "small surface";
    if (method_from_trial) return "the trial found that the general path is cheaper";
    return "the scene states a method for the general path, or a step, a tolerance or a rescaling";
}

/// Returns the cyclic coordinates, on which the integrated Hamiltonian does not depend, as text such as "x, y".
std::string cyclic_coordinates(const HamiltonianInfo& properties) {
    std::string text;
    for (std::size_t i = 0; i < 3; ++i)
        if (properties.cyclic[i]) append_to_list(text, formula_variables[i]);
    return text;
}

/// Returns the reason why cyclic coordinates are not updated once per step; empty if they are.
std::string reason_against_cyclic_update(const Scene& scene, const RunConfig& run, const HamiltonianInfo& properties) {
    const IntegratorInfo& method = scene.module().integrators[run.method.integrator];
    if (scene.straight) return all_rays_straight;
    if (!scene.integrated.is_of_space()) return "integrator.rescale is an expression";
    if (cyclic_coordinates(properties).empty()) return "H depends on every coordinate";
    if (!run.use_symmetry) return no_symmetry;
    if (!method.drift_kick) return std::string(method.name) + " updates all coordinates together";
    return "";
}

/// Returns the reason why H is integrated without time rescaling.
std::string reason_against_rescaling(const Scene& scene, const RunConfig& run, const HamiltonianInfo& properties) {
    if (scene.straight) return all_rays_straight;
    if (!properties.rescales) return "the space declares no rescaling factor";
    if (scene.description.integrator.rescale == "none") return "integrator.rescale = \"none\"";
    return std::string(scene.module().integrators[run.method.integrator].name) +
           " does not support the rescaled Hamiltonian";
}

/// Adds a decision with the variables on which a formula's H depends, and one for each momentum that is constant
/// because its coordinate is cyclic.
void add_formula_decisions(const Scene& scene, const RunConfig& run, DecisionList& list) {
    const FormulaDescription& formula = *scene.description.space.formula;
    const auto variables_of = [&](std::int32_t node) {  // one bit per variable, see FormulaScope::variables
        return node < 0 ? 0 : formula.scope.variables[static_cast<std::size_t>(node)];
    };
    const int variables_in_h = variables_of(formula.parsed.energy);
    const int variables_in_omega = variables_of(formula.parsed.rescale);
    const auto occurs_in_h = [&](std::size_t i) { return (variables_in_h >> i & 1) != 0; };
    std::string variable_list;
    for (std::size_t i = 0; i < formula_variables.size(); ++i)
        if (occurs_in_h(i)) append_to_list(variable_list, formula_variables[i]);
    list.add_used("H as a function of " + variable_list +
                  (is_separable(scene, run) ? "; the integrated Hamiltonian has the form |p|\u00b2/2 + V(q)" : ""));
    for (std::size_t i = 0; i < 3; ++i)
        if (!occurs_in_h(i) && !(variables_in_omega >> i & 1))
            list.add(false, std::string("equation of motion of ") + formula_variables[i + 3],
                     std::string("H does not depend on ") + formula_variables[i] + ", so " + formula_variables[i + 3] +
                         " is a constant of the motion");
}

/// Adds the decision whether the programs of H are interpreted.
void add_code_decision(const Scene& scene, DecisionList& list) {
    const auto& formula = scene.description.space.formula;
    if (!scene.integrated.has_programs())
        return list.add(false, "interpreter of H", "H and its time rescaling are compiled");
    const std::string function = formula ? "H" : "H times " + scene.description.integrator.rescale;
    const std::string& reason = scene.integrated.code.why_interpreted;
    if (!reason.empty()) return list.add_used("interpreter of H: " + function + " is not compiled, because " + reason);
    list.add_used("machine code for " + function + ", generated when the scene was loaded");
    list.add(false, "interpreter of H", "the machine code gives the same results");
}

/// Returns the decisions about the events that end rays and about intersection queries.
std::vector<Decision> end_decisions(const Scene& scene, const RunConfig& run) {
    const HamiltonianInfo properties = integrated_properties(scene);
    const Geometry* geometry = scene.geometry->kernel_view();
    DecisionList list;
    const std::string no_objects = "the scene has no objects";
    list.add(properties.bounded, "test for the edge of the domain", "the domain has no edge");
    list.add(properties.captures && !scene.straight, "test for capture",
             properties.captures ? all_rays_straight : "the space captures no rays");
    list.add(geometry,
             "Embree scene of " + std::to_string(geometry ? geometry->surface_count : 0) +
                 (geometry && geometry->surface_count == 1 ? " surface" : " surfaces"),
             no_objects + ", so no Embree device is created");
    list.add(geometry && geometry->clearance, "clearance grid: steps far from every surface need no Embree query",
             !geometry        ? no_objects
             : scene.straight ? "every ray is straight, so one query per ray is enough"
                              : "integrator.cull = \"none\"");
    list.add(run.hit == HitModel::hermite && !scene.straight, "refinement of events by correction steps of the method",
             scene.straight ? "every ray is straight, so its end is computed in closed form"
                            : "integrator.hit = \"chord\"");
    list.add(run.refill == Refill::on, "refill of lanes whose ray has terminated",
             run.refill == Refill::off ? "integrator.refill = \"off\""
                                       : "rays of neighbouring pixels end at about the same time; `trace` decides by a "
                                         "trial of a few packets");
    list.add(run.max_bounces.has_value(),
             std::string("generations of rays that continue at ") +
                 (has_material(scene.description, Material::diffuse) ? "mirrors, boundaries and diffuse surfaces"
                                                                     : "mirrors and boundaries") +
                 ", through up to " + std::to_string(run.max_bounces.value_or(0)) + " surfaces",
             "every ray ends at the first surface");
    if (has_material(scene.description, Material::diffuse))
        list.add(scene.lights && !scene.lights->empty(),
                 "scattered rays toward the lights: half of them at the first surface, later at least the share that "
                 "the surface absorbs",
                 "no surface emits light, and no sky has bright parts");
    list.add(scene.straight && geometry, "one query for the whole path of a ray",
             geometry ? "rays are bent, so every step is queried separately" : no_objects);
    return std::move(list.decisions);
}

/// Adds the decision on the charts of rays near a black hole.
void add_chart_decision(const Scene& scene, const View& view, DecisionList& list) {
    if (!horizon_of(scene.space)) return;
    const bool may_turn_near_horizon = horizon_of_spinning_hole(scene.space) && is_nearly_extreme(scene.space);
    list.add(view.camera.start.ingoing || may_turn_near_horizon,
             "ingoing coordinates for rays that move outward near the horizon, |q| < " +
                 plain_number(scene.limits.chart_radius * scene.unit),
             "the rays of this camera are regular in outgoing coordinates");
}

/// Adds decisions about velocities that the scene states, and about the orbits of disks in the space of a formula.
void add_velocity_decisions(const Scene& scene, DecisionList& list) {
    const SceneDescription& description = scene.description;
    list.add(description.camera.velocity.has_value(), "rest frame of a camera with the velocity camera.velocity",
             "the scene does not state camera.velocity");
    list.add(description.space.sky_frame.has_value(),
             "directions and frequencies of the light of the sky in the rest frame of space.sky_frame",
             "the scene does not state space.sky_frame");
    for (std::size_t i = 0; i < description.objects.size(); ++i) {
        const ObjectDescription& object = description.objects[i];
        if (object.velocity) list.add_used("matter of object." + object.name + " with its stated velocity");
        if (object.velocity || object.shape != Shape::disk || scene.sources.orbits.empty()) continue;
        const CircularOrbits& orbits = scene.sources.orbits[i];
        const std::string feature = "circular orbits of the matter of object." + object.name + ", found from H",
                          at_rest = ranges_at_rest(orbits, scene.unit);
        list.add(orbits.refusal().empty(),
                 feature + (at_rest.empty() ? "" : "; at rest at distances " + at_rest + " from its centre"),
                 orbits.refusal());
    }
}

/// Returns the decisions about camera rays, pixels and layers.
std::vector<Decision> picture_decisions(const Scene& scene, const View& view, const RunConfig& run) {
    DecisionList list;
    const FilmDescription& film = scene.description.film;
    const bool kernel_generates_rays = kernel_makes_rays(scene, view);
    list.add(kernel_generates_rays, "generation of camera rays in the kernel, one packet at a time",
             film.spp > 1                 ? "film.spp > 1"
             : view.solves_each_direction ? "H is not quadratic in p, so the momentum of every direction is solved for"
                                          : "the camera is " + name_of(scene.description.camera.type));
    add_chart_decision(scene, view, list);
    list.add(film.spp > 1, "scrambled Sobol points as sample positions in the pixel",
             "film.spp = 1, so each ray passes through the centre of its pixel");
    list.add(run.interpolation_bound > 0,
             "adaptive sampling: ray ends in cells of up to 32 x 32 pixels are interpolated with an error of at most " +
                 plain_number(run.interpolation_bound) + " pixels",
             reason_for_full_sampling(scene, view, run));
    list.add(scene.paints->sky_has_pattern(), "footprints of pixels on the sky",
             "the sky has neither an image nor a checker pattern");
    list.add(scene.paints->surfaces_have_patterns(), "footprints of pixels on surfaces",
             "no object has an image or a checker pattern");
    add_velocity_decisions(scene, list);
    for (const LayerInfo& layer : all_layers()) {
        const bool requested = std::find(film.layers.begin(), film.layers.end(), layer.name) != film.layers.end();
        list.add(requested, std::string("layer ") + layer.name, "film.layers does not contain it");
    }
    const std::string why_no_map = why_not_only_sky(scene.description);
    const std::string why_no_family = why_no_map.empty() ? why_no_orbit_family(scene, view) : why_no_map;
    const bool has_family = why_no_family.empty();
    list.add(why_no_map.empty() && !has_family,
             "map over all directions in `kagero view`, which turning views use again",
             has_family ? "the family of orbits replaces it" : why_no_map);
    list.add(has_family, "family of orbits in `kagero view`: the angle to the line to the centre determines each ray",
             why_no_family);
    list.add(false, "ray parameter \u03bb at the ends of rays", "no layer needs it");
    list.add(scene.unit != 1, "lengths in units of " + plain_number(scene.unit),
             scene.integrated.has_programs() ? "a formula keeps the unit of length in which it is written"
                                             : "the size of the scene needs no other unit of length");
    return std::move(list.decisions);
}

}  // namespace

std::string plain_number(double x) {
    std::ostringstream out;
    out << x;
    return out.str();
}

std::vector<Decision> motion_decisions(const Scene& scene, const RunConfig& run, bool method_from_trial) {
    const HamiltonianInfo properties = integrated_properties(scene);
    const IntegratorInfo& method = scene.module().integrators[run.method.integrator];
    const bool rays_bend = !scene.straight;
    DecisionList list;
    list.add(rays_bend,
             std::string("integration by ") + method.name +
                 (method.adaptive ? ", tolerance " + plain_number(run.tolerance)
                                  : ", step " + plain_number(stated_step(scene, run))),
             all_rays_straight);
    list.add(rays_bend,
             "derivatives of H by reverse automatic differentiation; only \u2202H/\u2202q or \u2202H/\u2202p where the "
             "method needs only one",
             all_rays_straight);
    list.add(false, "equation of motion of p_t", "H does not depend on time, so p_t is a constant of the motion");
    list.add(rays_bend && method.angular && !method.separated,
             "integration in the orbit plane: two variables and the angle instead of six variables",
             reason_against_angles(scene, properties, method_from_trial, false));
    list.add(rays_bend && method.separated,
             "separated motion in Mino time: the radius, and independently of it the direction from the hole",
             reason_against_angles(scene, properties, method_from_trial, true));
    const std::string cyclic_reason = reason_against_cyclic_update(scene, run, properties);
    if (!scene.description.space.formula)
        list.add(cyclic_reason.empty(),
                 cyclic_reason.empty()
                     ? "stratified space: one update per step of " + cyclic_coordinates(properties) +
                           ", on which H does not depend"
                     : "stratified space: one update per step of the coordinates on which H does not depend",
                 cyclic_reason);
    list.add(run.method.rescaled, "time rescaling: integration of \u03a9 (H \u2212 H0) instead of H",
             reason_against_rescaling(scene, run, properties));
    if (scene.description.space.formula) add_formula_decisions(scene, run, list);
    add_code_decision(scene, list);
    const bool implicit = rays_bend && method.implicit && (method.is_collocation || !is_separable(scene, run));
    list.add(implicit,
             std::string("implicit equations, solved in each lane by ") +
                 (method.family == MethodFamily::recipe ? "Newton's method" : "fixed-point iteration"),
             !rays_bend        ? all_rays_straight
             : method.implicit ? "the integrated Hamiltonian has the form |p|\u00b2/2 + V(q), for which the steps of "
                                 "this method are explicit"
                               : "the method is explicit");
    list.add(rays_bend && method.adaptive, "step control in each lane",
             rays_bend ? "the steps of the method have a fixed length" : all_rays_straight);
    const bool radius_limits_steps = rays_bend && method.adaptive && std::isfinite(run.max_step_radius_ratio);
    if (radius_limits_steps)
        list.add_used(
            "step bound of a quarter of |q|: the space states no length_scale, and longer steps can miss small "
            "features");
    else
        list.add(rays_bend && properties.bounds_steps && !method.angular,
                 "step bound from the length scale of the space",
                 !rays_bend       ? all_rays_straight
                 : method.angular ? "the steps of the method are angles, which have no length"
                                  : "the space declares no length scale");
    list.add(rays_bend && properties.discontinuous, "splitting of steps at discontinuities of H or its derivatives",
             !rays_bend                        ? all_rays_straight
             : scene.description.space.formula ? "H contains no min, max, abs or where"
                                               : "H is smooth");
    list.add(rays_bend && std::isfinite(job_of(scene, {}, run).bending_radius),
             "one step through the whole region in which rays are straight",
             rays_bend ? "the space declares no such region" : all_rays_straight);
    list.add(rays_bend, "energy test: a step that changes H too much is halved", all_rays_straight);
    return std::move(list.decisions);
}

Decision medium_decision(const std::string& name, const Scene& scene, const RunConfig& run) {
    const IntegratorInfo& method = scene.module().integrators[run.method.integrator];
    const std::string motion = scene.straight
                                   ? "straight rays in closed form"
                                   : std::string("integration by ") + method.name +
                                         (method.adaptive ? ", tolerance " + plain_number(run.tolerance)
                                                          : ", step " + plain_number(stated_step(scene, run)));
    return {"medium." + name + ": " + motion + ", in " +
                (run.kernel->precision == Precision::float64 ? "double" : "float"),
            true,
            {}};
}

Decisions decisions_of(const Scene& scene, const View& view, const RunConfig& run) {
    return {
        {}, motion_decisions(scene, run, false), {}, end_decisions(scene, run), picture_decisions(scene, view, run)};
}

}  // namespace kagero
