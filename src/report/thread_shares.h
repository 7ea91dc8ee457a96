/// The shares of time in which the threads of a run were busy and idle.
#pragma once

#include "render/render.h"
#include "report/json.h"

namespace kagero {

/// Shares of the run time of one thread, from 0 to 1. The run time does not include the prediction of tile costs.
struct ThreadShares {
    double busy;         ///< Share in which the thread processed tiles.
    double idle_at_end;  ///< Share from the end of the thread's last tile to the end of the run.
};
/// Returns the shares of the thread whose times are `time`.
ThreadShares shares_of(const RunReport& report, const ThreadTime& time);

/// Returns an array with the number of tiles and the shares of each thread.
Json threads_json(const RunReport& report);

}  // namespace kagero
