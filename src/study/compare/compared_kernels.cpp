#include "study/compare/compared_kernels.h"

#include "error.h"
#include "plan/names.h"
#include "scene/reader.h"

#include <algorithm>
#include <set>

namespace kagero {
namespace {

/// Returns true for the scalar kernel in double without auto-vectorization.
bool is_scalar_double(const KernelInfo& kernel) {
    return kernel.strategy == Strategy::scalar && kernel.form == Form::none && kernel.precision == Precision::float64;
}

/// Returns true if the options select the kernel.
bool is_selected(const Module& module, const KernelInfo& kernel, const CompareOptions& options) {
    // The instruction set of the baseline may have been stated for the baseline alone.
    if (std::count(options.isas.begin(), options.isas.end(), module.isa) == 0) return false;
    if (options.strategy && kernel.strategy != *options.strategy) return false;
    if (options.precision && kernel.precision != *options.precision) return false;
    if (kernel.strategy == Strategy::per_ray) return true;
    // Without --lanes, gangs are compared only if they have more lanes than the largest packet.
    constexpr std::uint32_t max_packet_lanes = 64;  // four registers of sixteen floats
    if (options.lanes.empty()) return kernel.form != Form::gang || kernel.lanes > max_packet_lanes;
    return std::count(options.lanes.begin(), options.lanes.end(), kernel.lanes) > 0;
}

/// Throws InputError if no kernel has a requested number of lanes.
void check_lanes(const std::vector<const Module*>& modules, const CompareOptions& options) {
    std::set<std::uint32_t> existing;
    for (const Module* module : modules)
        for (std::uint32_t i = 0; i < module->kernel_count; ++i) existing.insert(module->kernels[i].lanes);
    for (const std::uint32_t lanes : options.lanes) {
        if (existing.count(lanes)) continue;
        std::string text;
        for (const std::uint32_t n : existing) append_to_list(text, std::to_string(n));
        throw InputError("--lanes: no kernel has " + std::to_string(lanes) +
                         " lanes; kernels exist with these numbers of lanes: " + text);
    }
}

}  // namespace

bool is_baseline(const Module& module, const KernelInfo& kernel, const CompareOptions& options) {
    return is_scalar_double(kernel) && (options.baseline.empty() || options.baseline == module.isa);
}

std::vector<const KernelInfo*> compared_kernels(const Module& module, const CompareOptions& options) {
    std::vector<const KernelInfo*> kernels;
    for (std::uint32_t i = 0; i < module.kernel_count; ++i)
        if (is_baseline(module, module.kernels[i], options) || is_selected(module, module.kernels[i], options))
            kernels.push_back(&module.kernels[i]);
    std::stable_sort(kernels.begin(), kernels.end(), [](const KernelInfo* a, const KernelInfo* b) {
        const auto sort_key = [](const KernelInfo& k) {
            return std::array{int(!is_scalar_double(k)), int(k.strategy), int(k.precision), int(k.lanes)};
        };
        return sort_key(*a) < sort_key(*b);
    });
    return kernels;
}

std::string describe_kernel(const Module& module, const KernelInfo& kernel) {
    std::string text = std::string(module.isa) + " " + name_of(kernel.strategy);
    if (kernel.form != Form::none) text += std::string(" ") + name_of(kernel.form);
    return text + " " + name_of(kernel.precision) + ", " + std::to_string(kernel.lanes) + " lanes";
}

void check_selection(const std::vector<const Module*>& modules, const CompareOptions& options) {
    check_lanes(modules, options);
    for (const Module* module : modules)
        for (std::uint32_t i = 0; i < module->kernel_count; ++i)
            if (is_selected(*module, module->kernels[i], options)) return;
    std::string requested;
    if (options.strategy) append_to_list(requested, std::string("strategy ") + name_of(*options.strategy));
    if (options.precision) append_to_list(requested, name_of(*options.precision));
    for (const std::uint32_t lanes : options.lanes)
        append_to_list(requested, std::to_string(lanes) + (lanes == 1 ? " lane" : " lanes"));
    throw InputError(requested + ": no kernel has these properties; `kagero list strategies` shows all kernels");
}

}  // namespace kagero
