#include "cli/resolve.h"

namespace kagero {

Plan resolve_watched(SceneDescription scene, const Options& options, const Terminal& terminal, double time_limit) {
    constexpr double long_wait = 1;  // seconds
    ProgressLine line(terminal, " of the pilot");
    const Progress progress = [&](double done, double seconds) { if (seconds > long_wait) line.show(done, seconds); };
    Plan plan = resolve(std::move(scene), options, Purpose::picture, {progress, time_limit});
    line.clear();
    for (const std::string& remark : plan.remarks) terminal.warning(remark);
    return plan;
}

}  // namespace kagero
