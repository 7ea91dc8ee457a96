#include "cli/ranks/run_on_ranks.h"

#include "cli/verb.h"
#include "error.h"
#include "ranks/agreement.h"
#include "ranks/rank_link.h"

namespace kagero {
namespace {

/// Returns the arguments of a rank that prints nothing and writes nothing.
Arguments silent(Arguments arguments) {
    arguments.quiet = true;
    arguments.verbose = false;
    arguments.json.clear();
    return arguments;
}

/// Runs the verb on this rank. Throws AgreedFailure on all ranks if one of them fails.
int run_verb(const Arguments& arguments, const Terminal& terminal, const RankVerb& verb, Communicator& ranks) {
    RankFailure failure;
    int status = exit_failed;
    try {
        status = verb(arguments, terminal, ranks);
    } catch (const AgreedFailure&) {
        throw;
    } catch (const LostRank&) {
        throw;
    } catch (...) {
        failure = failure_in_flight();
    }
    agree(ranks, failure);
    return status;
}

/// Throws the exception on which the ranks agreed.
[[noreturn]] void rethrow(const RankFailure& failure) {
    if (failure.kind == RankFailure::Kind::wrong_input) throw InputError(failure.message);
    throw RunError(failure.message);
}

}  // namespace

void add_rank_options(CLI::App& verb, Arguments& arguments, const std::string& name) {
    add_flag(verb, "--mpi", arguments.mpi,
             "Divide the work among all processes that mpirun or srun has started, for example `mpirun -n 4 kagero " +
                 name +
                 " SCENE --mpi`. Process 0 writes all files. The result is the same for any number of processes, "
                 "apart from times");
    add_flag(verb, "--send-files", arguments.send_files,
             "With --mpi: send the textures and meshes of the scene to all processes. Default: each process reads "
             "them, which needs a shared file system");
}

void check_rank_combination(const Arguments& arguments) {
    if (arguments.send_files && !arguments.mpi)
        throw InputError("--send-files sends files to the processes of --mpi; add --mpi, or leave --send-files out");
    if (!arguments.mpi) return;
    if (!arguments.part.empty()) throw InputError("--part and --mpi both divide the picture; leave one of them out");
    if (!arguments.pixel.empty()) throw InputError("--pixel traces one ray, in one process; leave --mpi out");
}

int run_on_ranks(const Arguments& arguments, const Terminal& terminal, const RankVerb& verb) {
    std::unique_ptr<Communicator> ranks = join_ranks();
    const int rank = ranks->rank();
    const Arguments of_rank = rank == 0 ? arguments : silent(arguments);
    const Terminal terminal_of_rank(of_rank);
    // Only rank 0 reports the status of the run. The launcher ends all ranks when one of them reports a failure, and
    // would end rank 0 before it has printed the reason.
    try {
        const int status = run_verb(of_rank, terminal_of_rank, verb, *ranks);
        return rank == 0 ? status : exit_done;
    } catch (const AgreedFailure& failure) {
        ranks.reset();
        if (rank == 0) rethrow(failure.failure());
        return exit_done;
    } catch (const std::exception& error) {  // the other ranks may be in any state
        terminal.error(error.what());
        ranks->end_all_ranks(exit_failed);
        throw;
    }
}

void set_up_rank(Communicator& ranks, Options& options, const Terminal& terminal) {
    const RankSetup setup = agree_on_setup(ranks, options.isa, options.threads);
    options.isa = setup.isa;
    options.threads = setup.threads;
    if (!setup.remark.empty()) terminal.warning(setup.remark);
    terminal.detail(std::to_string(ranks.size()) + (ranks.size() == 1 ? " rank, " : " ranks, ") +
                    std::to_string(setup.threads) + " threads on rank 0");
}

}  // namespace kagero
