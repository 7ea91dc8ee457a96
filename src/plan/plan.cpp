#include "plan/plan.h"

#include "error.h"
#include "film/film.h"
#include "modules/modules.h"
#include "rays/camera.h"
#include "plan/formula_space.h"
#include "plan/kernels.h"
#include "appearance/redshift.h"
#include "plan/units.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <thread>

namespace kagero {
namespace {

template <class Infos>
std::uint32_t index_of(const std::string& name, const Infos* infos, std::uint32_t count) {
    for (std::uint32_t i = 0; i < count; ++i)
        if (name == infos[i].name) return i;
    throw InputError("'" + name + "' is not in the kernel module");
}

/// A chord may leave the curve by a fiftieth of a pixel as seen from half the scene's size, but by no more than 1e-5 of that size: the
/// pixels of small pictures are large, and where light is focused they show more.
double chord_tolerance(const Plan& plan, bool with_camera) {
    const double size = scene_size(plan) / plan.unit, most = 1e-5 * size;
    return with_camera ? std::min(most, 0.02 * pixel_size(plan.scene, 0.5 * size)) : most;
}

/// The method of a space may serve its H only as the space rescales it; where a scene states another rescaling, or none, and no method,
/// another one is taken.
void choose_method(Plan& plan) {
    IntegratorDescription& integrator = plan.scene.integrator;
    const Module& m = *plan.module;
    plan.job.integrator = index_of(integrator.method, m.integrators, m.integrator_count);
    if (integrator.method_place || integrator.rescale == "auto" || plan.scene.space.formula) return;
    if (refusal_of(plan, plan.job.integrator, states_rescaling(plan))) integrator.method = "gauss8";
    plan.job.integrator = index_of(integrator.method, m.integrators, m.integrator_count);
}

/// The space's parameters as the kernels have them: as they are where time runs the other way, if it does for the plan's rays.
void fill_parameters(Plan& plan) {
    const SpaceDescription& space = plan.scene.space;
    const HamiltonianInfo& info = plan.module->hamiltonians[plan.hamiltonian];
    for (std::size_t i = 0; i < space.parameters.size(); ++i)
        plan.parameters.push_back(info.parameters[i].odd ? plan.time * space.parameters[i].second : space.parameters[i].second);
    if (space.formula) plan.parameters = compile_formula(*space.formula, *plan.module);
    plan.job.hamiltonian = plan.hamiltonian, plan.job.parameters = plan.parameters.data();
}

/// Where the scene rescales a compiled Hamiltonian by an expression, what is integrated is interpreted.
void fill_programs(Plan& plan) {
    const auto& rescaling = plan.scene.integrator.rescaling;
    if (!rescaling || plan.straight) return;
    plan.programs = compile_rescaled(*rescaling, plan);
    plan.job.hamiltonian = index_of("formula", plan.module->hamiltonians, plan.module->hamiltonian_count);
    plan.job.parameters = plan.programs.data();
}

/// Whether to integrate ΩH: where the space declares it, the scene does not forbid it, and the method can.
bool choose_rescaling(const Plan& plan, const HamiltonianInfo& info) {
    const auto why = [&](bool rescaled) { return refusal_of(plan, plan.job.integrator, rescaled); };
    const bool stated = states_rescaling(plan), wanted = stated || (info.rescales && plan.scene.integrator.rescale == "auto" && !plan.straight);
    if (wanted && !why(true)) return true;
    const char* reason = why(stated);  // a rescaling that is stated is not left out
    if (!reason) return false;
    std::string served;
    for (std::uint32_t i = 0; i < plan.module->integrator_count; ++i)
        if (!refusal_of(plan, i, wanted) || !refusal_of(plan, i, false))
            enumerate(served, plan.module->integrators[i].name);
    throw InputError(plan.scene.integrator.method_place.value_or(Place{}), "integrator.method = \"" + plan.scene.integrator.method + "\" cannot serve " + info.name + ": " + reason +
                     "; it is served by " + served);
}

/// No more cells than there are rays: a small picture has no use for a fine grid. Of a list nobody knows how long it is.
std::uint32_t clearance_cells(const Plan& plan, bool with_camera) {
    if (plan.straight) return 0;
    constexpr double least = 16, most = SceneGeometry::everything.clearance;
    const FilmDescription& film = plan.scene.film;
    return with_camera ? std::uint32_t(std::clamp(std::cbrt(double(film.width) * film.height * film.spp), least, most)) : std::uint32_t(most);
}

/// Where an object lies so near a hole that light falls past it, or from it, light is followed that else is captured: from r = 3M on, which
/// is |q| = 3M without spin, and no more than √10 M with any. Single rays are followed as if there always were one, but not a falling
/// observer's, which come to no horizon. To no nearer than a little above that, which light with p_t < 0 comes close to but never reaches;
/// with spin it is a spheroid, as is where rays are captured then.
void limit_capture(const Plan& plan, bool with_camera, Job& job) {
    const Hole hole = plan.module->hole(plan.hamiltonian, plan.parameters.data());
    const bool to_horizon = !with_camera && plan.time > 0;
    const double limit = std::sqrt(10.0) * hole.mass, nearest = to_horizon ? 0 : plan.geometry->nearest(limit);
    if (!(nearest < limit)) return;
    const double horizon = hole.mass + std::sqrt(std::max(0.0, hole.mass * hole.mass - hole.spin * hole.spin));
    const double equator = std::hypot(horizon, hole.spin);
    job.capture_stretch = equator / horizon;
    job.capture_within = std::max((1 + 1e-3) * equator, (1 - 1e-4) * nearest);
}

/// Constants and helpers that no formula has: perhaps misspelt.
void remark_on_names(const FormulaDescription& formula, std::vector<std::string>& remarks) {
    std::vector<std::string> used;
    const auto each = [&](const auto& visit) {
        for (const auto& [name, value] : formula.constants)
            if (name != "pt") visit("constants", name);
        for (const auto& [name, text] : formula.helpers) visit("let", name);
    };
    each([&](const char*, const std::string& name) { if (formula.scope.used.contains(name)) used.push_back(name); });
    each([&](const char* table, const std::string& name) {
        if (formula.scope.used.contains(name)) return;
        const std::string near = near_match(name, used);
        remarks.push_back(std::string("space.") + table + "." + name + " has no effect: no formula uses it" + (near.empty() ? "" : "; did you mean " + near + "?"));
    });
}

/// A float counts so far.
constexpr std::uint32_t most_float_steps = 1u << 24;

/// Of what the user may not have meant.
void remark(Plan& plan, bool with_camera) {
    const SceneDescription& scene = plan.scene;
    const IntegratorDescription& integrator = scene.integrator;
    const auto say = [&](const std::string& remark) { plan.remarks.push_back(remark); };
    const bool fits = with_camera && integrator.max_pixel_error > 0;
    if (scene.space.formula) remark_on_names(*scene.space.formula, plan.remarks);
    if (integrator.max_pixel_error > 0 && !with_camera)
        say("integrator.max_pixel_error has no effect on single rays: they are traced by " + integrator.method + " as it is");
    if (integrator.max_steps > most_float_steps && plan.kernel->precision == Precision::float32)
        say("integrator.max_steps: in float rays end after " + std::to_string(most_float_steps) + " steps");
    if (integrator.tolerance_place && !plan.straight && !plan.module->integrators[plan.job.integrator].adaptive && !fits)
        say("integrator.tolerance has no effect: " + integrator.method + " takes steps of one length");
    if (with_camera && scene.camera.fov_place && scene.camera.type != "perspective")
        say("camera.fov has no effect: the camera is " + scene.camera.type);
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        const ObjectDescription& object = scene.objects[i];
        if (!plan.geometry->comes_within(static_cast<std::uint32_t>(i), plan.job.escape_radius))
            say("object." + object.name + " lies beyond integrator.escape_radius, where rays end: it is not seen");
        if (object.shape == Shape::disk && scene.space.formula)
            say("object." + object.name + ": its matter stands still, as nobody knows how it orbits in the space of a formula");
    }
}

void fill_job(Plan& plan, bool with_camera) {
    const SceneDescription& scene = plan.scene;
    Job& job = plan.job;
    const HamiltonianInfo& info = plan.module->hamiltonians[plan.hamiltonian];
    job.rescaled = choose_rescaling(plan, info);
    job.step = step_kind(plan, job.integrator, job.rescaled) == StepKind::length ? scene.integrator.step / plan.unit : scene.integrator.step;
    job.tolerance = scene.integrator.tolerance;
    // Of a formula nobody knows where it is uniform: where it says nothing of lengths, they go with the distance from its centre.
    if (scene.space.formula && scene.space.formula->length_scale.empty()) job.longest_share = 0.25;
    job.solver_tolerance = scene.integrator.solver_tolerance;
    job.max_steps = scene.integrator.max_steps;
    // Behind a throat lies another universe, the mirror image of this one: there `escape_radius` counts from the throat, on both sides.
    const double far = plan.module->far_side(plan.hamiltonian, plan.parameters.data()), limit = scene.integrator.escape_radius;
    if (plan.programs.empty() && !job.rescaled) job.bends_within = plan.module->bends_within(plan.hamiltonian, plan.parameters.data());
    job.escape_radius = far > 0 ? 0.5 * (limit + std::sqrt(limit * limit + 4 * far * far)) : limit;
    job.inner_escape_radius = far > 0 ? far * far / job.escape_radius : 0;
    job.parameter_limit = std::numeric_limits<double>::infinity();
    job.use_symmetry = scene.integrator.symmetry != "none";
    job.hit = scene.integrator.hit;
    job.chord_tolerance = chord_tolerance(plan, with_camera);
    job.outputs = plan.options.energy_error ? output_energy : 0u;
    job.geometry = plan.geometry->kernel_view();
    limit_capture(plan, with_camera, job);
    job.refill = scene.integrator.refill == "on";
}

}  // namespace

