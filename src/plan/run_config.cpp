#include "plan/run_config.h"

#include "error.h"
#include "kernels/assertion.h"
#include "spaces/charts.h"

#include <algorithm>
#include <cmath>
#include <thread>

namespace kagero {
namespace {

std::uint32_t integrator_index(const Module& module, const std::string& name) {
    for (std::uint32_t i = 0; i < module.integrator_count; ++i)
        if (name == module.integrators[i].name) return i;
    throw InputError("the kernel module has no integrator '" + name + "'");
}

/// The method that replaces the default of a space if a scene states `rescale` but no method, and the default does not
/// support that rescaling.
constexpr const char* method_for_any_rescaling = "gauss8";

/// Default method and tolerance of ray lists.
constexpr const char* ray_list_method = "dp85";
constexpr double ray_list_tolerance = 1e-10, ray_list_tolerance_in_float = 1e-6;
/// Default tolerance of a picture of a formula, if no trial chooses one.
constexpr double formula_tolerance = 1e-9;
/// Weight of |value| in the local error of ray lists. Near a horizon |p| is large, and an error that is small relative
/// to |p| is large for the ray that escapes. The rounding errors are still small compared with the tolerance.
constexpr double ray_list_value_weight = 1e-3;

/// Returns true if the scene states none of method, step and tolerance.
bool states_no_accuracy(const IntegratorDescription& stated) {
    return !stated.method_location && !stated.step_location && !stated.tolerance_location;
}

/// Returns true if a method for the orbit plane is the default of the space, but not of the scene. Surfaces that send
/// light on send rays into all directions. An almost radial ray passes to infinity within one step of the angle, which
/// can hide a surface on the way.
bool excludes_orbit_method(const Scene& scene, Purpose purpose) {
    const IntegratorDescription& stated = scene.description.integrator;
    const std::uint32_t method = integrator_index(scene.module(), stated.method);
    return purpose == Purpose::picture && !stated.method_location && scene.module().integrators[method].angular &&
           has_rays_from_surfaces(scene.description);
}

std::uint32_t choose_integrator(const Scene& scene, Purpose purpose) {
    const IntegratorDescription& stated = scene.description.integrator;
    const std::uint32_t chosen = integrator_index(scene.module(), stated.method);
    if (excludes_orbit_method(scene, purpose)) return integrator_index(scene.module(), scene.space.info().method);
    if (purpose == Purpose::ray_list && states_no_accuracy(stated)) {
        const std::uint32_t adaptive = integrator_index(scene.module(), ray_list_method);
        if (!refusal_of(scene, adaptive, states_rescaling(scene))) return adaptive;
    }
    if (stated.method_location || stated.rescale == "auto" || scene.description.space.formula) return chosen;
    return refusal_of(scene, chosen, states_rescaling(scene))
               ? integrator_index(scene.module(), method_for_any_rescaling)
               : chosen;
}

[[noreturn]] void refuse_method(const Scene& scene, std::uint32_t integrator, bool rescaled, const char* reason) {
    const IntegratorDescription& stated = scene.description.integrator;
    const Module& module = scene.module();
    std::string supported;
    for (std::uint32_t i = 0; i < module.integrator_count; ++i)
        if (!refusal_of(scene, i, rescaled) || !refusal_of(scene, i, false))
            append_to_list(supported, module.integrators[i].name);
    throw InputError(stated.method_location.value_or(FileLocation{}),
                     std::string("integrator.method = \"") + module.integrators[integrator].name +
                         "\" does not support " + scene.space.info().name + ": " + reason +
                         "; supported methods: " + supported);
}

/// Returns true if Ω(H − H0) is integrated instead of H: if the scene states Ω, or if the space declares Ω, the scene
/// does not forbid it, and the method supports it. Throws InputError if the method does not support the space or the
/// stated Ω.
bool choose_rescaling(const Scene& scene, std::uint32_t integrator) {
    const bool stated = states_rescaling(scene);
    const bool requested =
        stated || (scene.space.info().rescales && scene.description.integrator.rescale == "auto" && !scene.straight);
    if (requested && !refusal_of(scene, integrator, true)) return true;
    if (const char* reason = refusal_of(scene, integrator, stated)) refuse_method(scene, integrator, requested, reason);
    return false;
}

/// Returns the configuration with bounds and scales of the steps of a formula, which may use any unit. For a formula
/// without length_scale, methods with step control take steps of at most a quarter of the distance from the centre of
/// the space. If the scene states no tolerance, it is relative to lengths and momenta of the scene; for the default
/// escape radius, the length is 1, as for a stated tolerance.
RunConfig with_scales_of_formula(const Scene& scene, Purpose purpose, RunConfig run) {
    constexpr double first_step_share = 1e-3, max_momentum_growth = 1e3, min_step_share = 1e-11;
    const IntegratorDescription& stated = scene.description.integrator;
    // A camera with a stated velocity sees light of frequency 1, whatever p_t is.
    const bool has_unit_frequency = purpose == Purpose::picture && scene.description.camera.velocity;
    const double momentum =
        typical_momentum(scene) / (has_unit_frequency ? std::abs(scene.description.space.formula->parsed.pt) : 1);
    if (scene.description.space.formula->length_scale.empty()) run.max_step_radius_ratio = 0.25;
    if (!stated.tolerance_location) {
        run.position_scale = stated.escape_radius / IntegratorDescription().escape_radius;
        run.momentum_scale = momentum;
    }
    if (!stated.step_location) run.first_step_length = first_step_share * stated.escape_radius;
    run.max_momentum = max_momentum_growth * momentum;
    run.min_step_length = min_step_share * stated.escape_radius;
    return run;
}

/// Returns true if H depends on p_t.
bool depends_on_pt(const Scene& scene) {
    const auto& formula = scene.description.space.formula;
    if (!formula) return scene.space.info().spacetime;
    constexpr int pt_bit = formula_variables.size() - 1;
    return (formula->scope.variables[static_cast<std::size_t>(formula->parsed.energy)] >> pt_bit & 1) != 0;
}

/// Returns the OutputBits of the options. Throws InputError if a column or a layer of the film needs the time, but H
/// does not depend on p_t.
std::uint32_t outputs_of(const Scene& scene, const Options& options, Purpose purpose) {
    const std::vector<std::string>& layers = scene.description.film.layers;
    const bool has_time_layer =
        purpose == Purpose::picture && std::find(layers.begin(), layers.end(), "time") != layers.end();
    if ((options.time || has_time_layer) && !depends_on_pt(scene))
        throw InputError(std::string(options.time ? "--columns" : "film.layers") +
                         ": \"time\" is the integral of dH/dpt along the ray, but the H of " +
                         scene.space.info().name +
                         " does not depend on pt; leave it out (in a medium, \"action\" is the optical path length)");
    return (options.energy_error ? output_energy : 0u) | (options.parameter ? output_parameter : 0u) |
           (options.action ? output_action : 0u) | (options.time ? output_time : 0u);
}

/// Returns the greatest permitted distance of a chord from the dense output, in Scene::unit: a fiftieth of a pixel at a
/// distance of half the scene's size, but at most 1e-5 of that size. The second bound applies to pictures with few
/// pixels. It also keeps hits accurate where the space magnifies, so that a pixel shows a smaller region.
double chord_tolerance(const Scene& scene, Purpose purpose) {
    const double size = scene_size(scene) / scene.unit, greatest = 1e-5 * size;
    return purpose == Purpose::picture ? std::min(greatest, 0.02 * pixel_size(scene.description, 0.5 * size))
                                       : greatest;
}

/// Returns true if rays of this view can change between ingoing and outgoing coordinates on their way.
bool changes_charts_on_the_way(const Scene& scene, const View& view) {
    if (!horizon_of_spinning_hole(scene.space)) return false;
    return is_nearly_extreme(scene.space) || !view.has_camera || view.camera.start.ingoing ||
           scene.description.camera.type == CameraType::orthographic;
}

}  // namespace

RunConfig default_run(const Scene& scene, const Options& options, Purpose purpose) {
    const IntegratorDescription& stated = scene.description.integrator;
    RunConfig run;
    run.method.integrator = choose_integrator(scene, purpose);
    run.method.rescaled = choose_rescaling(scene, run.method.integrator);
    const bool is_ray_list_default = purpose == Purpose::ray_list && states_no_accuracy(stated) &&
                                     scene.module().integrators[run.method.integrator].adaptive;
    const StepKind kind = step_kind(scene, run.method.integrator, run.method.rescaled);
    const bool uses_default_step = is_ray_list_default || excludes_orbit_method(scene, purpose);
    const double step = uses_default_step ? stated.default_step[static_cast<std::size_t>(kind)] : stated.step;
    run.step = kind == StepKind::length ? step / scene.unit : step;
    const double default_tolerance =
        options.precision == Precision::float32 ? ray_list_tolerance_in_float : ray_list_tolerance;
    run.tolerance = is_ray_list_default ? default_tolerance : stated.tolerance;
    if (scene.description.space.formula && !stated.tolerance_location && purpose == Purpose::picture)
        run.tolerance = formula_tolerance;
    if (is_ray_list_default) run.value_weight = ray_list_value_weight;
    run.solver_tolerance = stated.solver_tolerance;
    run.max_steps = stated.max_steps;
    if (scene.description.space.formula) run = with_scales_of_formula(scene, purpose, run);
    run.use_symmetry = stated.use_symmetry;
    run.hit = stated.hit;
    run.chord_tolerance = chord_tolerance(scene, purpose);
    run.refill = stated.refill;
    run.outputs = outputs_of(scene, options, purpose);
    run.kernel_request = make_kernel_request(scene, options);
    KernelRequest request = run.kernel_request;  // Without a request, only trial rays choose float.
    request.precision = run.kernel_request.precision.value_or(Precision::float64);
    run.kernel = &choose_kernel(scene, run.method, request);
    run.threads = options.threads ? options.threads : std::max(1u, std::thread::hardware_concurrency());
    run.schedule = options.schedule;
    KAGERO_ASSERT(!refusal_of(scene, run.method.integrator, run.method.rescaled) &&
                  !refusal_of(scene, *run.kernel, run.method));
    return run;
}

std::optional<RunConfig> circling_run_of(const Scene& scene, const RunConfig& run) {
    constexpr double step = 0.1;  // radians; the error of a direction is then of the order of rounding errors
    const char* const method = scene.space.info().orbit_method;
    const bool is_default = states_no_accuracy(scene.description.integrator) && !scene.straight;
    if (!method || !is_default || !scene.description.integrator.use_symmetry) return {};
    RunConfig circling = run;
    circling.method = {integrator_index(scene.module(), method), false};
    if (refusal_of(scene, circling.method.integrator, false)) return {};
    KernelRequest request = run.kernel_request;
    request.precision = run.kernel->precision;
    circling.kernel = find_kernel(scene, circling.method, request);
    if (!circling.kernel) return {};
    circling.step = step;
    return circling;
}

Job job_of(const Scene& scene, const View& view, const RunConfig& run) {
    KAGERO_ASSERT(run.kernel && run.step > 0 && run.max_steps > 0 &&
                  run.method.integrator < scene.module().integrator_count);
    Job job{};
    job.hamiltonian = scene.integrated_hamiltonian();
    job.parameters = scene.integrated_parameters();
    job.integrator = run.method.integrator;
    job.rescaled = run.method.rescaled;
    job.step = run.step;
    job.tolerance = run.tolerance;
    job.solver_tolerance = run.solver_tolerance;
    job.position_scale = run.position_scale;
    job.momentum_scale = run.momentum_scale;
    job.value_weight = run.value_weight;
    job.first_step_length = run.first_step_length;
    job.max_step_length = run.max_step_length;
    job.max_step_radius_ratio = run.max_step_radius_ratio;
    job.max_momentum = run.max_momentum;
    job.min_step_length = run.min_step_length;
    job.max_steps = run.max_steps;
    job.escape_radius = scene.limits.escape_radius;
    job.inner_escape_radius = scene.limits.inner_escape_radius;
    if (!states_rescaling(scene) && !run.method.rescaled) job.bending_radius = scene.space.bending_radius();
    job.capture_radius = scene.limits.capture_radius;
    job.capture_stretch = scene.limits.capture_stretch;
    job.hole = scene.space.hole();
    job.chart_radius = changes_charts_on_the_way(scene, view) ? scene.limits.chart_radius : 0;
    job.changes_chart_at_turns = is_nearly_extreme(scene.space);
    job.parameter_limit = run.parameter_limit;
    job.path_interval = run.path_interval;
    job.use_symmetry = run.use_symmetry;
    job.hit = run.hit;
    job.chord_tolerance = run.chord_tolerance;
    job.outputs = run.outputs;
    job.geometry = run.surfaces ? scene.geometry->kernel_view() : nullptr;
    job.camera = kernel_makes_rays(scene, view) ? &view.camera : nullptr;
    job.scanlines = run.scanlines;
    job.refill = run.refill == Refill::on;
    return job;
}

double step_length(const Scene& scene, const RunConfig& run) {
    const bool is_length = step_kind(scene, run.method.integrator, run.method.rescaled) == StepKind::length;
    if (scene.straight || !is_length || run.method.rescaled ||
        scene.module().integrators[run.method.integrator].adaptive)
        return 0;
    return run.step * scene.unit * typical_speed(scene);
}

double stated_step(const Scene& scene, const RunConfig& run) {
    return step_kind(scene, run.method.integrator, run.method.rescaled) == StepKind::length ? run.step * scene.unit
                                                                                            : run.step;
}

}  // namespace kagero
