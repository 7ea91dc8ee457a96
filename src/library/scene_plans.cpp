#include "library/scene_plans.h"

#include "accuracy/end_errors.h"
#include "error.h"
#include "frames/sub_frames.h"
#include "library/choices.h"
#include "library/ray_list.h"
#include "plan/names.h"
#include "scene/value.h"
#include "tuning/resolve.h"

#include <algorithm>

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
        if (std::find(names.begin(), names.end(), column) == names.end()) {
            std::string legal;
            for (const std::string& name : names) append_to_list(legal, name);
            throw InputError("columns: unknown value \"" + column + "\"; legal values: " + legal);
        }
        request_integral(options, column);
    }
}

Options options_of_rays(const RunOptions& requested, const RayRequest& request) {
    Options options = options_of(requested);
    options.energy_error = request.energy_error;
    options.parameter = request.end_parameter;
    request_columns_by_name(options, request.columns);
    if (!request.observer.empty()) options.observer = observer_named(request.observer);
    options.bounces = request.bounces;
    options.parameter_limit = request.parameter;
    if (request.every != 0) options.path_interval = request.every;
    return options;
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
    check_ray_list(options, "");
    const ReadScene read = [&](const std::vector<std::string>& first, const std::vector<std::string>& last) {
        SceneSource source = source_;
        source.overrides.insert(source.overrides.begin(), first.begin(), first.end());
        source.overrides.insert(source.overrides.end(), last.begin(), last.end());
        return description_of(source, options, SceneUse::single_rays);
    };
    Plan plan = resolve_ray_list(ray_list_scene(read, options.parameter_limit.has_value()), options, "");
    return keep({key, std::make_shared<const Plan>(std::move(plan)), nullptr}).plan;
}

}  // namespace kagero
