// Rays that no method can integrate, traced by all kernels of the module. Each must end with a status, and must not
// change the ends of the other rays of its packet. The ends of these are compared with a run without the invalid ray.
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
struct Traced {
    std::vector<RayEnd> ends;
    Counters counters;
};

/// A Hamiltonian with an integrator, for jobs without surfaces.
struct Space {
    std::uint32_t hamiltonian, integrator;
    bool rescaled;
    std::vector<double> parameters = default_parameters(hamiltonian);
    double step = module().hamiltonians[hamiltonian].step;
    double escape_radius = 20;
    const StartRegion& region = start_region_of(module().hamiltonians[hamiltonian].name);
    std::uint32_t max_steps = 500;

    bool is(const char* hamiltonian_name) const {
        return std::string(module().hamiltonians[hamiltonian].name) == hamiltonian_name;
    }
    std::string name() const {
        return std::string(module().hamiltonians[hamiltonian].name) + ", " + module().integrators[integrator].name +
               (rescaled ? ", rescaled" : "");
    }
    Traced trace(const KernelInfo& kernel, const std::vector<RayStart>& rays) const {
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
        Traced run{std::vector<RayEnd>(rays.size()), {}};
        const Tile tile{0, 0, static_cast<std::uint32_t>(rays.size()), 1};
        kernel.trace(&job, &tile, run.ends.data(), &run.counters);
        return run;
    }
    /// Returns n rays from one position in different directions. In spaces without a start region of their own, they
    /// pass the origin at various distances.
    std::vector<RayStart> fan(std::uint32_t n) const {
        std::vector<RayStart> rays(n);
        const double far[3] = {-7, 0.5, 0.25};
        const double* q = region.hamiltonian.empty() ? far : region.q;
        for (std::uint32_t i = 0; i < n; ++i) {
            const double d[3] = {1, 1.25 * (i + 0.5) / n - 0.5, 0.3};
            EXPECT_EQ(module().start(hamiltonian, parameters.data(), q, d, &rays[i]), Failure::none);
        }
        return rays;
    }
};

/// Returns all combinations of Hamiltonian and integrator that the kernel supports. Uses time rescaling where possible.
std::vector<Space> spaces_of(const KernelInfo& kernel) {
    const Module& m = module();
    std::vector<Space> spaces;
    for (std::uint32_t h = 0; h < m.hamiltonian_count; ++h)
        for (std::uint32_t i = 0; i < m.integrator_count; ++i) {
            const bool rescaled = m.hamiltonians[h].rescales && !m.refusal(h, i, true);
            if (!rescaled && m.refusal(h, i, false)) continue;
            const Space space{h, i, rescaled};
            const bool straight = m.straight(h, space.parameters.data());
            if (!kernel.refusal || !kernel.refusal(h, i, rescaled, straight)) spaces.push_back(space);
        }
    return spaces;
}

