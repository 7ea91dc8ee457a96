#include "frames/frame_plans.h"

#include "scene/load/load.h"

#include <algorithm>
#include <chrono>

namespace kagero {

FramePlans::FramePlans(SceneDescription scene, const Options& options, const RunControl& trial_control)
    : scene_(std::move(scene)), options_(options) {
    if (has_changing_frames(scene_)) {
        choice_ = choose_for_animation(scene_, options_, trial_control);
        latest_ = choice_->scene;
        first_ = plan(0);
    } else {
        first_ = resolve(scene_, options_, Purpose::picture, trial_control);
    }
}

Plan FramePlans::sub_frame(double frame, std::uint32_t sample) {
    const double moment = (sample + 0.5) / scene_.film.spp;
    return plan_at(frame + scene_.camera.shutter * moment, sample);
}

Plan FramePlans::plan_at(double frame, std::optional<std::uint32_t> sample) {
    if (!choice_) return first_;
    const auto begin = std::chrono::steady_clock::now();
    std::shared_ptr<const Scene> earlier;
    {
        const std::lock_guard lock(latest_mutex_);
        earlier = latest_;
    }
    Plan plan = with_choice(plan_of_frame(scene_, frame, options_, earlier.get(), sample), *choice_);
    plan.load_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    const std::lock_guard lock(latest_mutex_);
    latest_ = plan.scene;
    return plan;
}

void check_frames(const SceneDescription& scene, const Catalogue& catalogue, const FrameRange& range) {
    if (!scene.animation || scene.animation->keys.empty()) return;
    const std::uint32_t count = range.count(), checked = std::min(count, max_checked_frames);
    for (std::uint32_t i = 0; i < checked; ++i) {
        const double frame =
            range.frame(static_cast<std::uint32_t>(std::uint64_t(i) * (count - 1) / std::max(1u, checked - 1)));
        const SceneDescription loaded = load_frame(scene, catalogue, frame);
        // While the shutter is open, the last sub-frame is the one farthest from the frame.
        const double last_moment = loaded.camera.shutter * (loaded.film.spp - 0.5) / loaded.film.spp;
        if (last_moment > 0) load_frame(scene, catalogue, frame + last_moment);
    }
}

}  // namespace kagero