double scene_size(const Plan& plan) {
    return plan.unit * (plan.geometry->kernel_view() ? plan.geometry->diagonal() : plan.scene.integrator.escape_radius);
}

Catalogue catalogue(const std::string& isa) {
    const Module& module = load_module(isa);
    Catalogue c{module.hamiltonians, module.hamiltonian_count, module.integrators, module.integrator_count, {}, module.refusal};
    for (const LayerInfo& layer : all_layers()) c.layers.push_back(layer.name);
    return c;
}

std::unique_ptr<Plan> make_plan(SceneDescription scene, const Options& options, bool with_camera) {
    const auto begin = std::chrono::steady_clock::now();
    auto plan = std::make_unique<Plan>();
    plan->scene = std::move(scene);
    plan->options = options;
    plan->module = &load_module(options.isa);
    plan->threads = options.threads ? options.threads : std::max(1u, std::thread::hardware_concurrency());
    const SceneDescription& s = plan->scene;
    const Module& m = *plan->module;
    plan->hamiltonian = index_of(s.space.hamiltonian, m.hamiltonians, m.hamiltonian_count);
    plan->spacetime = m.hamiltonians[plan->hamiltonian].spacetime;
    plan->time = (with_camera ? s.camera.observer : options.observer) == "falling" ? -1 : 1;
    plan->unit = length_unit(s, m.hamiltonians[plan->hamiltonian]);
    measure_in(plan->scene, m.hamiltonians[plan->hamiltonian], plan->unit);
    fill_parameters(*plan);
    plan->straight = m.straight(plan->hamiltonian, plan->parameters.data());
    fill_programs(*plan);
    choose_method(*plan);
    plan->geometry = std::make_unique<SceneGeometry>(s, SceneGeometry::Parts{.clearance = clearance_cells(*plan, with_camera), .textures = with_camera});
    fill_job(*plan, with_camera);
    plan->kernel = &choose_kernel(*plan, wish_of(*plan));
    check_disks(*plan);
    if (with_camera) place_camera(*plan);
    plan->remarks = plan->geometry->remarks();
    remark(*plan, with_camera);
    plan->load_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return plan;
}

