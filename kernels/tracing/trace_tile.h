/// The definitions of the loop's entries; each value type is instantiated in one translation unit.
#pragma once

#include "kernels/tracing/loop.h"
#include "kernels/tracing/trace_entry.h"

#include <algorithm>
#include <optional>

namespace kagero {

/// Asks a job after every so many steps whether it is to be given up.
class Halting {
public:
    explicit Halting(const Job& job) : job_(job) {}
    bool operator()() { return job_.halted && ++steps_ % asked_every == 0 && job_.halted(job_.halted_user); }

private:
    static constexpr std::uint32_t asked_every = 64;
    const Job& job_;
    std::uint32_t steps_ = 0;
};

/// Traces a tile, packet by packet, or by gangs: packets that take their steps in turn, so that all wait for the longest ray of them. That
/// is a vector of hundreds of lanes, done a few registers at a time.
template <int packets = 1, class V>
void trace_tile(const Task<V>& task, const Tile& tile, RayEnd* ends, Counters& counters) {
    RayQueue<lane_count<V>> queue(task.job, tile, ends);
    Halting halted(task.job);
    if constexpr (packets == 1) {
        while (!queue.empty()) {
            PacketTracer<V> packet(task, counters);
            packet.start(queue);
            while (packet.goes_on()) {
                packet.step(queue);
                if (halted()) return;
            }
            packet.finish();
        }
    } else {
        std::optional<PacketTracer<V>> gang[packets];
        while (!queue.empty()) {
            for (auto& packet : gang) packet.emplace(task, counters), packet->start(queue);
            while (std::any_of(gang, gang + packets, [](auto& packet) { return packet->goes_on(); })) {
                for (auto& packet : gang) packet->goes_on() ? packet->step(queue) : packet->idle();
                if (halted()) return;
            }
            for (auto& packet : gang) packet->finish();
        }
    }
}

template <class V>
void trace_with(const SpaceKernel<V>& kernel, const Job& job, const Tile& tile, RayEnd* ends, Counters& counters) {
    trace_tile(Task<V>(job, kernel, is_straight(job.hamiltonian, job.parameters)), tile, ends, counters);
}

template <int packets, class V>
void trace_job(const Job& job, const Tile& tile, RayEnd* ends, Counters& counters) {
    const Task<V> task(job, space_of<V>(job), is_straight(job.hamiltonian, job.parameters));
    trace_tile<packets>(task, tile, ends, counters);
}
template <class V>
void trace_entry(const Job* job, const Tile* tile, RayEnd* ends, Counters* counters) {
    trace_job<1, V>(*job, *tile, ends, *counters);
}
template <class V, int lanes>
void gang_entry(const Job* job, const Tile* tile, RayEnd* ends, Counters* counters) {
    // A gang of one packet, or of less, is none: no list has it.
    if constexpr (lanes > lane_count<V>) trace_job<lanes / lane_count<V>, V>(*job, *tile, ends, *counters);
}

}  // namespace kagero
