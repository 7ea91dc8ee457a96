// Tests rays that no method can integrate, with all kernels of the module. Such a ray must end with a status, and must
// not change the ends of the other rays of its packet. The other ends are compared with those of a run in which all
// rays are valid.
#include "tests/kernels/start_regions.h"

#include "kernels/abi.h"
#include "kernels/methods/methods.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

extern "C" const kagero::Module* kagero_kernels();

namespace kagero::test {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();

const Module& module() { return *kagero_kernels(); }

std::vector<double> default_parameters(std::uint32_t hamiltonian) {
    const HamiltonianInfo& info = module().hamiltonians[hamiltonian];
    std::vector<double> values(info.parameter_count + 1);
    for (std::uint32_t i = 0; i < info.parameter_count; ++i) values[i] = info.parameters[i].default_value;
    return values;
}

/// Ends and counters of a traced list of rays.
struct TraceResult {
    std::vector<RayEnd> ends;
    Counters counters;
};

/// A combination of Hamiltonian and integrator, with the other settings of a job without surfaces.
struct Combination {
    std::uint32_t hamiltonian, integrator;
    bool rescaled;
    std::vector<double> parameters = default_parameters(hamiltonian);
    double step = module().hamiltonians[hamiltonian].step;
    double escape_radius = 20;
    const StartRegion& region = start_region_of(module().hamiltonians[hamiltonian].name);
    std::uint32_t max_steps = 500;

