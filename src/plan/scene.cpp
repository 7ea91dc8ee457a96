#include "plan/scene.h"

#include "error.h"
#include "film/film.h"
#include "formula/nodes.h"
#include "geometry/file_materials.h"
#include "modules/modules.h"
#include "plan/names.h"
#include "plan/units.h"
#include "scene/print.h"
#include "scene/value.h"
#include "scene/vector3.h"
#include "spaces/charts.h"
#include "spaces/formula_form.h"
#include "spaces/formula_space.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace kagero {
namespace {

/// Returns the value of an expression of a formula at a position; 1 for an expression that the scene does not state.
double value_of_bound(const FormulaDescription& formula, std::int32_t node, const double (&q)[3]) {
    return node < 0 ? 1 : evaluate(formula.scope, node, {q[0], q[1], q[2], 0, 0, 0, formula.parsed.pt});
}

constexpr const char* formula_name = "formula";

/// Returns the space with its parameters as the kernels need them. `size` is that of compile_formula.
Space make_space(const SpaceDescription& description, const Module& module, double size, bool for_comparison) {
    Space space{&module, hamiltonian_index(module, description.hamiltonian), {}};
    for (const auto& [name, value] : description.parameters) space.parameters.push_back(value);
    if (description.formula) space.parameters = compile_formula(*description.formula, module, size,
                                                                  for_comparison);
    return space;
}

/// Returns the number of cells of the clearance grid along its longest edge; 0 (no grid) for straight rays. The number
/// is the cube root of the number of rays, within limits, because a fine grid is not worthwhile for few rays. The
/// length of a ray list is unknown at this stage, so ray lists get the finest grid.
std::uint32_t clearance_cells(const Scene& scene, Purpose purpose) {
    if (scene.straight) return 0;
    constexpr double least = 16, greatest = SceneGeometry::max_clearance_cells;
    if (purpose == Purpose::ray_list) return std::uint32_t(greatest);
    const FilmDescription& film = scene.description.film;
    return std::uint32_t(std::clamp(std::cbrt(double(film.width) * film.height * film.spp), least, greatest));
}

/// Returns the ray along the axis of the camera.
RayStart ray_along_axis(const SceneDescription& scene, const Space& space) {
    const Double3 q = subtract(scene.camera.position, scene.space.center);
    return space.start({q[0], q[1], q[2]}, subtract(scene.camera.look_at, scene.camera.position));
}

/// Returns the table [integrator] of a formula with default steps in the units of the scene. They are proportional to
/// the escape radius, and inversely proportional to |dq/dλ| at the camera. A step is then a fixed share of the escape
/// radius.
IntegratorDescription with_scaled_steps(const Scene& scene) {
    IntegratorDescription integrator = scene.description.integrator;
    const double factor = integrator.escape_radius / IntegratorDescription().escape_radius / typical_speed(scene);
    for (double& step : integrator.default_step) step *= factor;
    if (!integrator.step_location) integrator.step *= factor;
    return integrator;
}

/// Restricts early capture by a black hole of mass M to rays that can no longer hit an object. The kernels capture an
/// inward ray that cannot return at r = 3M, that is, at |q| = 3M without spin and at |q| ≤ √10 M with spin. If a
/// surface lies within that radius, rays are captured only inside the innermost surface, or just above the horizon. If
/// `to_horizon` is true, all rays are integrated to just above the horizon. With spin, the surface on which rays are
/// captured is a spheroid.
void limit_capture(const Hole& hole, const SceneGeometry& geometry, bool to_horizon, RayLimits& limits) {
    const double greatest_capture_radius = std::sqrt(10.0) * hole.mass;
    const double innermost_surface = to_horizon ? 0 : geometry.distance_from_center(greatest_capture_radius);
    if (!(innermost_surface < greatest_capture_radius)) return;
    const double horizon = hole.mass + std::sqrt(std::max(0.0, hole.mass * hole.mass - hole.spin * hole.spin));
    const double equator = std::hypot(horizon, hole.spin);
    limits.capture_stretch = equator / horizon;
    limits.capture_radius = std::max((1 + 1e-3) * equator, (1 - 1e-4) * innermost_surface);
}

/// Returns the description of the scene in which a medium is the only space.
SceneDescription description_in_medium(const SceneDescription& scene, const MediumDescription& medium) {
    SceneDescription description = scene;
    description.space = medium.space;
    description.integrator = medium.integrator;
    description.media.clear();
    description.camera.velocity.reset();
    return description;
}

/// Returns everything that determines a geometry, as a text. Numbers in the text have all their digits.
std::string geometry_inputs(const SceneDescription& scene, std::uint32_t cells,
                            const std::optional<Spheroid>& reflected) {
    std::string inputs = print_surfaces(scene) + to_toml(scene.space.center) + ' ' +
                         to_toml(scene.integrator.escape_radius) + ' ' + std::to_string(cells) +
                         (scene.integrator.cull ? " cull" : "");
    if (reflected) inputs += " reflected " + to_toml(reflected->equator) + ' ' + to_toml(reflected->pole);
    return inputs;
}

/// Data that frames can share, and the text that determines it.
template <class Data>
struct Shared {
    std::shared_ptr<const Data> data;
    std::string inputs;
};

/// Returns the geometry of a space. Spaces with the same centre share it, except near spinning holes. `earlier` is the
/// same space in another frame, or null.
Shared<SceneGeometry> geometry_of(const Scene& scene, const Scene* surrounding, Purpose purpose, const Scene* earlier) {
    const std::optional<Spheroid> reflected = horizon_of_spinning_hole(scene.space);
    if (surrounding && surrounding->description.space.center == scene.description.space.center && !reflected &&
        !horizon_of_spinning_hole(surrounding->space))
        return {surrounding->geometry, ""};
    const std::uint32_t cells = clearance_cells(scene, purpose);
    const std::string inputs = geometry_inputs(scene.description, cells, reflected);
    if (earlier && earlier->geometry_inputs == inputs) return {earlier->geometry, inputs};
    return {std::make_shared<const SceneGeometry>(scene.description, cells, reflected,
                                                  earlier ? earlier->geometry.get() : nullptr),
            inputs};
}

/// Returns the paints of a picture or ray list. `earlier` is the scene of another frame, or null.
Shared<Paints> paints_of(const Scene& scene, Purpose purpose, const Scene* earlier) {
    const std::string inputs = print_skies(scene.description);
    if (earlier && earlier->geometry == scene.geometry && earlier->paint_inputs == inputs)
        return {earlier->paints, inputs};
    return {std::make_shared<const Paints>(scene.description, *scene.geometry, purpose == Purpose::picture,
                                           earlier ? earlier->paints.get() : nullptr),
            inputs};
}

/// Makes the scene of one space, without paints, sources and media. Lengths in the description are in units of `unit`.
/// `surrounding` is the scene that contains a medium, or null. Rays end at the boundary of their medium, so the escape
/// sphere of a medium contains all objects. `earlier` is the scene of the same space in another frame, or null.
std::shared_ptr<Scene> load_space(SceneDescription description, const Module& module, double unit,
                                  const Scene* surrounding, const Options& options, Purpose purpose,
                                  const Scene* earlier) {
    auto scene = std::make_shared<Scene>();
    scene->unit = unit;
    scene->description = std::move(description);
    SceneDescription& s = scene->description;
    const Double3 camera = subtract(s.camera.position, s.space.center);
    if (s.space.formula) {
        const RayFrequency frequency = ray_frequency(*s.space.formula, camera, purpose == Purpose::picture);
        s.space.formula->parsed.pt = frequency.pt;
        scene->form_remark = frequency.remark;
    }
    const bool for_comparison = options.for_comparison && !surrounding;
    scene->space = make_space(s.space, module, s.integrator.escape_radius, for_comparison);
    scene->straight = scene->space.is_straight();
    if (surrounding && scene->straight) s.space.center = surrounding->description.space.center;
    const Shared<SceneGeometry> geometry = geometry_of(*scene, surrounding, purpose, earlier);
    scene->geometry = geometry.data;
    scene->geometry_inputs = geometry.inputs;
    if (surrounding)
        s.integrator.escape_radius =
            std::max(s.integrator.escape_radius,
                     scene->geometry->distance_from_center(std::numeric_limits<double>::max()) +
                         scene->geometry->diagonal());
    if (s.space.formula) s.integrator = with_scaled_steps(*scene);
    scene->integrated = integrated_hamiltonian(s, scene->space, for_comparison);
    const bool to_horizon = purpose == Purpose::ray_list && options.observer != ObserverKind::falling;
    scene->limits = ray_limits(scene->space, *scene->geometry, s.integrator.escape_radius, to_horizon);
    return scene;
}

}  // namespace

