/// Tracing of rays of which each has its own parameters of the Hamiltonian (Job::sets).
#pragma once

#include "kernels/abi.h"

namespace kagero {

/// Returns the kernel of Module::sweep_kernel.
KernelInfo sweep_kernel_info();

}  // namespace kagero
