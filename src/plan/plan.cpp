#include "plan/plan.h"

#include "appearance/redshift.h"
#include "error.h"
#include "plan/names.h"
#include "plan/sampling.h"
#include "scene/value.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace kagero {
namespace {

/// Adds a remark for each entry of the tables `constants` and `let` that no formula uses; its name may be misspelt.
void remark_on_names(const FormulaDescription& formula, std::vector<std::string>& remarks) {
    std::vector<std::string> used;
    const auto for_each_name = [&](const auto& visit) {
        for (const auto& [name, value] : formula.constants)
            if (name != "pt") visit("constants", name);
        for (const auto& [name, text] : formula.helpers) visit("let", name);
    };
    for_each_name([&](const char*, const std::string& name) {
        if (formula.scope.used_names.contains(name)) used.push_back(name);
    });
    for_each_name([&](const char* table, const std::string& name) {
        if (formula.scope.used_names.contains(name)) return;
        const std::string near = near_match(name, used);
        remarks.push_back(formula.table + "." + table + "." + name + " has no effect: no formula uses it" +
                          (near.empty() ? "" : "; did you mean " + near + "?"));
    });
}

/// Adds remarks on the media of a scene: on those that no object uses, and on names that no formula uses.
void remark_on_media(const SceneDescription& scene, std::vector<std::string>& remarks) {
    for (std::uint32_t i = 1; i <= scene.media.size(); ++i) {
        const MediumDescription& medium = scene.media[i - 1];
        if (medium.space.formula) remark_on_names(*medium.space.formula, remarks);
        if (uses_medium(scene, i)) continue;
        remarks.push_back("medium." + medium.name +
                          " has no effect: no object states it as its interior or exterior; to use it, state material "
                          "= \"boundary\" and interior = " +
                          to_toml(medium.name) + " for an object");
    }
}

/// Returns true if the scene states the accuracy of the integration.
bool states_accuracy(const IntegratorDescription& integrator) {
    return integrator.method_location || integrator.step_location || integrator.tolerance_location;
}

/// Adds remarks on media whose errors are not part of the bound on the pixel error of a picture. Other media are traced
/// far more precisely than any such bound.
void remark_on_media_without_bound(const Scene& scene, std::vector<std::string>& remarks) {
    const SceneDescription& description = scene.description;
    if (states_accuracy(description.integrator) && !(description.integrator.max_pixel_error > 0)) return;
    for (std::size_t i = 0; i < description.media.size(); ++i)
        if (!scene.media[i]->straight && states_accuracy(description.media[i].integrator))
            remarks.push_back("the bound on the pixel error does not include medium." + description.media[i].name +
                              ", because the scene states the steps there; the layer position_error includes it");
}

/// Adds a remark if an open shutter blurs nothing.
void remark_on_shutter(const SceneDescription& scene, std::vector<std::string>& remarks) {
    if (!scene.animation || scene.animation->keys.empty())
        remarks.push_back("camera.shutter has no effect: the scene has no table [animation.set], so nothing moves");
    else if (scene.film.spp == 1)
        remarks.push_back(
            "camera.shutter blurs nothing with film.spp = 1: the picture shows the middle of the time during "
            "which the shutter is open; state film.spp, the number of moments that are averaged");
}

/// Greatest number of steps that float can count: it represents all whole numbers up to 2^24.
constexpr std::uint32_t max_float_steps = 1u << 24;

/// Returns true if a part of an object of the scene file lies within the escape radius.
bool comes_within(const Scene& scene, std::uint32_t scene_index) {
    const std::vector<ObjectDescription>& objects = scene.description.objects;
    for (std::uint32_t i = 0; i < objects.size(); ++i)
        if (objects[i].scene_index == scene_index && scene.geometry->comes_within(i, scene.limits.escape_radius))
            return true;
    return false;
}

/// Adds remarks on keys of [integrator] that have no effect.
void remark_on_integrator(const Scene& scene, const RunConfig& run, Purpose purpose,
                          std::vector<std::string>& remarks) {
    const IntegratorDescription& integrator = scene.description.integrator;
    const IntegratorInfo& method = scene.module().integrators[run.method.integrator];
    const bool is_picture = purpose == Purpose::picture, has_error_bound = integrator.max_pixel_error > 0;
    if (has_error_bound && !is_picture)
        remarks.push_back(std::string("integrator.max_pixel_error has no effect on single rays; they are traced by ") +
                          method.name + " with its stated or default step");
    if (integrator.max_steps > max_float_steps && run.kernel->precision == Precision::float32)
        remarks.push_back("integrator.max_steps = " + std::to_string(integrator.max_steps) +
                          " is more than float can count: rays end after " + std::to_string(max_float_steps) +
                          " steps; choose --precision double");
    if (integrator.tolerance_location && !scene.straight && !method.adaptive && !(is_picture && has_error_bound))
        remarks.push_back(std::string("integrator.tolerance has no effect: ") + method.name +
                          " takes steps of fixed length, which integrator.step sets");
    if (integrator.method_location && integrator.solver_tolerance > 0 && !method.implicit)
        remarks.push_back(std::string("integrator.solver_tolerance has no effect: ") + method.name +
                          " solves no implicit equations");
}

/// Adds remarks on keys of [camera] and [film] that have no effect on a picture, or not the intended one.
void remark_on_camera(const SceneDescription& scene, std::vector<std::string>& remarks) {
    const CameraDescription& camera = scene.camera;
    const std::vector<std::string>& layers = scene.film.layers;
    if (camera.fov_location && camera.type != CameraType::perspective)
        remarks.push_back("camera.fov has no effect: the camera is " + name_of(camera.type));
    if (camera.states_focus_distance && camera.aperture_radius == 0)
        remarks.push_back("camera.focus_distance has no effect: camera.aperture_radius is 0, so everything is sharp");
    if (camera.aperture_radius > 0 && scene.film.spp == 1)
        remarks.push_back(
            "with film.spp = 1, the lens of camera.aperture_radius makes noise and no smooth blur: each "
            "pixel has one ray, from a random point of the lens; state a greater film.spp");
    if (scene.film.spp == 1 && std::find(layers.begin(), layers.end(), "standard_error") != layers.end())
        remarks.push_back(
            "the layer standard_error is nan with film.spp = 1, because one ray has no spread; state a "
            "greater film.spp");
    if (camera.shutter > 0) remark_on_shutter(scene, remarks);
}

/// Adds a remark if a formula ends all rays of the camera where they start.
void remark_on_start(const Scene& scene, const View& view, std::vector<std::string>& remarks) {
    const char* const key = view.medium == 0 ? key_that_ends_rays(scene, view.camera.position) : nullptr;
    if (!key) return;
    remarks.push_back(std::string(key) + " is not greater than 0 at " + position_of_camera(scene) +
                      ", so that all rays end where they start; move the camera, or change the formula");
}

/// Adds remarks on objects that are not visible.
void remark_on_visibility(const Scene& scene, std::vector<std::string>& remarks) {
    const std::vector<ObjectDescription>& objects = scene.description.objects;
    for (std::size_t i = 0; i < objects.size(); ++i) {
        const bool is_first_part = i == 0 || objects[i].scene_index != objects[i - 1].scene_index;
        if (is_first_part && !comes_within(scene, objects[i].scene_index))
            remarks.push_back("object." + objects[i].name +
                              " is not visible: it lies beyond integrator.escape_radius = " +
                              plain_number(scene.description.integrator.escape_radius * scene.unit) +
                              ", where rays end; increase this radius to see it");
    }
}

/// Returns remarks about settings that have no effect and objects that are not visible.
std::vector<std::string> remarks_of(const Scene& scene, const View& view, const RunConfig& run, Purpose purpose) {
    const SceneDescription& description = scene.description;
    const bool is_picture = purpose == Purpose::picture;
    std::vector<std::string> remarks = scene.geometry->remarks();
    if (description.space.formula) remark_on_names(*description.space.formula, remarks);
    remark_on_media(description, remarks);
    if (is_picture) remark_on_media_without_bound(scene, remarks);
    if (!scene.form_remark.empty()) remarks.push_back(scene.form_remark);
    remark_on_integrator(scene, run, purpose, remarks);
    if (is_picture) remark_on_camera(description, remarks);
    if (is_picture) remark_on_start(scene, view, remarks);
    remark_on_visibility(scene, remarks);
    for (const std::string& remark : remarks_on_matter(scene.sources, description, scene.unit))
        remarks.push_back(remark);
    return remarks;
}

/// Returns the plan of a medium. Rays in media are traced like single rays: unless the scene states a method, step or
/// tolerance, with step control, as precisely as `trace` does.
Plan plan_of_medium(std::shared_ptr<const Scene> scene, Options options) {
    options.action = options.time = false;  // trace_paths requests the integrals
    Plan plan;
    plan.run = default_run(*scene, options, Purpose::ray_list);
    plan.scene = std::move(scene);
    return plan;
}

/// Returns the view of the scene's camera, in the coordinates of the medium around the camera.
View view_of_camera(const Scene& scene, const Options& options) {
    const std::uint32_t medium = check_camera_medium(scene.description, scene.regions.get(), scene.unit);
    View view = make_camera_view(medium == 0 ? scene : *scene.media[medium - 1], options);
    view.medium = medium;
    if (medium != 0) view.spacetime = null_ray_sign(scene) != 0;
    return view;
}

}  // namespace

