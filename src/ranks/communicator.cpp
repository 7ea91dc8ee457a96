#include "ranks/communicator.h"

#include "error.h"
#include "modules/module_files.h"

namespace kagero {

std::unique_ptr<Communicator> join_ranks() {
    const std::string path = module_file("kagero-mpi.so");
    if (path.empty())
        throw InputError(
            "--mpi: this kagero has no MPI module, kagero-mpi.so in lib/kagero beside the program; install MPI (the "
            "Debian package mpi-default-dev) and build again, or divide the picture with --part I/N");
    const CommunicatorModule* module =
        reinterpret_cast<CommunicatorFunction>(open_module(path, "kagero_communicator"))();
    if (module->abi != communicator_abi)
        throw RunError(path + " belongs to another version of kagero; build or install kagero again");
    std::unique_ptr<Communicator> communicator;
    const std::string reason = module->join(communicator);
    if (!reason.empty()) throw RunError("--mpi: MPI cannot be started: " + reason);
    return communicator;
}

}  // namespace kagero
