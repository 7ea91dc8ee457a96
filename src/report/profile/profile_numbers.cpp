#include "report/profile/profile_numbers.h"

namespace kagero {

double seconds_per_predicted(const Profile& profile) {
    double measured = 0, predicted = 0;
    for (const TileRecord& tile : profile.recording.tiles) {
        measured += tile.processor_time;
        predicted += tile.predicted;
    }
    return ratio(measured, predicted);
}

std::vector<std::pair<std::string, double>> stages_of(const Profile& profile, double write_seconds) {
    const StageTimes& s = profile.stages;
    return {{"predict", s.predict}, {"list rays", s.list}, {"integrate", s.integrate}, {"query", s.query},
            {"refine", s.refine},   {"shade", s.shade},    {"write", write_seconds}};
}

double tracing_seconds(const Profile& profile) {
    return profile.stages.integrate + profile.stages.query + profile.stages.refine;
}

}  // namespace kagero
