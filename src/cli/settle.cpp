#include "cli/settle.h"

#include "tuning/autotune.h"

namespace kagero {

void settle_watched(Plan& plan, const Terminal& terminal, double time_limit) {
    constexpr double long_wait = 1;  // seconds
    {
        ProgressLine line(terminal, " of the pilot");
        settle(plan, [&](double done, double seconds) { if (seconds > long_wait) line.show(done, seconds); }, time_limit);
    }
    for (const std::string& remark : plan.remarks) terminal.warning(remark);
}

}  // namespace kagero
