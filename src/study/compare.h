/// Vectorization strategies side by side: the same picture by every kernel, through the path that `render` takes.
#pragma once

#include "accuracy/timing.h"
#include "render/render.h"

#include <array>
#include <optional>

namespace kagero {

struct CompareOptions {
    std::vector<std::string> isas;     ///< whose modules to compare
    std::vector<std::string> methods;  ///< empty: the scene's own
    std::vector<std::uint32_t> lanes;  ///< empty: every number of lanes
    std::optional<Strategy> strategy;  ///< none: every one
    std::optional<Precision> precision;
    double equal_error =
        0;  ///< pixels; each kernel by its own cheapest method for it. 0: all by the same method and step
    unsigned rounds = 5, threads = 1;
};

/// One kernel on one picture.
struct CompareRow {
    std::string isa, method, shape;  ///< shape: pixels of a packet, width x height
    const KernelInfo* kernel = nullptr;
    double step = 0;  ///< of adaptive methods: the tolerance
    double solver_tolerance = 0;
    Timing seconds;
    double rays_per_second = 0;  ///< of the median
    double speedup = 0;          ///< median over the rounds of scalar double's seconds over these
    bool drawn = false;          ///< what follows was measured before an interruption
    double occupancy = 1;        ///< active lane-steps over issued ones
    double max_difference = 0;   ///< of linear colours, to scalar double, where status and object agree
    std::uint64_t flips = 0;     ///< pixels where they do not
};

struct Comparison {
    std::vector<CompareRow> rows;
    std::vector<std::array<std::string, 2>> left_out;  ///< what, and why
    std::vector<std::string> remarks;                  ///< of the scene, for the user
    std::string compiler;
    std::uint64_t rays = 0;
    unsigned rounds = 0;  ///< done
    bool interrupted = false;
};

/// Every row is measured in each of the rounds, so that what disturbs the machine for a while disturbs them all. Throws
/// InputError where the scene or a method cannot be done at all.
Comparison compare(const SceneDescription& scene, const CompareOptions& options, const Progress& progress = {},
                   const std::atomic<bool>* stop = nullptr);

}  // namespace kagero
