#include "ranks/agreement.h"

#include "error.h"
#include "modules/modules.h"
#include "parts/bytes.h"
#include "parts/identity.h"

#include <sched.h>

#include <algorithm>
#include <new>
#include <thread>

namespace kagero {
namespace {

/// The part of a rank's environment on which its setup depends.
struct RankMachine {
    std::string host, isas;  ///< Instruction sets, best first, each followed by a comma.
    std::string processors;  ///< The set of processors that the rank may use, as bytes.
};

RankMachine machine_of(const Communicator& ranks, const std::string& stated_isa) {
    RankMachine machine{ranks.host(), {}, {}};
    if (stated_isa == "auto")
        for (const std::string& isa : find_isa_names("all")) machine.isas += isa + ",";
    else machine.isas = stated_isa + ",";
    cpu_set_t allowed;
    // The call fails beyond 1024 processors. All ranks of the machine then count as sharing all its processors.
    if (sched_getaffinity(0, sizeof allowed, &allowed) == 0)
        machine.processors.assign(reinterpret_cast<const char*>(&allowed), sizeof allowed);
    return machine;
}

/// Collective: returns the machines of all ranks, on every rank.
std::vector<RankMachine> all_machines(Communicator& ranks, const RankMachine& own) {
    ByteWriter writer;
    writer.put_text(own.host);
    writer.put_text(own.isas);
    writer.put_text(own.processors);
    ByteWriter all;
    for (const std::string& machine : ranks.gather(writer.bytes)) all.put_raw(machine.data(), machine.size());
    ranks.broadcast(all.bytes);
    ByteReader reader(all.bytes);
    std::vector<RankMachine> machines(static_cast<std::size_t>(ranks.size()));
    for (RankMachine& machine : machines) {
        machine.host = reader.get_text();
        machine.isas = reader.get_text();
        machine.processors = reader.get_text();
    }
    return machines;
}

/// Returns true if a machine's list contains the instruction set.
bool supports(const RankMachine& machine, const std::string& isa) {
    return ("," + machine.isas).find("," + isa + ",") != std::string::npos;
}

std::string best_of(const RankMachine& machine) { return machine.isas.substr(0, machine.isas.find(',')); }

/// Returns the first instruction set of the first rank that all ranks support; "" if there is none.
std::string common_isa(const std::vector<RankMachine>& machines) {
    std::string left = machines.front().isas;
    while (!left.empty()) {
        const std::string isa = left.substr(0, left.find(','));
        if (std::all_of(machines.begin(), machines.end(), [&](const auto& machine) { return supports(machine, isa); }))
            return isa;
        left.erase(0, isa.size() + 1);
    }
    return "";
}

/// Returns a list such as "avx2 on rank 0 (host a), sse2 on rank 1 (host b)" with the first rank of each kind.
std::string best_isas(const std::vector<RankMachine>& machines) {
    std::string list;
    std::vector<std::string> listed;
    for (std::size_t rank = 0; rank < machines.size(); ++rank) {
        const std::string isa = best_of(machines[rank]);
        if (std::find(listed.begin(), listed.end(), isa) != listed.end()) continue;
        listed.push_back(isa);
        append_to_list(list, isa + " on rank " + std::to_string(rank) + " (host " + machines[rank].host + ")");
    }
    return list;
}

/// Returns the number of processors of a rank, divided by the number of ranks that may use the same ones.
unsigned threads_of(const std::vector<RankMachine>& machines, const RankMachine& own) {
    unsigned processors = std::thread::hardware_concurrency(), sharing = 0;
    if (own.processors.size() == sizeof(cpu_set_t)) {
        cpu_set_t allowed;
        std::memcpy(&allowed, own.processors.data(), sizeof allowed);
        processors = static_cast<unsigned>(CPU_COUNT(&allowed));
    }
    for (const RankMachine& machine : machines)
        sharing += machine.host == own.host && machine.processors == own.processors;
    return std::max(1u, processors / std::max(1u, sharing));
}

std::string name_of_rank(int rank, const std::string& host) {
    return "rank " + std::to_string(rank) + " on host " + host;
}

}  // namespace

RankFailure failure_in_flight() {
    try {
        throw;
    } catch (const InputError& error) {
        return {RankFailure::Kind::wrong_input, error.what()};
    } catch (const std::bad_alloc&) {
        return {RankFailure::Kind::failed, "not enough memory"};
    } catch (const std::exception& error) {
        return {RankFailure::Kind::failed, error.what()};
    }
}

void agree(Communicator& ranks, const RankFailure& own) {
    const bool failed = own.kind != RankFailure::Kind::none;
    std::string text;
    if (failed) {
        const std::string name = ranks.rank() == 0 ? "" : name_of_rank(ranks.rank(), ranks.host()) + ": ";
        text = std::string(1, static_cast<char>(own.kind)) + name + own.message;
    }
    std::string verdict;
    for (const std::string& each : ranks.gather(text))
        if (verdict.empty()) verdict = each;
    ranks.broadcast(verdict);
    if (!verdict.empty()) throw AgreedFailure({static_cast<RankFailure::Kind>(verdict.front()), verdict.substr(1)});
}

RankSetup agree_on_setup(Communicator& ranks, const std::string& stated_isa, unsigned stated_threads) {
    const RankMachine own = machine_of(ranks, stated_isa);
    agree(ranks);
    const std::vector<RankMachine> machines = all_machines(ranks, own);
    RankSetup setup{common_isa(machines), stated_threads ? stated_threads : threads_of(machines, own), ""};
    const std::string isas = best_isas(machines);
    if (setup.isa.empty())
        throw InputError("--mpi: the ranks have no instruction set in common: " + isas +
                         "; state the same --isa for all ranks, or use other machines");
    const auto differs = [&](const RankMachine& machine) { return best_of(machine) != setup.isa; };
    if (std::any_of(machines.begin(), machines.end(), differs))
        setup.remark = "the ranks have different instruction sets: " + isas + "; all of them use " + setup.isa;
    return setup;
}

void agree_on_properties(Communicator& ranks, const std::vector<std::pair<std::string, std::string>>& own) {
    agree(ranks);
    ByteWriter writer;
    if (ranks.rank() == 0)
        for (const auto& [name, value] : own) {
            writer.put_text(name);
            writer.put_text(value);
        }
    ranks.broadcast(writer.bytes);
    Properties expected;
    for (ByteReader reader(writer.bytes); !reader.empty();) {
        std::string name = reader.get_text();
        expected.emplace_back(std::move(name), reader.get_text());
    }
    const std::string difference = describe_difference(expected, "rank 0", own, "this rank");
    if (difference.empty()) return agree(ranks);
    agree(ranks, {RankFailure::Kind::wrong_input,
                  "its picture would not be that of rank 0: " + difference +
                      "; all ranks need the same program and the same files, from a shared file system or by "
                      "--send-files"});
}

}  // namespace kagero
