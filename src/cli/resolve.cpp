#include "cli/resolve.h"

namespace kagero {

Plan resolve_with_progress(SceneDescription scene, const Options& options, const Terminal& terminal) {
    constexpr double delay = 1;  // seconds before progress is shown
    ProgressLine line(terminal, " of the trial rays");
    const Progress progress = [&](double done, double seconds) {
        if (seconds > delay) line.show(done, seconds);
    };
    Plan plan = resolve(std::move(scene), options, Purpose::picture, progress);
    line.clear();
    for (const std::string& remark : plan.remarks) terminal.warning(remark);
    return plan;
}

}  // namespace kagero
