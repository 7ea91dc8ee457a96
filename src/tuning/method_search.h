/// Search for the cheapest method and step that keep the errors of trial rays within a bound.
#pragma once

#include "accuracy/reference.h"
#include "render/run_report.h"

#include <chrono>

namespace kagero {

/// A method with a step whose errors were measured.
struct MeasuredMethod {
    Variant variant;
    double operations = 0;  ///< Operations per ray.
    RayErrors errors;
    bool is_within = false;  ///< True if the errors are within the bound.
};

/// A search. The trial's rays are a sparse grid of the film's rays. Two methods, which must agree, give their reference
/// ends. Each candidate is then traced with several steps. It must also keep the errors of rays at the edge of a shadow
/// small, which are few but magnify errors most. The search does at most a third of the operations of the picture that
/// is rendered if it finds nothing, or as many as take some hundredths of a second.
class MethodSearch {
public:
    /// RunConfig::value_weight of the reference, as for ray lists.
    static constexpr double reference_value_weight = 1e-3;

    MethodSearch(const Plan& plan, double bound, const RunControl& control)
        : plan_(plan), bound_(bound), control_(control), spent_(plan.trial_operations) {}

    /// Traces the reference and all candidates. Sets `best` and `failure_reason`. Throws Interrupted if the caller
    /// cancels the trial.
    void run();

    std::optional<MeasuredMethod> best;
    std::optional<Variant> reference;  ///< The method of the reference; empty if there is none or it is too costly.
    bool is_confirmed = false;         ///< True if another method agrees with the reference.
    std::string failure_reason;  ///< Reason why `best` is empty.
    bool is_affordable = true;   ///< False if the search would need more operations than the picture permits.
    std::uint64_t rays = 0;
    double uncertainty = 0;  ///< 99th percentile of the pixel distances between the two methods of the reference.

private:
    bool trace_reference();
    bool trace_reference_with(Variant first, Variant second, double refinement);
    bool confirm_with_finer(Variant confirming, double refinement);
    bool confirm_reference(const std::vector<RayEnd>& confirming, const char* method, const char* confirming_method);
    bool has_float() const;
    void try_method(const char* name);
    void trace_shadow_edge(const Plan& reference_plan);
    std::optional<MeasuredMethod> measure(Variant variant);
    std::vector<RayEnd> trace_rays(const Plan& plan, const std::vector<RayStart>& starts, double* operations = nullptr);
    double cost(const MeasuredMethod& measured) const;
    double picture_rays() const;
    double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count(); }

    Plan plan_;
    const double bound_;
    const RunControl& control_;
    const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
    bool may_use_float_ = false;
    Precision precision_ = Precision::float64;  ///< Precision in which candidates are measured.
    double spent_, budget_ = 0;  ///< Operations. Those of the trial that chose the step bound are spent, too.
    /// Operations per ray of the reference's method, and of the confirming method with the coarser tolerance.
    double reference_operations_ = 0, confirming_operations_ = 0;
    SampleRays sample_;
    ReferenceRays reference_;
    std::vector<RayEnd> default_ends_;  ///< Ends by the plan's method.
    /// Strongly magnified rays at the edge of a shadow, and their reference ends.
    SampleRays edge_sample_;
    ReferenceRays edge_reference_;
};

}  // namespace kagero
