#include <kagero/scene.h>

#include "library/choices.h"
#include "library/picture_content.h"
#include "library/ray_arrays.h"
#include "library/scene_plans.h"
#include "plan/names.h"
#include "render/trace.h"
#include "report/csv/write_rays.h"
#include "report/explanation.h"

namespace kagero {
namespace {

RunControl control_of(const RunOptions& options) {
    RunControl control;
    control.progress = options.progress;
    control.stop = options.stop;
    return control;
}

TracedRay traced_ray(const Plan& plan, const RayEnd& end, const PathState& path) {
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
    ray.reason = reason_of(plan, end);
    if (plan.run.outputs & output_action) ray.action = end.action;
    if (plan.run.outputs & output_time) ray.time = end.time;
    ray.bounces = path.bounces;
    ray.medium = name_of_medium(plan.description(), path.medium);
    ray.weight = mean_weight(path);
    return ray;
}

}  // namespace

const SceneSource& LoadedScene::source() const { return plans_->source(); }

LoadedScene LoadedScene::override(const std::vector<std::string>& overrides) const {
    SceneSource source = plans_->source();
    source.overrides.insert(source.overrides.end(), overrides.begin(), overrides.end());
    return load(source);
}

Picture LoadedScene::render(const RunOptions& options, const std::vector<std::string>& layers) const {
    const RunControl control = control_of(options);
    RenderedPicture picture = plans_->render(options, layers, control);
    RunChoices choices = run_choices_of(*picture.plan);
    return Picture(
        std::unique_ptr<Picture::Content>(new Picture::Content{std::move(picture.plan), std::move(*picture.film),
                                                               std::move(picture.report), std::move(choices)}));
}

std::vector<TracedRay> LoadedScene::trace(const std::vector<Ray>& rays, const TraceOptions& request,
                                          const RunOptions& options) const {
    RayRequest ray_request;
    ray_request.observer = request.observer;
    ray_request.bounces = request.bounces;
    ray_request.columns = request.columns;
    const std::shared_ptr<const Plan> plan = plans_->rays(options, ray_request);
    std::vector<RayInput> inputs;
    for (const Ray& ray : rays) inputs.push_back({ray.position, ray.direction});
    std::optional<ObserverKind> observer;
    if (!request.observer.empty()) observer = observer_named(request.observer);
    std::vector<RayEnd> ends;
    std::vector<PathState> paths;
    kagero::trace(*plan, start_rays(*plan, inputs, observer), ends, control_of(options), &paths);
    std::vector<TracedRay> traced;
    for (std::size_t i = 0; i < ends.size(); ++i) traced.push_back(traced_ray(*plan, ends[i], paths[i]));
    return traced;
}

std::string LoadedScene::explain(const RunOptions& options) const {
    return explanation_text(*plans_->picture(options, {}, control_of(options)));
}

LoadedScene load(const SceneSource& source) { return LoadedScene(std::make_shared<const ScenePlans>(source)); }

}  // namespace kagero
