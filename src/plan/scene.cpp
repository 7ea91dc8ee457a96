#include "plan/scene.h"

#include "error.h"
#include "film/film.h"
#include "formula/nodes.h"
#include "modules/modules.h"
#include "plan/formula_space.h"
#include "plan/names.h"
#include "plan/units.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

constexpr const char* formula_name = "formula";

std::uint32_t hamiltonian_index(const Module& module, const std::string& name) {
    for (std::uint32_t i = 0; i < module.hamiltonian_count; ++i)
        if (name == module.hamiltonians[i].name) return i;
    throw InputError("'" + name + "' is not in the kernel module");
}

/// The space's parameters as the kernels take them: those that change sign with time do so if time is reversed.
Space make_space(const SpaceDescription& description, const Module& module, double time) {
    Space space{&module, hamiltonian_index(module, description.hamiltonian), {}, time};
    const HamiltonianInfo& info = space.info();
    for (std::size_t i = 0; i < description.parameters.size(); ++i) {
        const double value = description.parameters[i].second;
        space.parameters.push_back(info.parameters[i].odd ? time * value : value);
    }
    if (description.formula) space.parameters = compile_formula(*description.formula, module);
    return space;
}

/// A falling observer's rays live where time runs the other way.
double sense_of_time(const CameraDescription& camera, const Options& options, Purpose purpose) {
    const auto observer = purpose == Purpose::picture ? std::optional(camera.observer) : options.observer;
    return observer == ObserverKind::falling ? -1 : 1;
}

/// No more cells than there are rays: a small picture has no use for a fine grid. The length of a ray list is not known
/// here.
std::uint32_t clearance_cells(const Scene& scene, Purpose purpose) {
    if (scene.straight) return 0;
    constexpr double least = 16, most = SceneGeometry::most_clearance_cells;
    if (purpose == Purpose::ray_list) return std::uint32_t(most);
    const FilmDescription& film = scene.description.film;
    return std::uint32_t(std::clamp(std::cbrt(double(film.width) * film.height * film.spp), least, most));
}

/// Light that cannot come out of a hole is captured early, unless it can still meet an object: rays are followed from r
/// = 3M on, which is |q| = 3M without spin, and no more than √10 M with any. Listed rays are followed to just above the
/// horizon, except a falling observer's, which come to no horizon. With spin the surface of capture is a spheroid.
void limit_capture(const Scene& scene, Purpose purpose, RayLimits& limits) {
    const Hole hole = scene.module().hole(scene.space.hamiltonian, scene.space.parameters.data());
    const bool to_horizon = purpose == Purpose::ray_list && scene.space.time > 0;
    const double limit = std::sqrt(10.0) * hole.mass, nearest = to_horizon ? 0 : scene.geometry->nearest(limit);
    if (!(nearest < limit)) return;
    const double horizon = hole.mass + std::sqrt(std::max(0.0, hole.mass * hole.mass - hole.spin * hole.spin));
    const double equator = std::hypot(horizon, hole.spin);
    limits.capture_stretch = equator / horizon;
    limits.capture_within = std::max((1 + 1e-3) * equator, (1 - 1e-4) * nearest);
}

/// Behind a throat lies another universe, the mirror image of this one: there `escape_radius` counts from the throat,
/// on both sides.
RayLimits ray_limits(const Scene& scene, Purpose purpose) {
    const double far = scene.space.far_radius(), limit = scene.description.integrator.escape_radius;
    RayLimits limits;
    limits.escape_radius = far > 0 ? 0.5 * (limit + std::sqrt(limit * limit + 4 * far * far)) : limit;
    limits.inner_escape_radius = far > 0 ? far * far / limits.escape_radius : 0;
    limit_capture(scene, purpose, limits);
    return limits;
}

}  // namespace

std::uint32_t Scene::integrated_hamiltonian() const {
    return programs.empty() ? space.hamiltonian : hamiltonian_index(module(), formula_name);
}

