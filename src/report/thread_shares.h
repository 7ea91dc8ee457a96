/// How threads spent a run.
#pragma once

#include "render/render.h"
#include "report/json.h"

namespace kagero {

/// Where the threads were while tiles were worked on, as shares.
struct ThreadShares {
    double busy, idle_at_end;
};
ThreadShares shares_of(const RunReport& report, const ThreadTime& time);

/// Per thread, the shares of the time in which tiles were worked on: busy, and idle at the end because none were left.
Json threads_json(const RunReport& report);

}  // namespace kagero
