#include "kernels/lane_parameters/lane_kernels.h"

#include "all_hamiltonians.inc"
#include "kernels/assertion.h"
#include "kernels/formula/formula_kernel.h"
#include "kernels/lane_parameters/lane_formula.h"
#include "kernels/lane_parameters/lane_system.h"
#include "kernels/trace/trace_entry.h"

#include <algorithm>

namespace kagero {

template void fill_uniforms<PacketDouble>(const Node*, const int*, int, const PacketDouble*, PacketDouble*);

namespace {

/// A Hamiltonian for lanes with different parameters.
struct LaneSpace {
    const SpaceKernel<PacketDouble>& (*kernel)();
    int parameter_count;
    bool rescaled;  ///< True if the kernel integrates Ω (H − H0).
};
constexpr LaneSpace lane_spaces[] = {
#define KAGERO_HAMILTONIAN(TYPE)                                                               \
    {lane_kernel<hamiltonians::TYPE>, static_cast<int>(hamiltonians::TYPE::parameters.size()), \
     Rescalable<hamiltonians::TYPE>},
#include "hamiltonians.inc"
#undef KAGERO_HAMILTONIAN
};

constexpr std::uint32_t formula_space = std::size(lane_spaces);  ///< Index of the Hamiltonian `formula`.
static_assert(LaneNumbers<PacketDouble>::max_parameters >= max_formula_parameters);

/// The kernels of formulas for lanes with different parameters.
constexpr formula::FormulaKernels<PacketDouble> lane_formula_kernels =
    formula::kernels_from<LaneFormulaSystem<PacketDouble>>(
        detail::make_lane_kernel<LaneFormulaSystem<PacketDouble>, PacketDouble>());

/// Traces the rays of one packet, whose lanes have the given sets of parameters. `job` is the job of the packet.
void trace_packet(Job& job, const double* parameters, const Tile& tile, RayEnd* ends, Counters& counters) {
    if (job.hamiltonian == formula_space) {
        const formula::Programs& programs = formula::programs_in(parameters);
        const LaneNumbers<PacketDouble> numbers(job.lane_sets, programs.parameters);
        LaneFormula<PacketDouble> formula(programs, numbers.numbers);
        job.parameters = reinterpret_cast<const double*>(&formula);
        trace_with(lane_formula_kernels.of(programs), false, job, tile, ends, counters);
    } else {
        const LaneSpace& space = lane_spaces[job.hamiltonian];
        const LaneNumbers<PacketDouble> numbers(job.lane_sets, space.parameter_count);
        job.parameters = numbers.numbers[0];
        trace_with(space.kernel(), false, job, tile, ends, counters);
    }
}

/// Traces a run of a list of rays, packet by packet. The lanes of a packet have the parameters of their rays; idle
/// lanes have those of the last ray.
void trace_sweep(const Job* job, const Tile* tile, RayEnd* ends, Counters* counters) {
    constexpr std::uint32_t W = lane_count<PacketDouble>;
    KAGERO_ASSERT(job->sets && job->set_count > 0 && job->rays && !job->refill);
    Job packet_job = *job;
    for (std::uint32_t first = tile->x0; first < tile->x1; first += W) {
        const Tile packet{first, 0, std::min(first + W, tile->x1), 1};
        const ParameterSet* sets[W];
        for (std::uint32_t i = 0; i < W; ++i) sets[i] = &job->sets[std::min(first + i, packet.x1 - 1) % job->set_count];
        packet_job.lane_sets = sets;
        trace_packet(packet_job, job->parameters, packet, ends + (first - tile->x0), *counters);
    }
}

const char* sweep_refusal(const SpaceAndMethod* c) {
    const int kind = static_cast<int>(methods[c->integrator].kind);
    if (c->straight) return "straight rays are traced in closed form, without lanes of different parameters";
    if (c->hamiltonian == formula_space) return lane_formula_kernels.smooth.refusal[kind];
    const LaneSpace& space = lane_spaces[c->hamiltonian];
    if (c->rescaled != space.rescaled)
        return "this kernel is compiled only with the time rescaling that the Hamiltonian declares";
    return space.kernel().refusal[kind];
}

}  // namespace

KernelInfo sweep_kernel_info() {
    return {Strategy::packet,
            Precision::float64,
            Form::none,
            lane_count<PacketDouble>,
            ValueTraits<PacketDouble>::registers,
            trace_sweep,
            sweep_refusal};
}

}  // namespace kagero
