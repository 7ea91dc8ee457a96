/// Messages between the processes of one run, which are called ranks. The MPI module (ranks/mpi/module.cpp) implements
/// them. It is a separate shared library, so that a run without --mpi neither needs nor loads MPI.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace kagero {

/// A message from another rank.
struct RankMessage {
    int from;  ///< Number of the rank that sent it.
    int kind;  ///< A number >= 0 that sender and receiver agree on.
    std::string bytes;
};

/// The ranks of a run as seen from one of them. Only one thread at a time may call its functions. Functions that wait
/// let the processor sleep, because a rank may share it with another rank that renders.
class Communicator {
public:
    virtual ~Communicator() = default;

    int rank() const { return rank_; }                 ///< Number of this rank, from 0.
    int size() const { return size_; }                 ///< Number of ranks.
    const std::string& host() const { return host_; }  ///< Name of the machine of this rank.

    /// Begins to send a message, and returns at once.
    virtual void send(int to, int kind, std::string bytes) = 0;
    /// Returns the next message that has arrived; nullopt if there is none. Also continues the transfer of messages.
    virtual std::optional<RankMessage> receive() = 0;
    /// Returns the number of own messages whose transfer has not ended. Also continues it.
    virtual std::size_t unsent() = 0;
    /// Collective: replaces the bytes of every rank by those of rank 0.
    virtual void broadcast(std::string& bytes) = 0;
    /// Collective: returns the bytes of all ranks on rank 0, and an empty list on the others.
    virtual std::vector<std::string> gather(const std::string& bytes) = 0;
    /// Ends all ranks at once, with an exit status. Used if a rank is lost, because collective functions would wait for
    /// it.
    virtual void end_all_ranks(int status) = 0;

protected:
    int rank_ = 0, size_ = 1;
    std::string host_;
};

/// The functions of the MPI module.
struct CommunicatorModule {
    std::uint32_t abi;  ///< The value of communicator_abi with which the module was compiled.
    /// Joins the ranks of the launcher. Returns "" on success, otherwise the reason for the failure.
    std::string (*join)(std::unique_ptr<Communicator>& communicator);
};

/// Version of this interface. It changes with every change of the types in this file.
inline constexpr std::uint32_t communicator_abi = 1;
/// Type of the function `kagero_communicator`, which the module exports.
using CommunicatorFunction = const CommunicatorModule* (*)();

/// Loads the MPI module and joins the ranks that mpirun or srun has started. A process that was started without them is
/// the only rank. Throws InputError if this build has no MPI module, and RunError if MPI cannot be started.
std::unique_ptr<Communicator> join_ranks();

}  // namespace kagero
