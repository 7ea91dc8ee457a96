// Tests the tracing loop with events that are defined in this file, in the space `gradient`. The rays of this space are
// parabolas, q = q0 + p0 τ − ẑ g τ²/4, so that all ends are known in closed form.
#include "tests/kernels/spaces.h"

#include "kernels/trace/packets.h"
#include "kernels/trace/trace_tile.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>
#include <vector>

namespace kagero::test {
namespace {

/// The x coordinates of the planes, and the parameter g of the space.
constexpr double far_plane = 2.5, near_plane = 2.0, mirror_plane = -1.5, gradient_g = 0.1,
                 infinity = std::numeric_limits<double>::infinity();
bool near_plane_exists, mirror_exists;  // set by each test

/// Event that ends rays at x = 2.5.
struct FarPlane : ValueEvent<FarPlane> {
    static constexpr Status status = Status::escaped;
    template <class V>
    static bool exists(const Task<V>&) { return true; }
    template <class V>
    static V value(const RayState<V>&, const RayState<V>& at) { return V(ScalarOf<V>(far_plane)) - at.q().x; }
};
/// Event that ends rays at x = 2.
struct NearPlane : ValueEvent<NearPlane> {
    static constexpr Status status = Status::captured;
    template <class V>
    static bool exists(const Task<V>&) { return near_plane_exists; }
    template <class V>
    static V value(const RayState<V>&, const RayState<V>& at) { return V(ScalarOf<V>(near_plane)) - at.q().x; }
};
/// Event that reflects rays at x = −1.5.
struct Mirror : ValueEvent<Mirror> {
    static constexpr Effect effect = Effect::resume;
    template <class V>
    static bool exists(const Task<V>&) { return mirror_exists; }
    template <class V>
    static V value(const RayState<V>&, const RayState<V>& at) { return at.q().x - V(ScalarOf<V>(mirror_plane)); }
    template <class V>
    static void resume(const Task<V>&, RayState<V>& at, std::uint64_t lanes) {
        at.y[component_px] = select(from_bits<V>(lanes), -at.y[component_px], at.y[component_px]);
    }
};

/// A list of events, preceded by the events of this file.
template <class List>
struct WithPlanes;
template <class... Event>
struct WithPlanes<EventList<Event...>> {
    using type = EventList<FarPlane, NearPlane, Mirror, Event...>;
};
using TestEvents = WithPlanes<AllEvents>::type;

/// Returns the index of an integrator in the module; throws if there is none with this name.
std::uint32_t integrator_named(const std::string& name) {
    const Module& module = *kagero_kernels();
    for (std::uint32_t i = 0; i < module.integrator_count; ++i)
        if (name == module.integrators[i].name) return i;
    throw std::runtime_error(name);
}

/// Traces rays with the events of this test and returns their ends.
template <class V>
std::vector<RayEnd> trace_rays(const std::vector<RayStart>& rays, const char* method, double step,
                               double parameter_limit) {
    const double parameters[] = {1.0, gradient_g};
    Job job{};
    job.hamiltonian = index_of<hamiltonians::Gradient>();
    job.integrator = integrator_named(method);
    job.parameters = parameters;
    job.step = step;
    job.tolerance = 1e-12;
    job.max_steps = 10000;
    job.escape_radius = 20;
    job.parameter_limit = parameter_limit;
    job.hit = HitModel::hermite;
    job.use_symmetry = true;
    job.refill = true;
    job.rays = rays.data();
    job.outputs = output_energy | output_parameter;
    std::vector<RayEnd> ends(rays.size());
    Counters counters{};
    const Task<V> task(job, space_kernel<hamiltonians::Gradient, V>(false), false);
    trace_tile<V, TestEvents>(task, {0, 0, static_cast<std::uint32_t>(rays.size()), 1}, ends.data(), counters);
    return ends;
}

/// Returns 75 rays that start near the origin and move towards larger x (sign = 1) or smaller x (sign = −1).
std::vector<RayStart> rays_along_x(double sign) {
    Random random(7);
    std::vector<RayStart> rays(75);
    for (RayStart& ray : rays) {
        ray = {};
        for (double& x : ray.q) x = random(-0.4, 0.4);
        const double n = std::sqrt(1 - gradient_g * ray.q[2]);
        Vec3<double> d{sign * random(0.3, 1), random(-0.5, 0.5), random(-0.5, 0.5)};
        d = (n / norm(d)) * d;
        ray.p[0] = d.x;
        ray.p[1] = d.y;
        ray.p[2] = d.z;
    }
    return rays;
}

/// Compares the end of a ray with its parabola at the parameter τ, reflected at the mirror if `reflected` is set.
void expect_on_parabola(const RayStart& ray, const RayEnd& end, double tau, bool reflected) {
    const double tolerance = 2e-12 * (1 + tau), x = ray.q[0] + ray.p[0] * tau;
    EXPECT_NEAR(end.parameter, tau, tolerance);
    EXPECT_NEAR(end.q[0], reflected ? 2 * mirror_plane - x : x, tolerance);
    EXPECT_NEAR(end.q[1], ray.q[1] + ray.p[1] * tau, tolerance);
    EXPECT_NEAR(end.q[2], ray.q[2] + ray.p[2] * tau - gradient_g * tau * tau / 4, tolerance);
    EXPECT_NEAR(end.p[0], reflected ? -ray.p[0] : ray.p[0], tolerance);
    EXPECT_NEAR(end.p[2], ray.p[2] - gradient_g * tau / 2, tolerance);
}

class PlaneEvents : public ::testing::TestWithParam<const char*> {
protected:
    void SetUp() override { near_plane_exists = mirror_exists = false; }
};

TEST_P(PlaneEvents, RaysEndOnThePlane) {
    const std::vector<RayStart> rays = rays_along_x(1);
    for (const double step : {0.05, 0.7, 9.0}) {  // with the step 9.0, the first step crosses the plane
        SCOPED_TRACE(step);
        const std::vector<RayEnd> ends = trace_rays<PacketDouble>(rays, GetParam(), step, infinity);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            ASSERT_EQ(ends[i].status, Status::escaped) << i;
            EXPECT_NEAR(ends[i].q[0], far_plane, 1e-12);
            expect_on_parabola(rays[i], ends[i], (far_plane - rays[i].q[0]) / rays[i].p[0], false);
        }
    }
}

TEST_P(PlaneEvents, EarliestEventOfAStepEndsTheRay) {
    near_plane_exists = true;  // NearPlane is nearer to the starts, but FarPlane precedes it in the list
    const std::vector<RayStart> rays = rays_along_x(1);
    for (const double step : {0.05, 9.0}) {
        SCOPED_TRACE(step);
        const std::vector<RayEnd> ends = trace_rays<PacketDouble>(rays, GetParam(), step, infinity);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            ASSERT_EQ(ends[i].status, Status::captured) << i;
            expect_on_parabola(rays[i], ends[i], (near_plane - rays[i].q[0]) / rays[i].p[0], false);
        }
    }
}

