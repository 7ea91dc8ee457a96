/// The work of the ranks of --mpi other than rank 0.
#pragma once

#include "cli/arguments.h"
#include "ranks/communicator.h"

namespace kagero {

/// Renders tiles or frames for rank 0 until the run ends. `time_limit` is that of the run, in seconds. The result is
/// not used, because rank 0 determines the exit status.
int work_for_root(const Arguments& arguments, Options options, double time_limit, Communicator& ranks);

}  // namespace kagero