RayLimits ray_limits(const Space& space, const SceneGeometry& geometry, double escape_radius, bool to_horizon) {
    const double throat = space.throat_radius();
    RayLimits limits;
    limits.escape_radius = throat > 0
                               ? 0.5 * (escape_radius + std::sqrt(escape_radius * escape_radius + 4 * throat * throat))
                               : escape_radius;
    limits.inner_escape_radius = throat > 0 ? throat * throat / limits.escape_radius : 0;
    limit_capture(space.hole(), geometry, to_horizon, limits);
    limits.chart_radius = chart_radius(space, geometry);
    return limits;
}

std::uint32_t Scene::integrated_hamiltonian() const {
    return integrated.is_of_space() ? space.hamiltonian : hamiltonian_index(module(), formula_name);
}

Catalogue catalogue(const std::string& isa) {
    const Module& module = load_module(isa);
    Catalogue c{module.hamiltonians, module.hamiltonian_count, module.integrators, module.integrator_count, {},
                module.refusal};
    for (const LayerInfo& layer : all_layers()) c.layers.push_back(layer.name);
    return c;
}

std::shared_ptr<const Scene> make_scene(SceneDescription description, const Options& options, Purpose purpose,
                                        const Scene* earlier) {
    const Module& module = load_module(options.isa);
    divide_by_material(description, earlier ? &earlier->description : nullptr);
    const double unit = length_unit(description);
    convert_lengths(description, module, unit);
    if (earlier && earlier->unit != unit) earlier = nullptr;
    std::shared_ptr<Scene> scene = load_space(std::move(description), module, unit, nullptr, options, purpose, earlier);
    const SceneDescription& s = scene->description;
    const Double3 camera = subtract(s.camera.position, s.space.center);
    const Shared<Paints> paints = paints_of(*scene, purpose, earlier);
    scene->paints = paints.data;
    scene->paint_inputs = paints.inputs;
    if (purpose == Purpose::picture && has_material(s, Material::diffuse))
        scene->lights = std::make_unique<const LightProposals>(s, *scene->geometry, *scene->paints);
    scene->sources = make_sources(scene->space, s, purpose == Purpose::picture);
    check_surfaces_at_horizon(scene->space, *scene->geometry, s.objects,
                              purpose == Purpose::picture ? camera.data() : nullptr, scene->unit);
    if (has_boundaries(s)) scene->regions = std::make_unique<const Regions>(s, *scene->geometry, unit);
    for (std::size_t i = 0; i < s.media.size(); ++i)
        scene->media.push_back(load_space(description_in_medium(s, s.media[i]), module, unit, scene.get(), options,
                                          Purpose::ray_list, earlier ? earlier->media[i].get() : nullptr));
    return scene;
}