    bool has_hamiltonian(const char* hamiltonian_name) const {
        return std::string(module().hamiltonians[hamiltonian].name) == hamiltonian_name;
    }
    std::string name() const {
        return std::string(module().hamiltonians[hamiltonian].name) + ", " + module().integrators[integrator].name +
               (rescaled ? ", rescaled" : "");
    }
    TraceResult trace(const KernelInfo& kernel, const std::vector<RayStart>& rays) const {
        Job job{};
        job.hamiltonian = hamiltonian;
        job.integrator = integrator;
        job.parameters = parameters.data();
        job.rescaled = rescaled;
        job.step = step;
        job.max_steps = max_steps;
        job.escape_radius = escape_radius;
        job.parameter_limit = infinity;
        job.bending_radius = module().bending_radius(hamiltonian, parameters.data());
        job.tolerance = 1e-6;
        job.hit = HitModel::hermite;
        job.outputs = output_energy | output_parameter;
        job.rays = rays.data();
        TraceResult run{std::vector<RayEnd>(rays.size()), {}};
        const Tile tile{0, 0, static_cast<std::uint32_t>(rays.size()), 1};
        kernel.trace(&job, &tile, run.ends.data(), &run.counters);
        return run;
    }
    /// Returns n rays from one position in different directions. In spaces without a row in start_regions.h, the rays
    /// pass the origin at various distances.
    std::vector<RayStart> fan(std::uint32_t n) const {
        std::vector<RayStart> rays(n);
        const double distant[3] = {-7, 0.5, 0.25};
        const double* q = region.hamiltonian.empty() ? distant : region.q;
        for (std::uint32_t i = 0; i < n; ++i) {
            const double d[3] = {1, 1.25 * (i + 0.5) / n - 0.5, 0.3};
            EXPECT_EQ(module().start(hamiltonian, parameters.data(), q, d, &rays[i]), Failure::none);
        }
        return rays;
    }
};

/// Returns all combinations of Hamiltonian and integrator that the kernel supports, with time rescaling where possible.
std::vector<Combination> combinations_of(const KernelInfo& kernel) {
    const Module& m = module();
    std::vector<Combination> combinations;
    for (std::uint32_t h = 0; h < m.hamiltonian_count; ++h)
        for (std::uint32_t i = 0; i < m.integrator_count; ++i) {
            const bool rescaled = m.hamiltonians[h].rescales && !m.refusal(h, i, true);
            if (!rescaled && m.refusal(h, i, false)) continue;
            const Combination combination{h, i, rescaled};
            const bool straight = m.straight(h, combination.parameters.data());
            const SpaceAndMethod asked{h, combination.parameters.data(), i, rescaled, straight};
            if (!kernel.refusal || !kernel.refusal(&asked)) combinations.push_back(combination);
        }
    return combinations;
}

/// Returns a random selection in which each Hamiltonian and each kind of stepper, with and without step control, occurs
/// at least once.
std::vector<Combination> sample_of(const std::vector<Combination>& combinations, unsigned seed) {
    std::vector<std::size_t> order(combinations.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::shuffle(order.begin(), order.end(), std::mt19937(seed));
    std::set<std::uint32_t> hamiltonians;
    std::set<std::pair<StepperKind, bool>> kinds;
    std::vector<Combination> sample;
    for (const std::size_t i : order) {
        const Combination& combination = combinations[i];
        const Method& method = methods[combination.integrator];
        const bool first_of_hamiltonian = hamiltonians.insert(combination.hamiltonian).second;
        const bool first_of_kind = kinds.emplace(method.kind, method.info.adaptive).second;
        if (first_of_hamiltonian || first_of_kind) sample.push_back(combination);
    }
    return sample;
}

/// Calls check(combination, kernel) for every kernel and every combination of Hamiltonian and integrator that it
/// supports. For gangs, only a sample of the combinations is checked.
///
/// A gang executes the step code of packets, which is checked with all combinations, and adds a loop over packets. This
/// loop depends on the Hamiltonian (domain, capture, discontinuities) and on the kind of stepper (rejected and unsolved
/// steps), but not on their combination. The sample of each gang therefore contains each Hamiltonian and each kind of
/// stepper; the combinations differ from gang to gang. The environment variable KAGERO_EVERY_COMBINATION=1, set by
/// .ci/extra, selects all combinations, which takes minutes.
template <class Check>
void for_all_kernels_and_combinations(const Check& check) {
    const Module& m = module();
    const bool every_combination = std::getenv("KAGERO_EVERY_COMBINATION") != nullptr;
    for (std::uint32_t k = 0; k < m.kernel_count; ++k) {
        const KernelInfo& kernel = m.kernels[k];
        const std::vector<Combination> all = combinations_of(kernel);
        const bool use_sample = kernel.form == Form::gang && !every_combination;
        for (const Combination& combination : use_sample ? sample_of(all, k) : all) {
            SCOPED_TRACE(combination.name() + ", " + std::to_string(kernel.lanes) + " lanes of " +
                         (kernel.precision == Precision::float64 ? "double" : "float"));
            check(combination, kernel);
        }
    }
}

bool has_finite_state(const RayEnd& e) {
    bool all = std::isfinite(e.parameter);
    for (int k = 0; k < 3; ++k) all = all && std::isfinite(e.q[k]) && std::isfinite(e.p[k]) && std::isfinite(e.v[k]);
    return all;
}

double distance_from_origin(const RayEnd& e) { return std::hypot(e.q[0], e.q[1], e.q[2]); }

/// Expects a reason if and only if the ray has failed, and a finite state unless it has failed or was captured.
void expect_consistent_end(const RayEnd& e) {
    const bool failed = e.status == Status::failed, has_reason = e.failure != Failure::none;
    EXPECT_EQ(failed, has_reason) << "failure " << static_cast<int>(e.failure);
    EXPECT_TRUE(has_finite_state(e) || e.status == Status::failed || e.status == Status::captured)
        << "status " << static_cast<int>(e.status) << " at " << e.q[0] << ' ' << e.q[1] << ' ' << e.q[2]
        << ", parameter " << e.parameter << " after " << e.steps << " steps";
}

void expect_same(const RayEnd& a, const RayEnd& b) {
    for (int k = 0; k < 3; ++k)
        EXPECT_TRUE(a.q[k] == b.q[k] && a.p[k] == b.p[k] && a.v[k] == b.v[k]) << "component " << k;
    EXPECT_EQ(a.parameter, b.parameter);
    EXPECT_EQ(a.energy_error, b.energy_error);
    EXPECT_EQ(a.steps, b.steps);
    EXPECT_EQ(a.gradients, b.gradients);
    EXPECT_EQ(a.status, b.status);
    EXPECT_EQ(a.failure, b.failure);
}

/// The start of a ray that cannot be integrated, or that overflows or underflows some intermediate results.
struct DifficultStart {
    const char* description;
    RayStart start;
    bool must_fail;
};
std::vector<DifficultStart> difficult_starts(const RayStart& valid) {
    std::vector<DifficultStart> all;
    const auto add = [&](const char* description, bool must_fail, auto change) {
        all.push_back({description, valid, must_fail});
        change(all.back().start);
    };
    add("NaN position", true, [](RayStart& r) { r.q[1] = nan; });
    add("infinite position", true, [](RayStart& r) { r.q[0] = infinity; });
    add("NaN momentum", true, [](RayStart& r) { r.p[2] = nan; });
    add("at the origin", false, [](RayStart& r) { r.q[0] = r.q[1] = r.q[2] = 0; });
    add("momentum 1e300", false, [](RayStart& r) { r.p[1] = 1e300; });
    add("momentum 1e15", false, [](RayStart& r) { r.p[1] = 1e15; });
    add("no momentum", false, [](RayStart& r) { r.p[0] = r.p[1] = r.p[2] = 0; });
    add("denormal position", false, [](RayStart& r) { r.q[0] = r.q[1] = r.q[2] = 1e-310; });
    return all;
}

TEST(ExtremeRays, EndWithAStatusAndDoNotChangeOtherRays) {
    for_all_kernels_and_combinations([](const Combination& combination, const KernelInfo& kernel) {
        const std::uint32_t n = std::max(kernel.lanes, 2u);
        const auto valid = combination.fan(n);
        const TraceResult expected = combination.trace(kernel, valid);
        for (const RayEnd& e : expected.ends) {
            // Some valid rays may fail. Eq. (9) of Satoh (2003), and compositions of it, have no solution if the step
            // is too long. In the mirage, 1/n grows without bound near the edge, where long negative substeps may have
            // no solution. In the fisheye, |H| is small far from the centre. The energy error of methods of order
            // 2 and of adaptive methods may be as large as |H| there.
            const IntegratorInfo& method = module().integrators[combination.integrator];
            const bool may_fail_in_fisheye =
                combination.has_hamiltonian("fisheye") && (method.order == 2 || method.adaptive);
            if (method.order > 1 && !combination.has_hamiltonian("mirage") && !may_fail_in_fisheye) {
                EXPECT_NE(e.status, Status::failed);
            }
            EXPECT_TRUE(has_finite_state(e) && std::isfinite(e.energy_error));
            // The end of an escaping ray is refined by a few correction steps, each of which reduces the distance from
            // the escape sphere by a factor of at least 10. Rays that reach the edge of a medium end inside the sphere.
            if (e.status == Status::escaped) {
                EXPECT_LE(distance_from_origin(e), (1 + 1e-5) * combination.escape_radius);
            }
        }
        std::uint32_t difficult_index = 0;
        for (const DifficultStart& difficult : difficult_starts(valid[0])) {
            SCOPED_TRACE(difficult.description);
            auto rays = valid;
            difficult_index = (difficult_index + 1) % n;
            rays[difficult_index] = difficult.start;
            const TraceResult run = combination.trace(kernel, rays);
            for (std::uint32_t i = 0; i < n; ++i)
                if (i != difficult_index) expect_same(run.ends[i], expected.ends[i]);
            const RayEnd& end = run.ends[difficult_index];
            EXPECT_TRUE(end.status == Status::failed || !difficult.must_fail);
            expect_consistent_end(end);
        }
    });
}

// After a ray has failed, the state in its lane must not cause further iterations of implicit stages. Additional
// iterations are allowed only in the first step of this ray and in its repetitions with shorter steps.
TEST(ExtremeRays, CauseNoIterationsAfterTheyHaveFailed) {
    for_all_kernels_and_combinations([](Combination combination, const KernelInfo& kernel) {
        if (kernel.lanes == 1) return;
        combination.step /= 16;
        auto rays = combination.fan(kernel.lanes);
        const TraceResult expected = combination.trace(kernel, rays);
        rays[1].q[1] = nan;
        const TraceResult run = combination.trace(kernel, rays);
        constexpr std::uint64_t attempts = 9, iterations_per_solve = 60, max_solves_per_step = 18;
        const std::uint64_t for_failed_ray = attempts * iterations_per_solve * max_solves_per_step * kernel.lanes;
        EXPECT_LE(run.counters.issued_iterations, expected.counters.issued_iterations + for_failed_ray);
    });
}

// A step without a solution is halved, and the ray fails after too many halvings. Every ray must end with a status.
TEST(ExtremeRays, HugeStepsEndWithAStatus) {
    for_all_kernels_and_combinations([](Combination combination, const KernelInfo& kernel) {
        for (const double factor : {30.0, 1e4, 1e12}) {
            SCOPED_TRACE(factor);
            combination.step = factor * module().hamiltonians[combination.hamiltonian].step;
            // At most 40 rays limit the run time of large gangs, each packet of which repeats its steps separately.
            const TraceResult run = combination.trace(kernel, combination.fan(std::clamp(kernel.lanes, 8u, 40u)));
            for (const RayEnd& e : run.ends) {
                EXPECT_LE(e.steps, combination.max_steps);
                EXPECT_NE(e.status, Status::hit);
                expect_consistent_end(e);
            }
        }
    });
}

// A ray start that already contains a failure must end as failed, with the same reason and without a step.
TEST(ExtremeRays, RefusedStartsEndWithTheSameReason) {
    for_all_kernels_and_combinations([](const Combination& combination, const KernelInfo& kernel) {
        auto rays = combination.fan(kernel.lanes);
        rays[0].failure = Failure::zero_direction;
        const TraceResult run = combination.trace(kernel, rays);
        EXPECT_EQ(run.ends[0].status, Status::failed);
        EXPECT_EQ(run.ends[0].failure, Failure::zero_direction);
        EXPECT_EQ(run.ends[0].steps, 0u);
    });
}

}  // namespace
}  // namespace kagero::test