bool states_rescaling(const Plan& plan) {
    const auto& formula = plan.scene.space.formula;
    return formula ? formula->parsed.rescale >= 0 : !plan.programs.empty();
}

bool lacks_pace(const Plan& plan, const double (&q)[3]) {
    if (!states_rescaling(plan)) return false;
    const auto& formula = plan.scene.space.formula;
    const auto& rescaling = plan.scene.integrator.rescaling;
    const std::array<double, 7> at{q[0], q[1], q[2]};
    return !((formula ? evaluate(formula->scope, formula->parsed.rescale, at) : evaluate(rescaling->scope, rescaling->node, at)) > 0);
}

bool lacks_bounds(const Plan& plan, const double (&q)[3]) {
    const auto& formula = plan.scene.space.formula;
    if (!formula) return false;
    const auto value = [&](std::int32_t node) { return node < 0 ? 1 : evaluate(formula->scope, node, {q[0], q[1], q[2], 0, 0, 0, formula->parsed.pt}); };
    const double domain = value(formula->parsed.domain), capture = value(formula->parsed.capture);
    return !(domain <= 0 || capture <= 0 || (domain > 0 && capture > 0 && value(formula->parsed.length_scale) > 0));
}

bool needs_double(const Plan& plan, double momentum) {
    if (plan.kernel->precision != Precision::float32 || !plan.module->hamiltonians[plan.hamiltonian].spacetime) return false;
    return momentum * double(std::numeric_limits<float>::epsilon()) > 1e-3;
}

