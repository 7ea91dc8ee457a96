/// The time that the threads of a run were busy and idle.
#pragma once

#include "render/render.h"
#include "report/json.h"

namespace kagero {

/// Shares of the time in which tiles were traced and shaded, without the prediction of tile costs; both in 0…1.
struct ThreadShares {
    double busy;         ///< Share in which the thread processed tiles.
    double idle_at_end;  ///< Share after the last tile of the thread, when no tiles were left.
};
/// Returns the shares of one thread of the run.
ThreadShares shares_of(const RunReport& report, const ThreadTime& time);

/// Returns an array with the number of tiles and the shares of each thread.
Json threads_json(const RunReport& report);

}  // namespace kagero