Catalogue catalogue(const std::string& isa) {
    const Module& module = load_module(isa);
    Catalogue c{module.hamiltonians, module.hamiltonian_count, module.integrators, module.integrator_count, {},
                module.refusal};
    for (const LayerInfo& layer : all_layers()) c.layers.push_back(layer.name);
    return c;
}

std::shared_ptr<const Scene> make_scene(SceneDescription description, const Options& options, Purpose purpose) {
    auto scene = std::make_shared<Scene>();
    const Module& module = load_module(options.isa);
    const HamiltonianInfo& info = module.hamiltonians[hamiltonian_index(module, description.space.hamiltonian)];
    scene->unit = length_unit(description);
    measure_in(description, info, scene->unit);
    scene->description = std::move(description);
    const SceneDescription& s = scene->description;
    scene->space = make_space(s.space, module, sense_of_time(s.camera, options, purpose));
    scene->straight = scene->space.is_straight();
    if (s.integrator.rescaling && !scene->straight) scene->programs = compile_rescaled(s.integrator, scene->space);
    scene->geometry = std::make_unique<const SceneGeometry>(s, clearance_cells(*scene, purpose));
    scene->paints = std::make_unique<const Paints>(s, *scene->geometry, purpose == Purpose::picture);
    scene->limits = ray_limits(*scene, purpose);
    return scene;
}

double scene_size(const Scene& scene) {
    return scene.unit *
           (scene.geometry->kernel_view() ? scene.geometry->diagonal() : scene.description.integrator.escape_radius);
}

bool states_rescaling(const Scene& scene) {
    const auto& formula = scene.description.space.formula;
    return formula ? formula->parsed.rescale >= 0 : !scene.programs.empty();
}

bool lacks_pace(const Scene& scene, const double (&q)[3]) {
    if (!states_rescaling(scene)) return false;
    const auto& formula = scene.description.space.formula;
    const auto& rescaling = scene.description.integrator.rescaling;
    const std::array<double, 7> at{q[0], q[1], q[2]};
    return !((formula ? evaluate(formula->scope, formula->parsed.rescale, at)
                      : evaluate(rescaling->scope, rescaling->node, at)) > 0);
}

bool lacks_bounds(const Scene& scene, const double (&q)[3]) {
    const auto& formula = scene.description.space.formula;
    if (!formula) return false;
    const auto value = [&](std::int32_t node) {
        return node < 0 ? 1 : evaluate(formula->scope, node, {q[0], q[1], q[2], 0, 0, 0, formula->parsed.pt});
    };
    const double domain = value(formula->parsed.domain), capture = value(formula->parsed.capture);
    return !(domain <= 0 || capture <= 0 || (domain > 0 && capture > 0 && value(formula->parsed.length_scale) > 0));
}

StepKind step_kind(const Scene& scene, std::uint32_t integrator, bool rescaled) {
    if (scene.module().integrators[integrator].angular) return StepKind::angle;
    return rescaled && scene.space.info().spacetime ? StepKind::number : StepKind::length;
}

const char* refusal_of(const Scene& scene, std::uint32_t integrator, bool rescaled) {
    if (scene.description.space.formula || !scene.programs.empty())
        return scene.module().formula_refusal(scene.integrated_parameters(), integrator);
    return scene.module().refusal(scene.space.hamiltonian, integrator, rescaled);
}

std::string why_failed(const Scene& scene, Precision precision, Failure failure) {
    std::string why = describe(failure);
    if (failure != Failure::not_finite) return why;
    if (precision == Precision::float32) why += ", of which --precision double has more";
    if (states_rescaling(scene)) why += ", or integrator.rescale is not greater than 0 on the way";
    const auto& formula = scene.description.space.formula;
    if (formula && (formula->parsed.domain >= 0 || formula->parsed.capture >= 0))
        why += ", or space.domain or space.capture is no number there";
    if (formula && formula->parsed.length_scale >= 0) why += ", or space.length_scale is not greater than 0 there";
    return why;
}

}  // namespace kagero