bool has_rays_from_surfaces(const SceneDescription& scene) {
    return std::any_of(scene.objects.begin(), scene.objects.end(), sends_light_on);
}

double scene_size(const Scene& scene) {
    return scene.unit *
           (scene.geometry->kernel_view() ? scene.geometry->diagonal() : scene.description.integrator.escape_radius);
}

double typical_momentum(const Scene& scene) {
    const RayStart ray = ray_along_axis(scene.description, scene.space);
    const double momentum = std::hypot(ray.p[0], ray.p[1], ray.p[2]);
    return ray.failure == Failure::none && std::isfinite(momentum) && momentum > 0 ? momentum : 1;
}

double typical_speed(const Scene& scene) {
    const auto& formula = scene.description.space.formula;
    if (!formula) return 1;
    const RayStart ray = ray_along_axis(scene.description, scene.space);
    const double speed = ray.failure == Failure::none ? speed_of(*formula, ray) : 1;
    return std::isfinite(speed) && speed > 0 ? speed : 1;
}

double null_ray_sign(const Scene& scene) {
    const auto& formula = scene.description.space.formula;
    if (!formula) return scene.space.info().spacetime ? 1 : 0;
    const double pt = formula->parsed.pt;
    return formula->level == 0 && pt != 0 ? std::copysign(1.0, pt) : 0;
}

bool states_rescaling(const Scene& scene) {
    const auto& formula = scene.description.space.formula;
    return formula ? formula->parsed.rescale >= 0 : scene.description.integrator.rescaling && !scene.straight;
}

