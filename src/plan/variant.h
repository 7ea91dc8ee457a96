/// A scene's rays by another method than the scene's own, through the same kernels and loop.
#pragma once

#include "render/render.h"

#include <algorithm>
#include <optional>

namespace kagero {

/// One way of integrating a plan's rays.
struct Variant {
    std::uint32_t integrator = 0;
    bool rescaled = false;
    const KernelInfo* kernel = nullptr;
    double step = 0;               ///< of adaptive methods: the tolerance
    double solver_tolerance = -1;  ///< of implicit equations; negative: the scene's
};

const IntegratorInfo& info_of(const Plan& plan, const Variant& variant);

/// The variant that `render` would use for a method of this name; nothing where the module has no such method, or the space or
/// the scene refuses it.
std::optional<Variant> find_variant(const Plan& plan, const std::string& method, Strategy strategy, Precision precision,
                                    double step);

/// The same by one of the module's kernels, which may refuse it too.
std::optional<Variant> find_variant(const Plan& plan, const std::string& method, const KernelInfo& kernel, double step);

/// What the steps of a variant count.
StepKind step_kind(const Plan& plan, const Variant& variant);
/// The plan's step, for a variant whose steps count what the plan's do; else in the same proportion to the space's default for it.
double usual_step(const Plan& plan, const Variant& variant);
/// The space's default, where the scene's own step does not count.
double default_step(const Plan& plan, const Variant& variant);
/// The variant's step, or tolerance, as a scene states it; and such a step as the job counts it.
double stated_step(const Plan& plan, const Variant& variant);
double job_step(const Plan& plan, const Variant& variant, double stated);

/// The plan's job by a variant. A ray may take as many steps as cover the path that the scene allows.
Job job_as(const Plan& plan, const Variant& variant);

/// Makes a plan follow a variant.
void follow(Plan& plan, const Variant& variant);

/// The same while it lives.
class PlanAs {
public:
    PlanAs(Plan& plan, const Variant& variant);
    ~PlanAs();
    PlanAs(const PlanAs&) = delete;
    PlanAs& operator=(const PlanAs&) = delete;
    /// A ray may find no end then, and takes so many steps at most.
    void without_surfaces(std::uint32_t most_steps) {
        if (!plan_.job.geometry) return;
        plan_.job.geometry = nullptr;
        plan_.job.max_steps = std::min(plan_.job.max_steps, most_steps);
    }
    void on_threads(unsigned threads) { plan_.threads = threads; }

private:
    Plan& plan_;
    const Job job_;
    const KernelInfo* const kernel_;
    const unsigned threads_;
};

}  // namespace kagero
