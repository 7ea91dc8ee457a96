#include "library/scene_plans.h"

#include "accuracy/end_errors.h"
#include "error.h"
#include "frames/sub_frames.h"
#include "library/choices.h"
#include "plan/names.h"
#include "scene/value.h"
#include "tuning/resolve.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

/// Appends an option to the key of a plan. The length in front of the text makes keys of different options different.
void append_to_key(std::string& key, const std::string& text) { key += std::to_string(text.size()) + ':' + text; }

std::string key_of(const RunOptions& options, const std::string& kind) {
    std::string key;
    for (const std::string& text :
         {kind, options.isa, options.strategy, options.precision, std::to_string(options.threads)})
        append_to_key(key, text);
    return key;
}

std::string key_of(const RunOptions& options, const RayRequest& request) {
    std::string key = key_of(options, "rays");
    append_to_key(key, request.observer);
    append_to_key(key, request.bounces ? std::to_string(*request.bounces) : "");
    for (const std::string& column : request.columns) append_to_key(key, column);
    append_to_key(key, request.parameter ? to_toml(*request.parameter) : "");
    append_to_key(key, to_toml(request.every));
    append_to_key(key, std::string(request.energy_error ? "energy" : "") + (request.end_parameter ? "end" : ""));
    return key;
}

void request_columns_by_name(Options& options, const std::vector<std::string>& columns) {
    const std::vector<std::string>& names = integral_names();
    for (const std::string& column : columns) {
        if (std::find(names.begin(), names.end(), column) == names.end())
            throw InputError("columns: unknown value \"" + column + "\"; legal values: " + names[0] + ", " + names[1]);
        request_integral(options, column);
    }
}

Options options_of_rays(const RunOptions& requested, const RayRequest& request) {
    Options options = options_of(requested);
    options.energy_error = request.energy_error;
    options.parameter = request.end_parameter;
    request_columns_by_name(options, request.columns);
    if (!request.observer.empty()) options.observer = observer_named(request.observer);
    if (request.bounces.value_or(0) > max_ray_bounces)
        throw InputError("bounces: " + std::to_string(*request.bounces) + " is out of range; it must be from 0 to " +
                         std::to_string(max_ray_bounces));
    if (request.bounces.value_or(0) > 0) options.bounces = request.bounces;
    if (request.parameter && !(std::isfinite(*request.parameter) && *request.parameter > 0))
        throw InputError("parameter: " + to_toml(*request.parameter) +
                         " is not a finite number greater than 0, the value at the start of a ray");
    if (request.parameter && request.bounces)
        throw InputError("bounces and parameter exclude each other: each medium has its own ray parameter");
    if (!(std::isfinite(request.every) && request.every >= 0))
        throw InputError("every: " + to_toml(request.every) + " is not a finite number greater than 0");
    return options;
}

/// Returns the description of a scene whose rays follow the general path: with integrator.symmetry = "none", unless the
/// scene states a method that needs the orbit plane.
SceneDescription general_description_of(SceneSource source, const Options& options) {
    const SceneDescription stated = description_of(source, options, SceneUse::single_rays);
    source.overrides.insert(source.overrides.begin(), "integrator.symmetry=none");
    try {
        return description_of(source, options, SceneUse::single_rays);
    } catch (const InputError&) {  // The only possible reason is a method that excludes symmetry = "none".
        return stated;
    }
}

/// Returns the description for rays that end at a value of λ, the parameter of Hamilton's equations for H: without time
/// rescaling, on the general path.
SceneDescription limited_description_of(SceneSource source, const Options& options) {
    SceneDescription scene = general_description_of(source, options);
    if (scene.integrator.rescale == "auto") {
        source.overrides.emplace_back("integrator.rescale=none");
        scene = general_description_of(std::move(source), options);
    }
    if (scene.integrator.rescale == "none") return scene;
    throw InputError(
        "parameter: rays cannot end at a value of the ray parameter while integrator.rescale replaces it "
        "by another integration parameter; set integrator.rescale = \"none\"");
}

