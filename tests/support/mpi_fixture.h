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
    /// The files of a run that is interrupted.
    struct Files {
        std::string output, journal;
    };

    /// Begins `kagero ARGUMENTS --mpi` on three ranks, and sends a signal to rank `rank` when the journal has `growth`
    /// bytes more than before. If the run has ended before the signal, begins again, at most ten times.
    Outcome signal_rank(int rank, const std::string& signal, const std::string& arguments, const Files& files,
                        int growth) const {
        std::ofstream(output_ / "rank.sh")
            << "echo $$ > '" << output_.string() << "'/pid-${OMPI_COMM_WORLD_RANK:-$PMI_RANK}\nexec \"$@\"\n";
        std::ofstream(output_ / "signal.sh")
            << "size() { stat -c %s '" << files.journal << "' 2>/dev/null || echo 0; }\nend=$(($(size) + " << growth
            << "))\n\"$@\" & launcher=$!\nwhile [ $(size) -lt $end ] && kill -0 $launcher 2>/dev/null; do sleep 0.01; "
               "done\nkill -"
            << signal << " $(cat '" << output_.string() << "'/pid-" << rank << ")\nwait $launcher\n";
        Outcome outcome{};
        for (int attempt = 0; attempt < 10 && outcome.status == 0; ++attempt) {
            std::filesystem::remove_all(directory_ / files.output);
            outcome = run_program("sh",
                                  "'" + (output_ / "signal.sh").string() + "' '" + KAGERO_MPIEXEC + "' -n 3 " +
                                      command(arguments, "sh '" + (output_ / "rank.sh").string() + "'"),
                                  variables());
        }
        return outcome;
    }

private:
    /// Variables for tests in a container: Open MPI runs as root, and starts more ranks than there are processors.
    /// Other implementations ignore them.
    static std::string variables() {
        return "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1 "
               "OMPI_MCA_btl_vader_single_copy_mechanism=none KAGERO_JOURNAL_INTERVAL=0.01 ";
    }
    /// Returns the command of a rank. It begins with `rank_command`.
    static std::string command(const std::string& arguments, const std::string& rank_command) {
        return rank_command + " '" + KAGERO_BINARY + "' " + arguments + " --mpi";
    }
};

}  // namespace kagero::test