Plan make_plan(SceneDescription description, const Options& options, Purpose purpose, const Scene* earlier) {
    const auto begin = std::chrono::steady_clock::now();
    Plan plan = make_plan(make_scene(std::move(description), options, purpose, earlier), options, purpose);
    plan.load_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return plan;
}

Plan make_plan(std::shared_ptr<const Scene> loaded, const Options& options, Purpose purpose) {
    const Scene& scene = *loaded;
    Plan plan;
    plan.run = default_run(scene, options, purpose);
    check_disks(scene.space, scene.description, scene.unit);
    for (const auto& medium : scene.media) plan.media.push_back(plan_of_medium(medium, options));
    const std::vector<ObjectDescription>& objects = scene.description.objects;
    if (purpose == Purpose::ray_list) plan.circling_run = circling_run_of(scene, plan.run);
    if (purpose == Purpose::ray_list) plan.run.max_bounces = options.bounces;
    else if (std::any_of(objects.begin(), objects.end(), sends_light_on))
        plan.run.max_bounces = scene.description.film.max_bounces;
    if (purpose == Purpose::picture) plan.view = view_of_camera(scene, options);
    if (plan.view.has_camera && plan.run.kernel->precision == Precision::float32 &&
        camera_needs_double(scene, plan.view))
        throw InputError(scene.description.camera.position_location,
                         position_of_camera(scene) + ": " + describe(Failure::needs_double));
    if (purpose == Purpose::picture && reason_for_full_sampling(scene, plan.view, plan.run).empty())
        plan.run.interpolation_bound = interpolation_bound_of(scene.description);
    plan.decisions = decisions_of(scene, plan.view, plan.run);
    for (std::size_t i = 0; i < plan.media.size(); ++i)
        plan.decisions.media.push_back(
            medium_decision(scene.description.media[i].name, *plan.media[i].scene, plan.media[i].run));
    plan.remarks = remarks_of(scene, plan.view, plan.run, purpose);
    if (purpose == Purpose::picture && scene.description.film.sampling == Sampling::adaptive &&
        !(plan.run.interpolation_bound > 0))
        plan.remarks.push_back("the picture is sampled in full: " +
                               reason_for_full_sampling(scene, plan.view, plan.run));
    if (plan.view.spacetime) {
        const std::string remark = check_sky_frame(scene.sources.skies, scene.limits.escape_radius, scene.unit);
        if (!remark.empty()) plan.remarks.push_back(remark);
    }
    plan.scene = std::move(loaded);
    return plan;
}

}  // namespace kagero
