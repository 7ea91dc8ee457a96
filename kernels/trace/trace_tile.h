/// Definitions of the entry functions of the tracing loop. Each value type is instantiated in one translation unit.
#pragma once

#include "kernels/trace/loop.h"
#include "kernels/trace/trace_entry.h"

#include <algorithm>
#include <optional>

namespace kagero {

/// Function object that returns true if the job has been cancelled. It calls Job::cancelled once in every `interval`
/// calls and returns false otherwise.
class CancelCheck {
public:
    explicit CancelCheck(const Job& job) : job_(job) {}
    bool operator()() { return job_.cancelled && ++calls_ % interval == 0 && job_.cancelled(job_.cancel_user); }

private:
    static constexpr std::uint32_t interval = 64;
    const Job& job_;
    std::uint32_t calls_ = 0;
};

/// Traces a tile, packet by packet.
template <class V, class Events = AllEvents>
void trace_tile(const Task<V>& task, const Tile& tile, RayEnd* ends, Counters& counters) {
    RayQueue<lane_count<V>> queue(task.job, tile, ends);
    CancelCheck cancelled(task.job);
    while (!queue.empty()) {
        PacketTracer<V, Events> packet(task, counters);
        packet.start(queue);
        while (packet.prepare_step()) {
            packet.step(queue);
            if (cancelled()) return;
        }
        packet.finish();
    }
}

/// Greatest number of rays in a gang.
inline constexpr int max_gang_lanes = std::max({
#include "gangs.inc"
});

/// Traces a tile by gangs. The packets of a gang perform their steps in turn until all of their rays have ended. A gang
/// is like one packet with hundreds of lanes, of which a few registers are processed at a time.
template <class V>
void trace_by_gangs(const Task<V>& task, const Tile& tile, RayEnd* ends, Counters& counters, int packets) {
    RayQueue<lane_count<V>> queue(task.job, tile, ends);
    CancelCheck cancelled(task.job);
    std::optional<PacketTracer<V>> gang[max_gang_lanes / lane_count<V>];
    const auto end = gang + packets;
    while (!queue.empty()) {
        for (auto packet = gang; packet != end; ++packet) {
            packet->emplace(task, counters);
            (*packet)->start(queue);
        }
        while (std::any_of(gang, end, [](auto& packet) { return packet->prepare_step(); })) {
            for (auto packet = gang; packet != end; ++packet)
                (*packet)->prepare_step() ? (*packet)->step(queue) : (*packet)->idle();
            if (cancelled()) return;
        }
        for (auto packet = gang; packet != end; ++packet) (*packet)->finish();
    }
}

template <class V>
void trace_with(const SpaceKernel<V>& kernel, bool straight, const Job& job, const Tile& tile, RayEnd* ends,
                Counters& counters) {
    KAGERO_ASSERT(job.step > 0 && job.escape_radius > 0 && job.max_steps > 0);
    KAGERO_ASSERT((job.camera != nullptr) != (job.rays != nullptr) && tile.x0 <= tile.x1 && tile.y0 <= tile.y1);
    trace_tile(Task<V>(job, kernel, straight), tile, ends, counters);
}

template <class V>
void trace_entry(const Job* job, const Tile* tile, RayEnd* ends, Counters* counters) {
    trace_with(space_of<V>(*job), is_straight(job->hamiltonian, job->parameters), *job, *tile, ends, *counters);
}
template <class V, int lanes>
void gang_entry(const Job* job, const Tile* tile, RayEnd* ends, Counters* counters) {
    // The list of kernels contains no gang of one packet or less, so that case is not compiled.
    if constexpr (lanes > lane_count<V>)
        trace_by_gangs(Task<V>(*job, space_of<V>(*job), is_straight(job->hamiltonian, job->parameters)), *tile, ends,
                       *counters, lanes / lane_count<V>);
}

}  // namespace kagero