/// Returns a random selection in which each Hamiltonian and each kind of stepper, with and without step control, occurs
/// at least once.
std::vector<Space> sample_of(const std::vector<Space>& spaces, unsigned seed) {
    std::vector<std::size_t> order(spaces.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::shuffle(order.begin(), order.end(), std::mt19937(seed));
    std::set<std::uint32_t> hamiltonians;
    std::set<std::pair<StepperKind, bool>> kinds;
    std::vector<Space> sample;
    for (const std::size_t i : order) {
        const Space& space = spaces[i];
        const Method& method = methods[space.integrator];
        const bool first_of_hamiltonian = hamiltonians.insert(space.hamiltonian).second;
        const bool first_of_kind = kinds.emplace(method.kind, method.info.adaptive).second;
        if (first_of_hamiltonian || first_of_kind) sample.push_back(space);
    }
    return sample;
}

/// Calls check(space, kernel) for every kernel and every combination of Hamiltonian and integrator that it supports.
/// For gangs, only a sample of the combinations is checked.
///
/// A gang executes the step code of packets, which is checked with all combinations, and adds a loop over packets. This
/// loop depends on the Hamiltonian (domain, capture, discontinuities) and on the kind of stepper (rejected and unsolved
/// steps), but not on their combination. The sample of each gang therefore contains each Hamiltonian and each kind of
/// stepper; the combinations differ from gang to gang. The environment variable KAGERO_EVERY_COMBINATION=1, set by
/// .ci/extra, selects all combinations, which takes minutes.
template <class Check>
void for_all_kernels_and_spaces(const Check& check) {
    const Module& m = module();
    const bool every_combination = std::getenv("KAGERO_EVERY_COMBINATION") != nullptr;
    for (std::uint32_t k = 0; k < m.kernel_count; ++k) {
        const KernelInfo& kernel = m.kernels[k];
        const std::vector<Space> all = spaces_of(kernel);
        for (const Space& space : kernel.form == Form::gang && !every_combination ? sample_of(all, k) : all) {
            SCOPED_TRACE(space.name() + ", " + std::to_string(kernel.lanes) + " lanes of " +
                         (kernel.precision == Precision::float64 ? "double" : "float"));
            check(space, kernel);
        }
    }
}

bool finite_state(const RayEnd& e) {
    bool all = std::isfinite(e.parameter);
    for (int k = 0; k < 3; ++k) all = all && std::isfinite(e.q[k]) && std::isfinite(e.p[k]) && std::isfinite(e.v[k]);
    return all;
}

double distance(const RayEnd& e) { return std::hypot(e.q[0], e.q[1], e.q[2]); }

/// Expects a reason if and only if the ray has failed, and a finite state unless it has failed or was captured.
void expect_consistent_end(const RayEnd& e) {
    const bool failed = e.status == Status::failed, has_reason = e.failure != Failure::none;
    EXPECT_EQ(failed, has_reason) << "failure " << static_cast<int>(e.failure);
    EXPECT_TRUE(finite_state(e) || e.status == Status::failed || e.status == Status::captured)
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

/// A start of a ray that cannot be integrated, or only with difficulty.
struct RoughStart {
    const char* description;
    RayStart start;
    bool must_fail;
};
std::vector<RoughStart> rough_starts(const RayStart& valid) {
    std::vector<RoughStart> all;
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
    for_all_kernels_and_spaces([](const Space& space, const KernelInfo& kernel) {
        const std::uint32_t n = std::max(kernel.lanes, 2u);
        const auto valid = space.fan(n);
        const Traced expected = space.trace(kernel, valid);
        for (const RayEnd& e : expected.ends) {
            // Some valid rays may fail. Eq. (9) of Satoh (2003), and compositions of it, have no solution if the step
            // is too long. In the mirage, 1/n grows without bound near the edge, where long negative substeps may have
            // no solution. In the fisheye, H is small far from the centre, where the energy error of methods of order 2
            // and of adaptive methods may be as large.
            const IntegratorInfo& method = module().integrators[space.integrator];
            const bool may_fail_in_fisheye = space.is("fisheye") && (method.order == 2 || method.adaptive);
            if (method.order > 1 && !space.is("mirage") && !may_fail_in_fisheye) {
                EXPECT_NE(e.status, Status::failed);
            }
            EXPECT_TRUE(finite_state(e) && std::isfinite(e.energy_error));
            // The end is refined by a few correction steps, each of which reduces the error at least by a factor of 10.
            // Rays that reach the edge of a medium end inside the escape sphere.
            if (e.status == Status::escaped) {
                EXPECT_LE(distance(e), (1 + 1e-5) * space.escape_radius);
            }
        }
        std::uint32_t rough_index = 0;
        for (const RoughStart& rough : rough_starts(valid[0])) {
            SCOPED_TRACE(rough.description);
            auto rays = valid;
            rough_index = (rough_index + 1) % n;
            rays[rough_index] = rough.start;
            const Traced run = space.trace(kernel, rays);
            for (std::uint32_t i = 0; i < n; ++i)
                if (i != rough_index) expect_same(run.ends[i], expected.ends[i]);
            const RayEnd& end = run.ends[rough_index];
            EXPECT_TRUE(end.status == Status::failed || !rough.must_fail);
            expect_consistent_end(end);
        }
    });
}

// After a ray has failed, the state in its lane must not cause further iterations of implicit stages. The packet
// iterates only for the first step of this ray and its retries with shorter steps.
TEST(ExtremeRays, CauseNoIterationsAfterTheyHaveFailed) {
    for_all_kernels_and_spaces([](Space space, const KernelInfo& kernel) {
        if (kernel.lanes == 1) return;
        space.step /= 16;
        auto rays = space.fan(kernel.lanes);
        const Traced expected = space.trace(kernel, rays);
        rays[1].q[1] = nan;
        const Traced run = space.trace(kernel, rays);
        constexpr std::uint64_t attempts = 9, iterations = 60, max_solves_per_step = 18;
        const std::uint64_t for_failed_ray = attempts * iterations * max_solves_per_step * kernel.lanes;
        EXPECT_LE(run.counters.issued_iterations, expected.counters.issued_iterations + for_failed_ray);
    });
}

// Steps that are too long to be solved are halved several times; then the ray fails. Every ray must end with a status.
TEST(ExtremeRays, HugeStepsEndWithAStatus) {
    for_all_kernels_and_spaces([](Space space, const KernelInfo& kernel) {
        for (const double factor : {30.0, 1e4, 1e12}) {
            SCOPED_TRACE(factor);
            space.step = factor * module().hamiltonians[space.hamiltonian].step;
            // Gangs of more than 40 lanes are not filled, because each packet of a gang retries its own steps.
            const Traced run = space.trace(kernel, space.fan(std::clamp(kernel.lanes, 8u, 40u)));
            for (const RayEnd& e : run.ends) {
                EXPECT_LE(e.steps, space.max_steps);
                EXPECT_NE(e.status, Status::hit);
                expect_consistent_end(e);
            }
        }
    });
}

// A ray start that already contains a failure must end as failed, with the same reason and without a step.
TEST(ExtremeRays, RefusedStartsEndWithTheSameReason) {
    for_all_kernels_and_spaces([](const Space& space, const KernelInfo& kernel) {
        auto rays = space.fan(kernel.lanes);
        rays[0].failure = Failure::zero_direction;
        const Traced run = space.trace(kernel, rays);
        EXPECT_EQ(run.ends[0].status, Status::failed);
        EXPECT_EQ(run.ends[0].failure, Failure::zero_direction);
        EXPECT_EQ(run.ends[0].steps, 0u);
    });
}

}  // namespace
}  // namespace kagero::test
