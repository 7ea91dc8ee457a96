#include "render/operation_count.h"

namespace kagero {
namespace {

/// What packets do ray by ray: the camera's ray and its momentum (kernels/tracing/ray_source.h), and the direction at the end.
constexpr double start_and_end = 50 + 10;
/// Where the chord of the last step meets what ends the ray (chord_fraction in kernels/tracing/surface.h, and before it in ray_ends.h).
constexpr double landing = 45;
/// Where a segment that starts on a surface may meet the next (kernels/tracing/encounter.h), once per ray with objects.
constexpr double first_query = 7;

}  // namespace

double operations_of(const Plan& plan, const Counters& work) {
    const Job& job = plan.job;
    const Operations counted = plan.module->operations(job.hamiltonian, job.parameters, job.integrator, job.rescaled);
    return counted.per_gradient * double(work.gradients) + counted.per_step * double(work.active_lane_steps);
}

std::optional<double> vectorization_ratio(const Plan& plan, const RunReport& report) {
    if (plan.straight || plan.kernel->strategy == Strategy::per_ray) return {};
    if (plan.kernel->strategy == Strategy::scalar) return 0;
    const double packed = operations_of(plan, report.counters);
    const double landed = double(report.status[int(Status::hit)] + report.status[int(Status::escaped)]);
    const double single = double(report.rays) * (start_and_end + (plan.job.geometry ? first_query : 0)) + landed * landing;
    return packed + single > 0 ? packed / (packed + single) : 0;
}

}  // namespace kagero
