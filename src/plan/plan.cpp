#include "plan/plan.h"

#include "appearance/redshift.h"
#include "error.h"
#include "plan/names.h"

#include <chrono>
#include <cmath>

namespace kagero {
namespace {

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
        remarks.push_back(std::string("space.") + table + "." + name + " has no effect: no formula uses it" +
                          (near.empty() ? "" : "; did you mean " + near + "?"));
    });
}

/// A float counts so far.
constexpr std::uint32_t most_float_steps = 1u << 24;

/// Settings without effect and objects that are not seen: the user may have meant something else.
std::vector<std::string> remarks_of(const Scene& scene, const RunConfig& run, Purpose purpose) {
    const SceneDescription& description = scene.description;
    const IntegratorDescription& integrator = description.integrator;
    const IntegratorInfo& method = scene.module().integrators[run.method.integrator];
    std::vector<std::string> remarks = scene.geometry->remarks();
    const auto say = [&](const std::string& remark) { remarks.push_back(remark); };
    const bool picture = purpose == Purpose::picture, bounded = integrator.max_pixel_error > 0;
    if (description.space.formula) remark_on_names(*description.space.formula, remarks);
    if (bounded && !picture)
        say(std::string("integrator.max_pixel_error has no effect on single rays: they are traced by ") + method.name +
            " as it is");
    if (integrator.max_steps > most_float_steps && run.kernel->precision == Precision::float32)
        say("integrator.max_steps: in float rays end after " + std::to_string(most_float_steps) + " steps");
    if (integrator.tolerance_place && !scene.straight && !method.adaptive && !(picture && bounded))
        say(std::string("integrator.tolerance has no effect: ") + method.name + " takes steps of one length");
    if (picture && description.camera.fov_place && description.camera.type != CameraType::perspective)
        say("camera.fov has no effect: the camera is " + name_of(description.camera.type));
    for (std::size_t i = 0; i < description.objects.size(); ++i) {
        const ObjectDescription& object = description.objects[i];
        if (!scene.geometry->comes_within(static_cast<std::uint32_t>(i), scene.limits.escape_radius))
            say("object." + object.name + " lies beyond integrator.escape_radius, where rays end: it is not seen");
        if (object.shape == Shape::disk && description.space.formula)
            say("object." + object.name +
                ": its matter stands still, as nobody knows how it orbits in the space of a formula");
    }
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
    if (purpose == Purpose::picture) plan.view = place_camera(scene, options);
    if (plan.view.has_camera && plan.run.kernel->precision == Precision::float32 &&
        camera_needs_double(scene, plan.view))
        throw InputError(scene.description.camera.position_place,
                         position_of_camera(scene) + ": " + describe(Failure::needs_double));
    plan.decisions = decisions_of(scene, plan.view, plan.run);
    plan.remarks = remarks_of(scene, plan.run, purpose);
    plan.scene = std::move(loaded);
    return plan;
}

}  // namespace kagero