TEST_P(PlaneEvents, RaysContinueAfterReflection) {
    mirror_exists = true;
    const std::vector<RayStart> rays = rays_along_x(-1);
    constexpr double length = 6;
    for (const double step : {0.05, 0.7}) {
        SCOPED_TRACE(step);
        const std::vector<RayEnd> ends = trace_rays<PacketDouble>(rays, GetParam(), step, length);
        int at_far_plane = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const double to_mirror = (mirror_plane - rays[i].q[0]) / rays[i].p[0],
                         to_plane = to_mirror + (far_plane - mirror_plane) / -rays[i].p[0];
            at_far_plane += to_plane < length;
            ASSERT_EQ(ends[i].status, to_plane < length ? Status::escaped : Status::step_limit) << i;
            expect_on_parabola(rays[i], ends[i], std::min(to_plane, length), to_mirror < length);
        }
        EXPECT_GT(at_far_plane, 10);
        EXPECT_LT(at_far_plane, 65);
    }
}

// The ends of rays that are traced in packets are compared with the ends of the same rays, traced one at a time.
TEST_P(PlaneEvents, ResultsDoNotDependOnOtherRaysOfThePacket) {
    near_plane_exists = mirror_exists = true;
    std::vector<RayStart> rays = rays_along_x(1);
    const std::vector<RayStart> reversed_rays = rays_along_x(-1);
    rays.insert(rays.begin() + 30, reversed_rays.begin(), reversed_rays.end());
    const std::vector<RayEnd> packets = trace_rays<PacketDouble>(rays, GetParam(), 0.3, 6);
    std::set<Status> statuses;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const RayEnd single = trace_rays<PacketDouble>({rays[i]}, GetParam(), 0.3, 6)[0];
        EXPECT_EQ(single.status, packets[i].status) << i;
        EXPECT_EQ(std::memcmp(single.q, packets[i].q, sizeof single.q) |
                      std::memcmp(single.p, packets[i].p, sizeof single.p),
                  0)
            << i;
        EXPECT_EQ(single.steps, packets[i].steps) << i;
        EXPECT_EQ(single.gradients, packets[i].gradients) << i;
        statuses.insert(single.status);
    }
    EXPECT_EQ(statuses.size(), 2u);
}

INSTANTIATE_TEST_SUITE_P(Methods, PlaneEvents, ::testing::Values("verlet", "gauss8", "rk4", "dp54"));

}  // namespace
}  // namespace kagero::test
