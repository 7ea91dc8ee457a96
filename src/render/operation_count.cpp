#include "render/operation_count.h"

namespace kagero {
namespace {

/// Scalar operations for the start of one camera ray (rays/camera.cpp), if the kernel does not generate the ray.
constexpr double operations_of_ray_start = 50;
/// Scalar operations for the first query of one ray (kernels/events/scene_intersector.h), in a scene with objects.
/// These operations find the point from which a segment that starts on a surface can hit the next surface.
constexpr double operations_of_first_query = 7;

}  // namespace

Operations operations_of(const Plan& plan) {
    const Job job = plan.job();
    Operations operations = plan.module().operations(job.hamiltonian, job.parameters, job.integrator, job.rescaled);
    if (!job.geometry) operations.per_step = operations.per_step_without_surfaces;
    return operations;
}

double operations_of(const Plan& plan, const Counters& counters) {
    const Operations costs = operations_of(plan);
    return costs.per_gradient * double(counters.gradients) + costs.per_step * double(counters.active_lane_steps);
}

std::optional<double> vectorization_ratio(const Plan& plan, const RunReport& report) {
    if (plan.scene->straight || plan.run.kernel->strategy == Strategy::per_ray) return {};
    if (plan.run.kernel->strategy == Strategy::scalar) return 0;
    const double packed = operations_of(plan, report.counters);
    const Job job = plan.job();
    const double per_ray = (job.camera ? 0 : operations_of_ray_start) + (job.geometry ? operations_of_first_query : 0);
    const double scalar = double(report.rays) * per_ray;
    return packed + scalar > 0 ? packed / (packed + scalar) : 0;
}

}  // namespace kagero