bool has_invalid_time_rescaling(const Scene& scene, const double (&q)[3]) {
    if (!states_rescaling(scene)) return false;
    const auto& formula = scene.description.space.formula;
    const auto& rescaling = scene.description.integrator.rescaling;
    const std::array<double, 7> variables{q[0], q[1], q[2]};
    return !((formula ? evaluate(formula->scope, formula->parsed.rescale, variables)
                      : evaluate(rescaling->scope, rescaling->node, variables)) > 0);
}

const char* key_that_ends_rays(const Scene& scene, const double (&q)[3]) {
    const auto& formula = scene.description.space.formula;
    if (!formula) return nullptr;
    if (value_of_bound(*formula, formula->parsed.domain, q) <= 0) return "space.domain";
    return value_of_bound(*formula, formula->parsed.capture, q) <= 0 ? "space.capture" : nullptr;
}

bool has_invalid_bounds(const Scene& scene, const double (&q)[3]) {
    const auto& formula = scene.description.space.formula;
    if (!formula || key_that_ends_rays(scene, q)) return false;
    const auto value = [&](std::int32_t node) { return value_of_bound(*formula, node, q); };
    return !(value(formula->parsed.domain) > 0 && value(formula->parsed.capture) > 0 &&
             value(formula->parsed.length_scale) > 0);
}

StepKind step_kind(const Scene& scene, std::uint32_t integrator, bool rescaled) {
    if (scene.module().integrators[integrator].angular) return StepKind::angle;
    return rescaled && scene.space.info().spacetime ? StepKind::number : StepKind::length;
}

const char* refusal_of(const Scene& scene, std::uint32_t integrator, bool rescaled) {
    using Source = IntegratedHamiltonian::Source;
    if (scene.integrated.source == Source::recorded_rescaled && !rescaled)
        return "the programs were recorded with time rescaling";
    if (scene.integrated.source == Source::recorded && rescaled)
        return "the programs were recorded without time rescaling";
    if (scene.integrated.has_programs())
        return scene.module().formula_refusal(scene.integrated_parameters(), integrator);
    return scene.module().refusal(scene.space.hamiltonian, integrator, rescaled);
}

const char* supported_angular_method(const Scene& scene, bool separated) {
    for (std::uint32_t i = 0; i < scene.module().integrator_count; ++i) {
        const IntegratorInfo& info = scene.module().integrators[i];
        if (info.angular && info.separated == separated && !refusal_of(scene, i, false)) return info.name;
    }
    return nullptr;
}

std::string why_failed(const Scene& scene, Precision precision, Failure failure) {
    const auto& formula = scene.description.space.formula;
    const bool is_spacetime = formula ? formula->parsed.pt != 0 : scene.space.info().spacetime;
    if (failure == Failure::momentum_diverges && !is_spacetime)
        return "the momentum grows without bound, as where the speed of the rays falls to zero; end the rays before, "
               "by space.domain, space.capture or a smaller integrator.escape_radius";
    std::string reason = describe(failure);
    if (failure == Failure::no_momentum && formula) {
        const std::string cause = cause_of_missing_momentum(*formula, subtract(scene.description.camera.position,
                                                                               scene.description.space.center));
        return cause.empty() ? reason : reason + ": " + cause;
    }
    if (failure == Failure::steps_vanish && formula && formula->parsed.length_scale >= 0)
        reason += "; or space.length_scale approaches 0 there";
    if (failure != Failure::not_finite) return reason;
    if (precision == Precision::float32) reason += "; --precision double has a larger range";
    if (states_rescaling(scene)) reason += "; or integrator.rescale is not greater than 0 at a point of the path";
    if (formula && (formula->parsed.domain >= 0 || formula->parsed.capture >= 0))
        reason += "; or space.domain or space.capture is NaN there";
    if (formula && formula->parsed.length_scale >= 0) reason += "; or space.length_scale is not greater than 0 there";
    return reason;
}

std::string why_failed(const Scene& scene, Precision precision, const RayEnd& end) {
    const std::string reason = why_failed(scene, precision, end.failure);
    const auto& formula = scene.description.space.formula;
    if (end.failure != Failure::hamiltonian_jumps || !formula) return reason;
    const auto jump = jump_at(*formula, end);
    if (!jump) return reason;
    std::ostringstream text;
    text << reason << ". With the momentum of the ray, H is " << jump->before << " before the jump and " << jump->behind
         << " behind it. If both are almost equal, H is continuous, but the layer in which it changes is thinner than "
            "a step; make it thicker, or use --precision double";
    return text.str();
}

}  // namespace kagero
