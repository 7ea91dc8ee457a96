// Source of the format: "Trace Event Format", Google, 2016. Times of complete events ("X") are in microseconds. Nested
// events must lie within the enclosing event.
#include "report/profile/profile_trace.h"

#include "report/json.h"
#include "report/profile/profile_numbers.h"

#include <cmath>

namespace kagero {
namespace {

/// Rounds to whole microseconds, so that rounding cannot move the end of a nested event past that of the enclosing one.
long long microseconds(double seconds) { return std::llround(1e6 * seconds); }

Json event(const std::string& name, unsigned thread, double begin, double end, Json details = Json::object()) {
    const long long begin_us = microseconds(begin), end_us = microseconds(end);
    return {{"name", name},
            {"cat", "kagero"},
            {"ph", "X"},
            {"pid", 1},
            {"tid", thread},
            {"ts", begin_us},
            {"dur", end_us - begin_us},
            {"args", std::move(details)}};
}

Json thread_name(unsigned thread) {
    return {{"name", "thread_name"},
            {"ph", "M"},
            {"pid", 1},
            {"tid", thread},
            {"args", {{"name", "thread " + std::to_string(thread)}}}};
}

/// Returns the milliseconds of integration, queries and refinement while a tile was traced. Empty if ticks were not
/// counted in this tile.
Json stages_of(const TileRecord& t) {
    if (!t.has_tick_counts) return Json::object();
    const double per_tick = ratio(t.traced - t.listed, double(t.ticks));
    const double query = per_tick * double(t.counters.query_ticks),
                 refine = per_tick * double(t.counters.refinement_ticks);
    return {{"integrate_ms", 1e3 * (t.traced - t.listed - query - refine)},
            {"query_ms", 1e3 * query},
            {"refine_ms", 1e3 * refine}};
}

/// Adds the event of a tile and the nested events of its stages. `shift` is the duration of the prediction of costs in
/// seconds; the times of tiles are counted from its end. `unit` is the number of seconds per unit of predicted cost.
void add_tile(Json& events, const TileRecord& t, double shift, double unit) {
    events.push_back(
        event("tile " + std::to_string(t.tile.x0) + "," + std::to_string(t.tile.y0), t.thread, shift + t.begin,
              shift + t.end,
              {{"predicted_ms", 1e3 * unit * t.predicted},
               {"measured_ms", 1e3 * t.processor_time},
               {"gradients", t.counters.gradients},
               {"queries", t.counters.queries},
               {"lane_occupancy", ratio(double(t.counters.active_lane_steps), double(t.counters.issued_lane_steps))}}));
    if (t.listed > t.begin + 1e-6) events.push_back(event("list rays", t.thread, shift + t.begin, shift + t.listed));
    events.push_back(event("trace", t.thread, shift + t.listed, shift + t.traced, stages_of(t)));
    events.push_back(event("shade", t.thread, shift + t.traced, shift + t.end));
}

}  // namespace

std::string profile_trace(const Plan& plan, const Profile& profile, double write_seconds) {
    const RunReport& report = profile.report;
    const double shift = report.predict_seconds, unit = seconds_per_predicted(profile);
    Json events = Json::array();
    for (unsigned i = 0; i < report.threads.size(); ++i) events.push_back(thread_name(i));
    if (report.schedule == Schedule::predicted) events.push_back(event("predict", 0, 0, report.predict_seconds));
    for (const TileRecord& tile : profile.recording.tiles) add_tile(events, tile, shift, unit);
    events.push_back(event("write", 0, report.seconds, report.seconds + write_seconds));
    const Json trace{{"displayTimeUnit", "ms"},
                     {"otherData", {{"scene", plan.description().path}, {"version", KAGERO_VERSION}}},
                     {"traceEvents", std::move(events)}};
    return trace.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace kagero
