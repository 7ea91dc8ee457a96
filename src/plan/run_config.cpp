#include "plan/run_config.h"

#include "error.h"
#include "kernels/assertion.h"

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

std::uint32_t choose_integrator(const Scene& scene) {
    const IntegratorDescription& stated = scene.description.integrator;
    const std::uint32_t chosen = integrator_index(scene.module(), stated.method);
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

/// Returns the greatest permitted distance of a chord from the dense output, in Scene::unit: a fiftieth of a pixel at a
/// distance of half the scene's size, but at most 1e-5 of that size. The second bound applies to pictures with few
/// pixels. It also keeps hits accurate where the space magnifies, so that a pixel shows a smaller region.
double chord_tolerance(const Scene& scene, Purpose purpose) {
    const double size = scene_size(scene) / scene.unit, greatest = 1e-5 * size;
    return purpose == Purpose::picture ? std::min(greatest, 0.02 * pixel_size(scene.description, 0.5 * size))
                                       : greatest;
}

}  // namespace

RunConfig default_run(const Scene& scene, const Options& options, Purpose purpose) {
    const IntegratorDescription& stated = scene.description.integrator;
    RunConfig run;
    run.method.integrator = choose_integrator(scene);
    run.method.rescaled = choose_rescaling(scene, run.method.integrator);
    const bool is_length = step_kind(scene, run.method.integrator, run.method.rescaled) == StepKind::length;
    run.step = is_length ? stated.step / scene.unit : stated.step;
    run.tolerance = stated.tolerance;
    run.solver_tolerance = stated.solver_tolerance;
    run.max_steps = stated.max_steps;
    // For a formula without length_scale, methods with step control take steps of at most a quarter of the distance
    // from the centre of the space.
    if (scene.description.space.formula && scene.description.space.formula->length_scale.empty())
        run.max_step_radius_ratio = 0.25;
    run.use_symmetry = stated.use_symmetry;
    run.hit = stated.hit;
    run.chord_tolerance = chord_tolerance(scene, purpose);
    run.refill = stated.refill;
    run.outputs = (options.energy_error ? output_energy : 0u) | (options.parameter ? output_parameter : 0u);
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
    job.max_step_radius_ratio = run.max_step_radius_ratio;
    job.max_steps = run.max_steps;
    job.escape_radius = scene.limits.escape_radius;
    job.inner_escape_radius = scene.limits.inner_escape_radius;
    if (scene.programs.empty() && !run.method.rescaled) job.bending_radius = scene.space.bending_radius();
    job.capture_radius = scene.limits.capture_radius;
    job.capture_stretch = scene.limits.capture_stretch;
    job.parameter_limit = run.parameter_limit;
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

double stated_step(const Scene& scene, const RunConfig& run) {
    return step_kind(scene, run.method.integrator, run.method.rescaled) == StepKind::length ? run.step * scene.unit
                                                                                            : run.step;
}

}  // namespace kagero
