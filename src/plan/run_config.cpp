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
    throw InputError("'" + name + "' is not in the kernel module");
}

/// The default method of a space may serve its H only as the space rescales it. Where a scene states another rescaling,
/// or none, and no method, this one is taken instead.
constexpr const char* method_for_any_rescaling = "gauss8";

std::uint32_t choose_integrator(const Scene& scene) {
    const IntegratorDescription& stated = scene.description.integrator;
    const std::uint32_t chosen = integrator_index(scene.module(), stated.method);
    if (stated.method_place || stated.rescale == "auto" || scene.description.space.formula) return chosen;
    return refusal_of(scene, chosen, states_rescaling(scene))
               ? integrator_index(scene.module(), method_for_any_rescaling)
               : chosen;
}

[[noreturn]] void refuse_method(const Scene& scene, std::uint32_t integrator, bool rescaled, const char* reason) {
    const IntegratorDescription& stated = scene.description.integrator;
    const Module& module = scene.module();
    std::string served;
    for (std::uint32_t i = 0; i < module.integrator_count; ++i)
        if (!refusal_of(scene, i, rescaled) || !refusal_of(scene, i, false))
            enumerate(served, module.integrators[i].name);
    throw InputError(stated.method_place.value_or(Place{}),
                     std::string("integrator.method = \"") + module.integrators[integrator].name + "\" cannot serve " +
                         scene.space.info().name + ": " + reason + "; it is served by " + served);
}

/// ΩH is integrated where the space declares Ω and the scene does not forbid it, or where the scene states Ω, and the
/// method can.
bool choose_rescaling(const Scene& scene, std::uint32_t integrator) {
    const bool stated = states_rescaling(scene);
    const bool wanted =
        stated || (scene.space.info().rescales && scene.description.integrator.rescale == "auto" && !scene.straight);
    if (wanted && !refusal_of(scene, integrator, true)) return true;
    if (const char* reason = refusal_of(scene, integrator, stated))
        refuse_method(scene, integrator, wanted, reason);  // a stated rescaling is not left out
    return false;
}

/// A chord may leave the curve by a fiftieth of a pixel as seen from half the scene's size, but by no more than 1e-5 of
/// that size: the pixels of small pictures are large, and where light is focused they show more.
double chord_tolerance(const Scene& scene, Purpose purpose) {
    const double size = scene_size(scene) / scene.unit, most = 1e-5 * size;
    return purpose == Purpose::picture ? std::min(most, 0.02 * pixel_size(scene.description, 0.5 * size)) : most;
}

}  // namespace

RunConfig default_run(const Scene& scene, const Options& options, Purpose purpose) {
    const IntegratorDescription& stated = scene.description.integrator;
    RunConfig run;
    run.method.integrator = choose_integrator(scene);
    run.method.rescaled = choose_rescaling(scene, run.method.integrator);
    const bool is_length = step_kind(scene, run.method.integrator, run.method.rescaled) == StepKind::length;
    run.step = is_length ? stated.step / scene.unit : stated.step;
    run.tolerance = stated.tolerance, run.solver_tolerance = stated.solver_tolerance;
    run.max_steps = stated.max_steps;
    // A formula without length_scale gets steps of adaptive methods of at most a quarter of the distance from its
    // centre.
    if (scene.description.space.formula && scene.description.space.formula->length_scale.empty())
        run.longest_share = 0.25;
    run.use_symmetry = stated.use_symmetry;
    run.hit = stated.hit;
    run.chord_tolerance = chord_tolerance(scene, purpose);
    run.refill = stated.refill;
    run.outputs = (options.energy_error ? output_energy : 0u) | (options.parameter ? output_parameter : 0u);
    run.wish = wish_of(scene, options);
    KernelWish in_double = run.wish;  // float is chosen by trial rays, or where it is asked for
    in_double.precision = run.wish.precision.value_or(Precision::float64);
    run.kernel = &choose_kernel(scene, run.method, in_double);
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
    job.hamiltonian = scene.integrated_hamiltonian(), job.parameters = scene.integrated_parameters();
    job.integrator = run.method.integrator, job.rescaled = run.method.rescaled;
    job.step = run.step, job.tolerance = run.tolerance, job.solver_tolerance = run.solver_tolerance;
    job.longest_share = run.longest_share;
    job.max_steps = run.max_steps;
    job.escape_radius = scene.limits.escape_radius, job.inner_escape_radius = scene.limits.inner_escape_radius;
    if (scene.programs.empty() && !run.method.rescaled) job.bends_within = scene.space.bending_radius();
    job.capture_within = scene.limits.capture_within, job.capture_stretch = scene.limits.capture_stretch;
    job.parameter_limit = run.parameter_limit;
    job.use_symmetry = run.use_symmetry;
    job.hit = run.hit, job.chord_tolerance = run.chord_tolerance;
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
