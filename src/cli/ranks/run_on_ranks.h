/// Runs of a verb on all ranks: --mpi.
#pragma once

#include "cli/terminal.h"
#include "ranks/communicator.h"

#include <functional>

namespace kagero {

/// Adds --mpi and --send-files. `name` is that of the verb.
void add_rank_options(CLI::App& verb, Arguments& arguments, const std::string& name);

/// Throws InputError for options that cannot be combined with --mpi, or that need it.
void check_rank_combination(const Arguments& arguments);

/// A verb as it runs on one rank.
using RankVerb = std::function<int(const Arguments&, const Terminal&, Communicator&)>;

/// Joins the ranks, and calls the verb on each of them. Only rank 0 prints messages; the arguments of the others are
/// those of --quiet. If a rank fails, all ranks end, and the exception is thrown on rank 0. Returns the exit status of
/// rank 0 on all ranks.
int run_on_ranks(const Arguments& arguments, const Terminal& terminal, const RankVerb& verb);

/// Collective: sets the instruction set and the number of threads of this rank, see agree_on_setup.
void set_up_rank(Communicator& ranks, Options& options, const Terminal& terminal);

}  // namespace kagero
