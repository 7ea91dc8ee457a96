/// Comparison of the vectorization strategies: every kernel renders the same picture with the code of `render`.
#pragma once

#include "accuracy/timing.h"
#include "render/render.h"
#include "study/compare/compare_options.h"
#include "study/compare/compared_plans.h"

#include <array>

namespace kagero {

/// Result of one kernel.
struct CompareRow {
    std::string isa, method;
    std::string shape;  ///< Pixels of a packet as WIDTHxHEIGHT; for a gang of N packets, "N of WIDTHxHEIGHT".
    const KernelInfo* kernel = nullptr;
    HamiltonianCode code = HamiltonianCode::built_in;
    double step = 0;              ///< Step in the unit of a scene file, or the tolerance of an adaptive method.
    double solver_tolerance = 0;  ///< Relative solver tolerance; 0: iterate to rounding.
    Timing seconds;               ///< Time to render the picture.
    std::vector<double> samples;  ///< This time in each round.
    double rays_per_second = 0;   ///< Number of rays divided by the median time.
    double speedup = 0;           ///< Median over the rounds of (time of the baseline) / (time of this kernel).
    bool rendered = false;        ///< True if a picture was rendered. If false, the members below are not measured.
    double occupancy = 1;         ///< Active lane-steps divided by issued lane-steps.
    /// Greatest difference of a linear colour component from the baseline, over pixels whose status and object agree.
    double max_difference = 0;
    std::uint64_t flips = 0;  ///< Number of pixels whose status or object differs from the baseline.
};

/// Results of a comparison.
struct Comparison {
    std::vector<CompareRow> rows;
    std::vector<std::array<std::string, 2>> left_out;  ///< Pairs (kernel, reason) of kernels that were not compared.
    std::vector<std::string> remarks;                  ///< Remarks on the scene, and on keys that `compare` ignores.
    std::string compiler;                              ///< Compiler of the kernel modules.
    std::vector<std::array<std::string, 2>> flags;     ///< Pairs (instruction set, options of the compiler).
    std::uint32_t width = 0, height = 0;               ///< Size of the picture, which may be smaller than the scene's.
    std::uint64_t rays = 0;                            ///< Number of rays of the picture.
    unsigned rounds = 0;                               ///< Number of completed rounds.
    bool interrupted = false;
};

/// Renders the scene with every selected kernel and compares pictures and times. Kernels that exist for comparison but
/// are not compiled for the space use machine code that is generated from the programs of its H. The default kernels
/// are then measured both with their own code and with this code. The baseline of a kernel is the scalar
/// kernel in double of the same instruction set, or of `baseline`. Without `equal_error`, both have the same method.
/// Every kernel runs once per round, so that a temporary disturbance of the machine affects all of them. Throws
/// InputError if the scene or the options are not supported.
Comparison compare(const SceneDescription& scene, const CompareOptions& options, const Progress& progress = {},
                   const std::atomic<bool>* stop = nullptr);

}  // namespace kagero
