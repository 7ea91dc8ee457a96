// Rays that no method can follow, through the kernels' own entry: each ends in a status of its own and moves no other
// ray.
#include "tests/kernels/places.h"

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
    for (std::uint32_t i = 0; i < info.parameter_count; ++i) values[i] = info.parameters[i].fallback;
    return values;
}

struct Traced {
    std::vector<RayEnd> ends;
    Counters counters;
};

/// A job without scene, with everything recorded.
struct Space {
    std::uint32_t hamiltonian, integrator;
    bool rescaled;
    std::vector<double> parameters = default_parameters(hamiltonian);
    double step = module().hamiltonians[hamiltonian].step;
    double escape_radius = 20;
    const Place& place = place_in(module().hamiltonians[hamiltonian].name);
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
        job.hamiltonian = hamiltonian, job.integrator = integrator, job.parameters = parameters.data(),
        job.rescaled = rescaled;
        job.step = step, job.max_steps = max_steps, job.escape_radius = escape_radius, job.parameter_limit = infinity;
        job.bends_within = module().bends_within(hamiltonian, parameters.data());
        job.tolerance = 1e-6, job.hit = HitModel::hermite, job.outputs = output_energy | output_parameter,
        job.rays = rays.data();
        Traced run{std::vector<RayEnd>(rays.size()), {}};
        const Tile tile{0, 0, static_cast<std::uint32_t>(rays.size()), 1};
        kernel.trace(&job, &tile, run.ends.data(), &run.counters);
        return run;
    }
    /// A fan of rays from one place; in open space they pass the origin at various distances.
    std::vector<RayStart> fan(std::uint32_t n) const {
        std::vector<RayStart> rays(n);
        const double far[3] = {-7, 0.5, 0.25}, *q = place.hamiltonian.empty() ? far : place.q;
        for (std::uint32_t i = 0; i < n; ++i) {
            const double d[3] = {1, 1.25 * (i + 0.5) / n - 0.5, 0.3};
            EXPECT_EQ(module().start(hamiltonian, parameters.data(), q, d, &rays[i]), Failure::none);
        }
        return rays;
    }
};

/// All Hamiltonian × integrator that the kernel serves.
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

/// A random selection in which each Hamiltonian and each kind of step, with and without step control, occurs at least
/// once.
std::vector<Space> sample_of(const std::vector<Space>& spaces, unsigned seed) {
    std::vector<std::size_t> order(spaces.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::shuffle(order.begin(), order.end(), std::mt19937(seed));
    std::set<std::uint32_t> hamiltonians;
    std::set<std::pair<Kind, bool>> kinds;
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

/// Calls check(space, kernel) for every Hamiltonian × integrator that serves it × kernel that serves both, except that
/// gangs take a sample.
///
/// The kernels are packets and scalar code in double and float, which serve all spaces, and those of other widths and
/// one ray per vector. A gang calls the step code of packets, which its own kernel tests in full, and adds a loop over
/// packets. That loop depends on the Hamiltonian (edges, captures, creases) and on the kind of step (rejected and
/// unsolved steps), but not on their combination. The sample of each gang therefore contains each Hamiltonian and each
/// kind of step; the combinations differ from gang to gang. The whole product takes minutes: KAGERO_EVERY_COMBINATION=1
/// in the environment, as in .ci/extra.
template <class Check>
void for_everything(const Check& check) {
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

/// One status, a reason exactly where it failed, and numbers where a ray has arrived.
void expect_clean(const RayEnd& e) {
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

struct Rough {
    const char* what;
    RayStart start;
    bool must_fail;
};
std::vector<Rough> rough_starts(const RayStart& healthy) {
    std::vector<Rough> all;
    const auto add = [&](const char* what, bool must_fail, auto change) {
        all.push_back({what, healthy, must_fail});
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

TEST(RoughRays, EndInAStatusAndMoveNoOtherRay) {
    for_everything([](const Space& space, const KernelInfo& kernel) {
        const std::uint32_t n = std::max(kernel.lanes, 2u);
        const auto healthy = space.fan(n);
        const Traced expected = space.trace(kernel, healthy);
        for (const RayEnd& e : expected.ends) {
            // Eq. (9) and what is printed on top of it have no solution where the step is too long for it: a clean
            // failure. Near the end of the mirage, where 1/n grows without bound, compositions with long negative parts
            // may have none either. Far out in the fisheye H is hardly larger than what Verlet, or a method with a
            // tolerance, has lost of it further in.
            const IntegratorInfo& method = module().integrators[space.integrator];
            const bool rough_in_fisheye = space.is("fisheye") && (method.order == 2 || method.adaptive);
            if (method.order > 1 && !space.is("mirage") && !rough_in_fisheye) {
                EXPECT_NE(e.status, Status::failed);
            }
            EXPECT_TRUE(finite_state(e) && std::isfinite(e.energy_error));
            // The last step is cut in a few corrections, each of which gains at least a digit.
            // (A medium may end before the escape sphere does.)
            if (e.status == Status::escaped) {
                EXPECT_LE(distance(e), (1 + 1e-5) * space.escape_radius);
            }
        }
        std::uint32_t at = 0;
        for (const Rough& rough : rough_starts(healthy[0])) {
            SCOPED_TRACE(rough.what);
            auto rays = healthy;
            at = (at + 1) % n;
            rays[at] = rough.start;
            const Traced run = space.trace(kernel, rays);
            for (std::uint32_t i = 0; i < n; ++i)
                if (i != at) expect_same(run.ends[i], expected.ends[i]);
            const RayEnd& end = run.ends[at];
            EXPECT_TRUE(end.status == Status::failed || !rough.must_fail);
            expect_clean(end);
        }
    });
}

// A lane whose ray has failed must hold something harmless: its packet may iterate for it in its own tries alone.
TEST(RoughRays, CostTheirNeighboursNothingOnceTheyHaveFailed) {
    for_everything([](Space space, const KernelInfo& kernel) {
        if (kernel.lanes == 1) return;
        space.step /= 16;
        auto rays = space.fan(kernel.lanes);
        const Traced expected = space.trace(kernel, rays);
        rays[1].q[1] = nan;
        const Traced run = space.trace(kernel, rays);
        constexpr std::uint64_t tries = 9, iterations = 60, most_solves_per_step = 18;
        const std::uint64_t own_tries = tries * iterations * most_solves_per_step * kernel.lanes;
        EXPECT_LE(run.counters.issued_iterations, expected.counters.issued_iterations + own_tries);
    });
}

// Steps far too long to be solved are halved, then given up: a status, never a hang or an unsolved state.
TEST(RoughRays, HugeStepsEndInAStatus) {
    for_everything([](Space space, const KernelInfo& kernel) {
        for (const double factor : {30.0, 1e4, 1e12}) {
            SCOPED_TRACE(factor);
            space.step = factor * module().hamiltonians[space.hamiltonian].step;
            // Long gangs are not filled: each of their packets retries its own steps.
            const Traced run = space.trace(kernel, space.fan(std::clamp(kernel.lanes, 8u, 40u)));
            for (const RayEnd& e : run.ends) {
                EXPECT_LE(e.steps, space.max_steps);
                EXPECT_NE(e.status, Status::hit);
                expect_clean(e);
            }
        }
    });
}

// A start that was refused before is handed through with its reason.
TEST(RoughRays, RefusedStartsKeepTheirReason) {
    for_everything([](const Space& space, const KernelInfo& kernel) {
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
