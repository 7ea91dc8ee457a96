/// The statistics of the pictures that the viewer has delivered.
#pragma once

#include "report/json.h"
#include "view/picture_maker.h"

#include <chrono>
#include <deque>
#include <mutex>

namespace kagero {

/// Counts pictures. All functions may be called from several threads at once.
class Statistics {
public:
    using Clock = std::chrono::steady_clock;
    /// Counts a picture whose last byte was sent at this time.
    void add_delivered(const LivePicture& picture, double encode_seconds, Clock::time_point now);
    /// Returns the JSON of `GET /stats`. `fps` counts pictures of full size in the last two seconds, in pictures per
    /// second.
    Json json(Clock::time_point now) const;

private:
    struct Delivery {
        Clock::time_point time;
        bool is_full_size;
    };
    double rate(Clock::time_point now, bool only_full_size) const;

    mutable std::mutex mutex_;
    std::deque<Delivery> deliveries_;
    Json last_ = Json::object();  ///< Size, times and rates of the last picture.
};

}  // namespace kagero
