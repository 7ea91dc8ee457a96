/// The kernels that `compare` measures.
#pragma once

#include "study/compare/compare_options.h"

namespace kagero {

/// Returns true if times and pictures of other kernels are compared with those of this kernel: it is the scalar kernel
/// in double without auto-vectorization, and the options do not state another instruction set for the baseline.
bool is_baseline(const Module& module, const KernelInfo& kernel, const CompareOptions& options);

/// Returns the module's kernels that the options select, and the baseline if the module has it. The baseline is the
/// first, and the others are sorted by strategy, precision and lanes.
std::vector<const KernelInfo*> compared_kernels(const Module& module, const CompareOptions& options);

/// Returns a kernel's instruction set, strategy, form, precision and lanes as text.
std::string describe_kernel(const Module& module, const KernelInfo& kernel);

/// Throws InputError if no kernel has the requested strategy, precision and lanes.
void check_selection(const std::vector<const Module*>& modules, const CompareOptions& options);

}  // namespace kagero
