/// The definitions of the loop's entries; each value type is instantiated in one translation unit.
#pragma once

#include "kernels/trace/loop.h"
#include "kernels/trace/trace_entry.h"

#include <algorithm>
#include <optional>

namespace kagero {

/// Checks after every so many steps whether the job has been cancelled.
class CancelCheck {
public:
    explicit CancelCheck(const Job& job) : job_(job) {}
    bool operator()() { return job_.halted && ++steps_ % interval == 0 && job_.halted(job_.halted_user); }

private:
    static constexpr std::uint32_t interval = 64;
    const Job& job_;
    std::uint32_t steps_ = 0;
};

/// Traces a tile, packet by packet.
template <class V, class Events = AllEvents>
void trace_tile(const Task<V>& task, const Tile& tile, RayEnd* ends, Counters& counters) {
    RayQueue<lane_count<V>> queue(task.job, tile, ends);
    CancelCheck cancelled(task.job);
    while (!queue.empty()) {
        PacketTracer<V, Events> packet(task, counters);
        packet.start(queue);
        while (packet.goes_on()) {
            packet.step(queue);
            if (cancelled()) return;
        }
        packet.finish();
    }
}

/// The most rays of a gang.
inline constexpr int longest_gang = std::max({
#include "gangs.inc"
});

/// Traces a tile by gangs: several packets take their steps in turn until the longest ray of all has ended. That is a
/// vector of hundreds of lanes, a few registers at a time.
template <class V>
void trace_by_gangs(const Task<V>& task, const Tile& tile, RayEnd* ends, Counters& counters, int packets) {
    RayQueue<lane_count<V>> queue(task.job, tile, ends);
    CancelCheck cancelled(task.job);
    std::optional<PacketTracer<V>> gang[longest_gang / lane_count<V>];
    const auto end = gang + packets;
    while (!queue.empty()) {
        for (auto packet = gang; packet != end; ++packet) packet->emplace(task, counters), (*packet)->start(queue);
        while (std::any_of(gang, end, [](auto& packet) { return packet->goes_on(); })) {
            for (auto packet = gang; packet != end; ++packet)
                (*packet)->goes_on() ? (*packet)->step(queue) : (*packet)->idle();
            if (cancelled()) return;
        }
        for (auto packet = gang; packet != end; ++packet) (*packet)->finish();
    }
}

template <class V>
void trace_with(const SpaceKernel<V>& kernel, const Job& job, const Tile& tile, RayEnd* ends, Counters& counters) {
    KAGERO_ASSERT(job.step > 0 && job.escape_radius > 0 && job.max_steps > 0);
    KAGERO_ASSERT((job.camera != nullptr) != (job.rays != nullptr) && tile.x0 <= tile.x1 && tile.y0 <= tile.y1);
    trace_tile(Task<V>(job, kernel, is_straight(job.hamiltonian, job.parameters)), tile, ends, counters);
}

template <class V>
void trace_entry(const Job* job, const Tile* tile, RayEnd* ends, Counters* counters) {
    trace_with(space_of<V>(*job), *job, *tile, ends, *counters);
}
template <class V, int lanes>
void gang_entry(const Job* job, const Tile* tile, RayEnd* ends, Counters* counters) {
    // The list of kernels has no gang of one packet or less.
    if constexpr (lanes > lane_count<V>)
        trace_by_gangs(Task<V>(*job, space_of<V>(*job), is_straight(job->hamiltonian, job->parameters)), *tile, ends,
                       *counters, lanes / lane_count<V>);
}

}  // namespace kagero
