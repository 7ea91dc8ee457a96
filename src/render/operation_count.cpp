#include "render/operation_count.h"

namespace kagero {
namespace {

/// What packets do ray by ray: a camera's ray and its momentum (rays/camera.cpp), where the kernel does not make it;
constexpr double start_of_a_ray = 50;
/// and where a segment that starts on a surface may meet the next (kernels/events/scene_intersector.h), once per ray
/// with objects.
constexpr double first_query = 7;

}  // namespace

Operations operations_of(const Plan& plan) {
    const Job job = plan.job();
    Operations counted = plan.module().operations(job.hamiltonian, job.parameters, job.integrator, job.rescaled);
    if (!job.geometry) counted.per_step = counted.per_step_alone;
    return counted;
}

double operations_of(const Plan& plan, const Counters& work) {
    const Operations counted = operations_of(plan);
    return counted.per_gradient * double(work.gradients) + counted.per_step * double(work.active_lane_steps);
}

std::optional<double> vectorization_ratio(const Plan& plan, const RunReport& report) {
    if (plan.scene->straight || plan.run.kernel->strategy == Strategy::per_ray) return {};
    if (plan.run.kernel->strategy == Strategy::scalar) return 0;
    const double packed = operations_of(plan, report.counters);
    const Job job = plan.job();
    const double per_ray = (job.camera ? 0 : start_of_a_ray) + (job.geometry ? first_query : 0);
    const double single = double(report.rays) * per_ray;
    return packed + single > 0 ? packed / (packed + single) : 0;
}

}  // namespace kagero
