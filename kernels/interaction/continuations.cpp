#include "kernels/interaction/continuations.h"

#include "kernels/trace/trace_entry.h"

namespace kagero {
namespace {

/// Returns the kernel of a space without time rescaling.
const SpaceKernel<PacketDouble>& packet_kernel(std::uint32_t hamiltonian, const double* parameters) {
    Job job{};
    job.hamiltonian = hamiltonian;
    job.parameters = parameters;
    return space_of<PacketDouble>(job);
}

}  // namespace

void continue_rays(std::uint32_t hamiltonian, const double* parameters, const SurfaceRay* rays, std::uint32_t count,
                   Continuation* out) {
    for_each_packet(packet_kernel(hamiltonian, parameters), parameters, rays, count, out,
                    continue_packet<PacketDouble>);
}

void time_tilts(std::uint32_t hamiltonian, const double* parameters, const SurfaceRay* rays, std::uint32_t count,
                double (*out)[3]) {
    for_each_packet(packet_kernel(hamiltonian, parameters), parameters, rays, count, out, tilt_packet<PacketDouble>);
}

}  // namespace kagero