StepKind step_kind(const Plan& plan, std::uint32_t integrator, bool rescaled) {
    if (plan.module->integrators[integrator].angular) return StepKind::angle;
    return rescaled && plan.module->hamiltonians[plan.hamiltonian].spacetime ? StepKind::number : StepKind::length;
}

const char* refusal_of(const Plan& plan, std::uint32_t integrator, bool rescaled) {
    if (plan.scene.space.formula || !plan.programs.empty()) return plan.module->formula_refusal(plan.job.parameters, integrator);
    return plan.module->refusal(plan.hamiltonian, integrator, rescaled);
}

ObserverKind observer_named(const std::string& name) {
    const std::vector<std::string>& names = observer_names();
    const auto known = std::find(names.begin(), names.end(), name);
    if (known != names.end()) return static_cast<ObserverKind>(known - names.begin());
    std::string there_are;
    for (const std::string& other : names) enumerate(there_are, other);
    throw InputError("there is no observer '" + name + "'; known are " + there_are);
}
const char* name_of(Strategy strategy) {
    constexpr const char* names[] = {"scalar", "per-ray", "packet"};
    return names[static_cast<int>(strategy)];
}
const char* name_of(Precision precision) { return precision == Precision::float64 ? "double" : "float"; }
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
const char* name_of(Status status) {
    constexpr const char* names[status_count] = {"hit", "escaped", "captured", "step_limit", "failed"};
    return names[static_cast<int>(status)];
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
        case Failure::no_bounds: return "space.domain, space.capture or space.length_scale is no number at the start, or that length is not greater than 0";
        case Failure::untraced: return "interrupted before this ray was traced";
        case Failure::energy_lost: return "the Hamiltonian's value is lost, and half the step, however often, does not mend it: take shorter steps, or a smaller tolerance, from the start";
        case Failure::needs_double: return "so near a horizon float cannot hold the momentum; --precision double can";
    }
    return "unknown";
}

std::string why_failed(const Plan& plan, Failure failure) {
    std::string why = describe(failure);
    if (failure != Failure::not_finite) return why;
    if (plan.kernel->precision == Precision::float32) why += ", of which --precision double has more";
    if (states_rescaling(plan)) why += ", or integrator.rescale is not greater than 0 on the way";
    const auto& formula = plan.scene.space.formula;
    if (formula && (formula->parsed.domain >= 0 || formula->parsed.capture >= 0)) why += ", or space.domain or space.capture is no number there";
    if (formula && formula->parsed.length_scale >= 0) why += ", or space.length_scale is not greater than 0 there";
    return why;
}

}  // namespace kagero
