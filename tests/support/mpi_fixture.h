/// Fixture for running the program on several ranks with the mpirun of this machine.
#pragma once

#include "tests/support/hole_scene.h"

namespace kagero::test {

/// Skips the tests if the MPI module is not built.
class MpiTest : public HoleTest {
protected:
    void SetUp() override {
        HoleTest::SetUp();
        if (std::string(KAGERO_MPIEXEC).empty())
            GTEST_SKIP() << "the MPI module is not built (.ci/setup test installs mpi-default-dev), or has sanitizers";
    }
    /// Runs `kagero ARGUMENTS --mpi` on `count` ranks.
    Outcome on_ranks(int count, const std::string& arguments) const {
        return run_program(KAGERO_MPIEXEC, "-n " + std::to_string(count) + " " + command(arguments, ""), variables());
    }
    /// Begins `kagero ARGUMENTS --mpi` on three ranks, and sends a signal to rank `rank` when the file `journal` has
    /// more than `bytes` bytes.
    Outcome signal_rank(int rank, const std::string& signal, const std::string& arguments, const std::string& journal,
                        int bytes) const {
        std::ofstream(output_ / "rank.sh")
            << "echo $$ > '" << output_.string() << "'/pid-${OMPI_COMM_WORLD_RANK:-$PMI_RANK}\nexec \"$@\"\n";
        std::ofstream(output_ / "signal.sh")
            << "\"$@\" & launcher=$!\nwhile kill -0 $launcher 2>/dev/null; do\n  [ $(stat -c %s '" << journal
            << "' 2>/dev/null || echo 0) -gt " << bytes << " ] && break; sleep 0.01\ndone\nkill -" << signal
            << " $(cat '" << output_.string() << "'/pid-" << rank << ")\nwait $launcher\n";
        return run_program("sh",
                           "'" + (output_ / "signal.sh").string() + "' '" + KAGERO_MPIEXEC + "' -n 3 " +
                               command(arguments, "sh '" + (output_ / "rank.sh").string() + "'"),
                           variables());
    }

private:
    /// Variables for tests in a container: Open MPI runs as root, and starts more ranks than there are processors.
    /// Other implementations ignore them.
    static std::string variables() {
        return "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1 "
               "OMPI_MCA_btl_vader_single_copy_mechanism=none ";
    }
    /// Returns the command of a rank. It begins with `rank_command`.
    static std::string command(const std::string& arguments, const std::string& rank_command) {
        return rank_command + " '" + KAGERO_BINARY + "' " + arguments + " --mpi";
    }
};

}  // namespace kagero::test