SceneSource with_text(SceneSource source) {
    if (!source.text) source.text = scene_text(source.file);
    return source;
}

}  // namespace

ScenePlans::ScenePlans(SceneSource source)
    : source_(with_text(std::move(source))), description_(description_of(source_, {}, SceneUse::single_rays)) {}

std::optional<ScenePlans::KeptPlan> ScenePlans::find(const std::string& key) const {
    const std::lock_guard lock(mutex_);
    const auto found = std::find_if(kept_.begin(), kept_.end(), [&](const KeptPlan& kept) { return kept.key == key; });
    if (found == kept_.end()) return {};
    std::rotate(found, found + 1, kept_.end());
    return kept_.back();
}

ScenePlans::KeptPlan ScenePlans::keep(KeptPlan plan) const {
    constexpr std::size_t max_plans = 4;
    const std::lock_guard lock(mutex_);
    if (kept_.size() == max_plans) kept_.erase(kept_.begin());
    kept_.push_back(plan);
    return plan;
}

/// Returns the plan of a picture, and those of its sub-frames if it has some.
ScenePlans::KeptPlan ScenePlans::kept_picture(const RunOptions& requested, const std::vector<std::string>& layers,
                                              const RunControl& control) const {
    std::string key = key_of(requested, "picture");
    for (const std::string& layer : layers) append_to_key(key, layer);
    if (const auto found = find(key)) return *found;
    Options options = options_of(requested);
    options.energy_error = true;  // written to the metadata of EXR files
    SceneSource source = source_;
    std::string list;
    for (const std::string& layer : layers) append_to_list(list, to_toml(layer));
    if (!layers.empty()) source.overrides.push_back("film.layers=[" + list + "]");
    SceneDescription scene = description_of(source, options);
    if (!has_sub_frames(scene)) {
        Plan plan = resolve(std::move(scene), options, Purpose::picture, control);
        return keep({key, std::make_shared<const Plan>(std::move(plan)), nullptr});
    }
    auto frames = std::make_shared<FramePlans>(std::move(scene), options, control);
    return keep({key, std::make_shared<const Plan>(frames->first()), frames});
}

std::shared_ptr<const Plan> ScenePlans::picture(const RunOptions& requested, const std::vector<std::string>& layers,
                                                const RunControl& control) const {
    return kept_picture(requested, layers, control).plan;
}

RenderedPicture ScenePlans::render(const RunOptions& requested, const std::vector<std::string>& layers,
                                   const RunControl& control) const {
    const KeptPlan kept = kept_picture(requested, layers, control);
    RenderedPicture picture{kept.plan, film_of(*kept.plan), {}};
    picture.report = kept.frames ? render_sub_frames(*kept.frames, *kept.plan, 0, *picture.film, control)
                                 : render_with_errors(*kept.plan, *picture.film, control);
    return picture;
}

std::shared_ptr<const Plan> ScenePlans::rays(const RunOptions& requested, const RayRequest& request) const {
    const std::string key = key_of(requested, request);
    if (const auto found = find(key)) return found->plan;
    const Options options = options_of_rays(requested, request);
    Plan plan = resolve(request.parameter ? limited_description_of(source_, options)
                                          : description_of(source_, options, SceneUse::single_rays),
                        options, Purpose::ray_list);
    if (request.parameter && plan.method().angular)
        throw InputError("parameter: rays cannot end at a value of the ray parameter, because integrator.method = \"" +
                         std::string(plan.method().name) +
                         "\" steps in an angle; choose a method other than orbit-* and mino-*");
    if (request.parameter) plan.run.parameter_limit = *request.parameter;
    plan.run.path_interval = request.every;
    return keep({key, std::make_shared<const Plan>(std::move(plan)), nullptr}).plan;
}

}  // namespace kagero
