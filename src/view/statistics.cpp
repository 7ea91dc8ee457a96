#include "view/statistics.h"

namespace kagero {
namespace {

constexpr std::chrono::seconds rate_window{2};
constexpr std::size_t max_deliveries = 1000;

}  // namespace

void Statistics::add_delivered(const LivePicture& picture, double encode_seconds, Clock::time_point now) {
    const double seconds = picture.trace_seconds + picture.shade_seconds,
                 pixels = double(picture.width) * picture.height;
    Json last{{"width", picture.width},
              {"height", picture.height},
              {"ms",
               {{"plan", 1000 * picture.plan_seconds},
                {"trace", 1000 * picture.trace_seconds},
                {"shade", 1000 * picture.shade_seconds},
                {"encode", 1000 * encode_seconds}}},
              {"mrays_per_s", seconds > 0 ? double(picture.rays) / seconds * 1e-6 : 0},
              {"traced_share", double(picture.rays) / (pixels * picture.plan->description().film.spp)}};
    const std::lock_guard lock(mutex_);
    deliveries_.push_back({now, picture.reduction == 1});
    if (deliveries_.size() > max_deliveries) deliveries_.pop_front();
    last_ = std::move(last);
}

double Statistics::rate(Clock::time_point now, bool only_full_size) const {
    std::size_t count = 0;
    Clock::time_point first = now, last = now;
    for (const Delivery& delivery : deliveries_) {
        if (now - delivery.time > rate_window || (only_full_size && !delivery.is_full_size)) continue;
        if (count++ == 0) first = delivery.time;
        last = delivery.time;
    }
    const double seconds = std::chrono::duration<double>(last - first).count();
    return count > 1 && seconds > 0 ? double(count - 1) / seconds : 0;
}

Json Statistics::json(Clock::time_point now) const {
    const std::lock_guard lock(mutex_);
    Json json{{"fps", rate(now, true)}};
    json.update(last_);
    json["fps_of_all_sizes"] = rate(now, false);
    return json;
}

}  // namespace kagero
