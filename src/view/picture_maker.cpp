#include "view/picture_maker.h"

#include "accuracy/end_errors.h"
#include "error.h"
#include "report/run_json.h"
#include "report/warnings.h"
#include "scene/load/load.h"
#include "scene/sky_only.h"
#include "tuning/resolve.h"
#include "tuning/step_bound.h"
#include "view/sampled_error.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

namespace kagero {
namespace {

using Seconds = std::chrono::duration<double>;
using std::chrono::steady_clock;

/// Time for a moving picture that is made in full size, and for one in a reduced size.
constexpr double full_size_seconds = 0.11, reduced_seconds = 0.05;
/// Time after which pictures remain incomplete.
constexpr double max_moving_seconds = 5, max_still_seconds = 300;
constexpr std::uint32_t max_reduction = 8;

/// Returns the keys and values of a state that `selects` accepts, as one text.
template <class Selects>
std::string text_of_keys(const ViewState& state, const Selects& selects) {
    std::string text;
    for (const auto& [key, value] : state.keys)
        if (selects(key)) text += key + '=' + value + '\n';
    return text;
}
std::string keys_of_rays(const ViewState& state) {
    return text_of_keys(state, [](const std::string& key) { return !keeps_rays(key); });
}
/// Returns the keys that determine the light of a picture, before its conversion for the display.
std::string keys_of_light(const ViewState& state) {
    return text_of_keys(state, [](const std::string& key) { return key != "film.exposure" && key != "film.tone"; }) +
           state.layer + ' ' + std::to_string(state.width) + 'x' + std::to_string(state.height) + ' ' +
           std::to_string(state.quality == Quality::fine ? state.spp : 1);
}

/// Returns everything that determines a plan.
std::string all_keys(const ViewState& state) {
    return keys_of_light(state) + text_of_keys(state, [](const std::string&) { return true; });
}

/// Returns the description with the values of frame 0, because a page shows one moment.
SceneDescription description_of_moment(const ViewScene& scene, const ViewState& state) {
    SceneDescription description = description_of(scene, state);
    description.animation.reset();
    return description;
}

/// Returns the choices that trial rays made for a plan, for other plans.
AnimationChoice choice_of(const Plan& tuned) {
    AnimationChoice choice;
    choice.frames = {0};
    if (tuned.method_trial) {
        choice.method = tuned.run.method;
        choice.step = tuned.method().adaptive ? tuned.run.tolerance : stated_step(*tuned.scene, tuned.run);
        choice.value_weight = tuned.run.value_weight;
        choice.trial = *tuned.method_trial;
    }
    choice.use_float = tuned.run.kernel->precision == Precision::float32;
    if (!choice.use_float) choice.reason_for_double = "the last whole picture needed double";
    return choice;
}

}  // namespace

ViewScene load_view_scene(const std::string& file, std::vector<Override> overrides, const Options& options) {
    ViewScene scene{file, scene_text(file), std::move(overrides), options, {}};
    scene.description = load_scene_text(scene.text, scene.file, scene.overrides, catalogue(options.isa));
    const FilmDescription& film = scene.description.film;
    if (std::max(film.width, film.height) > max_view_edge || std::uint64_t{film.width} * film.height > max_view_pixels)
        throw InputError("film.size = [" + std::to_string(film.width) + ", " + std::to_string(film.height) +
                         "] is too large for the viewer, which shows at most " + std::to_string(max_view_edge) +
                         " pixels along an edge and " + std::to_string(max_view_pixels) +
                         " in all; state a smaller --size");
    return scene;
}

SceneDescription description_of(const ViewScene& scene, const ViewState& state) {
    std::vector<Override> overrides = scene.overrides;
    for (Override& each : state.overrides()) overrides.push_back(std::move(each));
    return load_scene_text(scene.text, scene.file, overrides, catalogue(scene.options.isa));
}

std::shared_ptr<const Plan> PictureMaker::kept_plan(const std::string& keys) const {
    for (const KeptPlan& kept : kept_plans_)
        if (kept.keys == keys) return kept.plan;
    return nullptr;
}

std::shared_ptr<const Plan> PictureMaker::full_plan(const ViewState& state, const std::atomic<bool>& stop) {
    const std::string keys = all_keys(state);
    if (auto kept = kept_plan(keys)) return tuned_ = kept;
    RunControl control;
    control.stop = &stop;
    const Scene* earlier = tuned_ ? tuned_->scene.get() : nullptr;
    Plan plan = make_plan(description_of_moment(scene_, state), scene_.options, Purpose::picture, earlier);
    ViewState with_one_ray = state;
    with_one_ray.quality = Quality::full;
    // Further rays per pixel are traced as the first one, without another trial.
    const auto of_one_ray = kept_plan(all_keys(with_one_ray));
    plan = of_one_ray ? with_choice(choose_step_bound(std::move(plan), scene_.options, Purpose::picture, control),
                                    choice_of(*of_one_ray), control)
                      : tune(std::move(plan), scene_.options, Purpose::picture, control);
    tuned_ = std::make_shared<const Plan>(std::move(plan));
    constexpr std::size_t max_plans = 4;
    if (kept_plans_.size() == max_plans) kept_plans_.erase(kept_plans_.begin());
    kept_plans_.push_back({keys, tuned_});
    return tuned_;
}

Plan PictureMaker::moving_plan(const ViewState& state, LivePicture& picture, const std::atomic<bool>& stop) {
    const std::shared_ptr<const Plan> earlier = latest_ ? latest_ : tuned_;
    SceneDescription description = description_of_moment(scene_, state);
    description.film.sampling = Sampling::adaptive;
    Plan plan = make_plan(std::move(description), scene_.options, Purpose::picture, earlier->scene.get());
    const std::string rays = keys_of_rays(state);
    if (latest_ && latest_rays_ == rays) {
        const double interpolation_bound = plan.run.interpolation_bound;
        plan.run = latest_->run;
        plan.run.interpolation_bound = interpolation_bound;
        plan.method_trial = latest_->method_trial;
        picture.reuse = "method and step";
    } else {
        RunControl control;
        control.stop = &stop;
        plan = choose_step_bound(std::move(plan), scene_.options, Purpose::picture, control);
        plan = with_choice(std::move(plan), choice_of(*tuned_), control);
        picture.reuse = "method of the last whole picture";
    }
    latest_ = std::make_shared<const Plan>(plan);
    latest_rays_ = rays;
    return plan;
}

void PictureMaker::choose_reduction(ViewState& state) {
    const double pixels = double(state.width) * state.height;
    const auto takes = [&](std::uint32_t r) { return seconds_per_pixel_ * pixels / (double(r) * r); };
    const auto least_for = [&](double seconds) {
        std::uint32_t r = 1;
        while (r < max_reduction && takes(r) > seconds) ++r;
        return r;
    };
    const std::uint32_t wanted = takes(1) <= full_size_seconds ? 1 : std::max(2u, least_for(reduced_seconds));
    // A change costs time, because the clearance grid depends on the size. Small differences are therefore ignored.
    const bool is_too_slow = takes(reduction_) > (reduction_ == 1 ? full_size_seconds : 1.5 * reduced_seconds),
               is_too_coarse = wanted + 1 < reduction_ || (wanted == 1 && reduction_ > 1);
    if (is_too_slow || is_too_coarse) reduction_ = wanted;
    state.width = std::max(min_view_edge, state.width / reduction_);
    state.height = std::max(min_view_edge, state.height / reduction_);
}

void PictureMaker::draw_from_map(const ViewState& state, LivePicture& picture) {
    const std::string rays = keys_of_rays(state);
    const bool keeps_map = map_ && map_rays_ == rays;
    if (!keeps_map) map_ = new_sky_map(*picture.plan);
    map_rays_ = rays;
    MapPicture drawn = picture_from_map(*picture.plan, *map_);
    picture.rgb = std::move(drawn.rgb);
    picture.rays = drawn.traced;
    picture.trace_seconds = drawn.trace_seconds;
    picture.shade_seconds = drawn.shade_seconds;
    picture.interpolation_p99 = drawn.p99_error;
    picture.interpolation_max = drawn.max_error;
    const bool is_family = std::holds_alternative<OrbitFamily>(*map_);
    const std::string name = is_family ? "family of orbits" : "map of directions";
    picture.reuse += keeps_map ? ", ends of rays from the " + name : ", a new " + name;
}

void PictureMaker::render_film(LivePicture& picture, double seconds, const std::atomic<bool>& stop) {
    RunControl control;
    Recording recording;
    control.stop = &stop;
    control.recording = &recording;
    control.time_limit = seconds;
    Film film = film_of(*picture.plan);
    const RunReport report = render_with_errors(*picture.plan, film, control);
    if (stop) throw Interrupted();
    double tracing = 0, all = 0;
    for (const TileRecord& tile : recording.tiles) {
        tracing += tile.traced - tile.begin;
        all += std::max(tile.end, tile.traced) - tile.begin;
    }
    picture.trace_seconds = all > 0 ? report.seconds * tracing / all : report.seconds;
    picture.shade_seconds = report.seconds - picture.trace_seconds;
    picture.rays = report.rays;
    if (report.out_of_time)
        picture.remarks.push_back("the picture is not complete: it took more than " + plain_number(seconds) +
                                  " seconds");
    for (const Warning& warning : warnings_of(*picture.plan, report)) picture.remarks.push_back(warning.text);
    picture.metadata = picture_metadata(*picture.plan, report);
    picture.film = std::make_shared<const Film>(std::move(film));
    if (report.interpolated_pixels > 0) {
        picture.interpolation_p99 = report.interpolation_error.p99;
        picture.interpolation_max = report.interpolation_error.max;
    }
    const double pixels = double(picture.film->width()) * double(picture.film->height());
    if (pixels > 1000) seconds_per_pixel_ = report.seconds / pixels;
}

LivePicture PictureMaker::make_moving(ViewState state, const std::atomic<bool>& stop) {
    LivePicture picture;
    const auto begin = steady_clock::now();
    if (!tuned_) full_plan(state, stop);
    const bool from_map = state.layer == "color" && shows_only_sky(scene_.description);
    if (!from_map) {
        choose_reduction(state);
        picture.reduction = reduction_;
    }
    picture.plan = std::make_shared<const Plan>(moving_plan(state, picture, stop));
    picture.plan_seconds = Seconds(steady_clock::now() - begin).count();
    if (from_map) draw_from_map(state, picture);
    else render_film(picture, max_moving_seconds, stop);
    return picture;
}

LivePicture PictureMaker::make_full(const ViewState& state, const std::atomic<bool>& stop) {
    LivePicture picture;
    const auto begin = steady_clock::now();
    const std::string light = keys_of_light(state);
    if (last_full_.film && last_full_light_ == light) {
        picture = last_full_;
        Film film = *picture.film;
        film.set_tone(description_of_moment(scene_, state).film.tone);
        picture.film = std::make_shared<const Film>(std::move(film));
        picture.rays = 0;
        picture.trace_seconds = picture.shade_seconds = 0;
        picture.reuse = "the light of the last picture";
    } else {
        picture.plan = full_plan(state, stop);
        picture.plan_seconds = Seconds(steady_clock::now() - begin).count();
        picture.remarks = picture.plan->remarks;
        for (const Warning& warning : warnings_of_trial(*picture.plan)) picture.remarks.push_back(warning.text);
        render_film(picture, max_still_seconds, stop);
        last_full_ = picture;
        last_full_light_ = light;
    }
    return picture;
}

LivePicture PictureMaker::make_first(ViewState state, const std::atomic<bool>& stop) {
    constexpr std::uint32_t reduction = 4;
    state.width = std::max(min_view_edge, state.width / reduction);
    state.height = std::max(min_view_edge, state.height / reduction);
    LivePicture picture;
    const auto begin = steady_clock::now();
    Plan plan = make_plan(description_of_moment(scene_, state), scene_.options);
    plan = choose_step_bound(std::move(plan), scene_.options, Purpose::picture, {.stop = &stop});
    picture.plan = std::make_shared<const Plan>(std::move(plan));
    picture.plan_seconds = Seconds(steady_clock::now() - begin).count();
    picture.reduction = reduction;
    render_film(picture, max_moving_seconds, stop);
    return picture;
}

LivePicture PictureMaker::make(const ViewState& state, const std::atomic<bool>& stop) {
    const bool is_first = !std::exchange(has_made_picture_, true);
    LivePicture picture = state.quality != Quality::moving ? make_full(state, stop)
                          : is_first                       ? make_first(state, stop)
                                                           : make_moving(state, stop);
    if (picture.plan->description().film.spp == 1) sampled_error_ = sampled_error(*picture.plan);
    picture.integration_error = sampled_error_;
    picture.width = picture.plan->description().film.width;
    picture.height = picture.plan->description().film.height;
    return picture;
}

}  // namespace kagero
