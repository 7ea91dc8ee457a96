#include "plan/plan.h"

#include "appearance/redshift.h"
#include "error.h"
#include "plan/names.h"

#include <chrono>
#include <cmath>

namespace kagero {
namespace {

/// Adds a remark for each entry of [space.constants] and [space.let] that no formula uses; its name may be misspelt.
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
        remarks.push_back(std::string("space.") + table + "." + name + " has no effect: no formula uses it" +
                          (near.empty() ? "" : "; did you mean " + near + "?"));
    });
}

/// Greatest number of steps that float can count: it represents all whole numbers up to 2^24.
constexpr std::uint32_t max_float_steps = 1u << 24;

/// Returns remarks about settings that have no effect and objects that are not visible.
std::vector<std::string> remarks_of(const Scene& scene, const RunConfig& run, Purpose purpose) {
    const SceneDescription& description = scene.description;
    const IntegratorDescription& integrator = description.integrator;
    const IntegratorInfo& method = scene.module().integrators[run.method.integrator];
    std::vector<std::string> remarks = scene.geometry->remarks();
    const auto add_remark = [&](const std::string& remark) { remarks.push_back(remark); };
    const bool is_picture = purpose == Purpose::picture, has_error_bound = integrator.max_pixel_error > 0;
    if (description.space.formula) remark_on_names(*description.space.formula, remarks);
    if (!scene.form_remark.empty()) remarks.push_back(scene.form_remark);
    if (has_error_bound && !is_picture)
        add_remark(std::string("integrator.max_pixel_error has no effect on single rays; they are traced by ") +
                   method.name + " with its stated or default step");
    if (integrator.max_steps > max_float_steps && run.kernel->precision == Precision::float32)
        add_remark("integrator.max_steps = " + std::to_string(integrator.max_steps) +
                   " is more than float can count: rays end after " + std::to_string(max_float_steps) +
                   " steps; choose --precision double");
    if (integrator.tolerance_location && !scene.straight && !method.adaptive && !(is_picture && has_error_bound))
        add_remark(std::string("integrator.tolerance has no effect: ") + method.name +
                   " takes steps of fixed length, which integrator.step sets");
    if (is_picture && description.camera.fov_location && description.camera.type != CameraType::perspective)
        add_remark("camera.fov has no effect: the camera is " + name_of(description.camera.type));
    for (std::size_t i = 0; i < description.objects.size(); ++i) {
        const ObjectDescription& object = description.objects[i];
        if (!scene.geometry->comes_within(static_cast<std::uint32_t>(i), scene.limits.escape_radius))
            add_remark("object." + object.name + " is not visible: it lies beyond integrator.escape_radius = " +
                       plain_number(integrator.escape_radius * scene.unit) +
                       ", where rays end; increase this radius to see it");
    }
    for (const std::string& remark : remarks_on_matter(scene.sources, description, scene.unit)) add_remark(remark);
    return remarks;
}

}  // namespace

Plan make_plan(SceneDescription description, const Options& options, Purpose purpose) {
    const auto begin = std::chrono::steady_clock::now();
    Plan plan = make_plan(make_scene(std::move(description), options, purpose), options, purpose);
    plan.load_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return plan;
}

Plan make_plan(std::shared_ptr<const Scene> loaded, const Options& options, Purpose purpose) {
    const Scene& scene = *loaded;
    Plan plan;
    plan.run = default_run(scene, options, purpose);
    check_disks(scene.space, scene.description, scene.unit);
    if (purpose == Purpose::picture) plan.view = make_camera_view(scene, options);
    if (plan.view.has_camera && plan.run.kernel->precision == Precision::float32 &&
        camera_needs_double(scene, plan.view))
        throw InputError(scene.description.camera.position_location,
                         position_of_camera(scene) + ": " + describe(Failure::needs_double));
    plan.decisions = decisions_of(scene, plan.view, plan.run);
    plan.remarks = remarks_of(scene, plan.run, purpose);
    if (plan.view.spacetime) {
        const std::string remark = check_sky_frame(scene.sources.skies, scene.limits.escape_radius, scene.unit);
        if (!remark.empty()) plan.remarks.push_back(remark);
    }
    plan.scene = std::move(loaded);
    return plan;
}

}  // namespace kagero
