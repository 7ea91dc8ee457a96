#include <kagero/rays.h>

#include "error.h"
#include "library/choices.h"
#include "plan/names.h"
#include "rays/start_rays.h"
#include "render/trace.h"
#include "tuning/resolve.h"

#include <algorithm>

namespace kagero {
namespace {

TracedRay traced_ray(const Plan& plan, const RayEnd& end) {
    TracedRay ray;
    ray.status = name_of(end.status);
    if (end.status == Status::hit) ray.object = plan.description().objects.at(end.surface).name;
    ray.position = {end.q[0], end.q[1], end.q[2]};
    ray.direction = {end.v[0], end.v[1], end.v[2]};
    ray.momentum = {end.p[0], end.p[1], end.p[2]};
    ray.pt = end.pt;
    ray.parameter = end.parameter;
    ray.steps = end.steps;
    ray.gradients = end.gradients;
    ray.energy_error = end.energy_error;
    if (end.status == Status::failed) ray.reason = why_failed(*plan.scene, plan.run.kernel->precision, end.failure);
    if (plan.run.outputs & output_action) ray.action = end.action;
    if (plan.run.outputs & output_time) ray.time = end.time;
    return ray;
}

void request_columns_by_name(Options& options, const std::vector<std::string>& columns) {
    const std::vector<std::string>& names = integral_names();
    for (const std::string& column : columns) {
        if (std::find(names.begin(), names.end(), column) == names.end())
            throw InputError("columns: unknown value \"" + column + "\"; legal values: " + names[0] + ", " + names[1]);
        request_integral(options, column);
    }
}

}  // namespace

std::vector<TracedRay> trace_rays(const SceneSource& source, const std::vector<Ray>& rays, const std::string& observer,
                                  const RunOptions& requested, const std::vector<std::string>& columns) {
    Options options = options_of(requested);
    options.energy_error = options.parameter = true;
    request_columns_by_name(options, columns);
    if (!observer.empty()) options.observer = observer_named(observer);
    const Plan plan = resolve(description_of(source, options, SceneUse::single_rays), options, Purpose::ray_list);
    std::vector<RayInput> inputs;
    for (const Ray& ray : rays) inputs.push_back({ray.position, ray.direction});
    RunControl control;
    control.progress = requested.progress;
    control.stop = requested.stop;
    std::vector<RayEnd> ends;
    trace(plan, start_rays(plan, inputs, options.observer), ends, control);
    std::vector<TracedRay> traced;
    for (const RayEnd& end : ends) traced.push_back(traced_ray(plan, end));
    return traced;
}

}  // namespace kagero
