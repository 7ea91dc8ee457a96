// Momenta at surfaces: α in p' = p + α n from H, compared with closed forms for several kinds of H, and properties that
// hold for every Hamiltonian.
#include "tests/kernels/spaces.h"

#include "kernels/interaction/normal_momentum.h"
#include "kernels/simd/bits.h"
#include "kernels/simd/lane_memory.h"
#include "kernels/trace/packets.h"

#include <numbers>

namespace kagero::test {
namespace {

using V = PacketDouble;
constexpr int W = lane_count<V>;

/// H along a line in momentum space as a closed form, for the solver.
template <class H>
double alpha_of(const H& h, double scale, bool& exists) {
    const auto at = [&](const V& s) {
        NormalLine<V> line{V(0.0), V(0.0), V(0.0)};
        for (int i = 0; i < W; ++i) {
            const std::array<double, 3> values = h(get_lane(s, i));
            set_lane(line.value, i, values[0]);
            set_lane(line.slope, i, values[1]);
            set_lane(line.curvature, i, values[2]);
        }
        return line;
    };
    const V typical(scale);
    const NormalMomentum<V> solution = NormalMomentumSolver<V, decltype(at)>(at, typical).solve();
    exists = to_bits(solution.exists) & 1;
    EXPECT_EQ(to_bits(solution.exists), exists ? to_bits(all_lanes<V>()) : 0);
    return get_lane(solution.alpha, 0);
}

/// H = (|p|² − N²)/2 along the normal: the normal part of the momentum is c + s, the tangential part t.
auto index_medium(double c, double t, double index) {
    return [=](double s) {
        const double p = c + s;
        return std::array{0.5 * (p * p + t * t - index * index), p, 1.0};
    };
}

TEST(NormalMomentum, RefractsByTheLawOfSnell) {
    for (const double from : {1.0, 1.5})
        for (const double to : {1.0, 1.33, 1.5, 2.4})
            for (const double degrees : {0.0, 1e-6, 10.0, 30.0, 41.0, 45.0, 60.0, 80.0, 89.0, 89.9}) {
                const double angle = degrees * std::numbers::pi / 180, t = from * std::sin(angle),
                             c = from * std::cos(angle);
                bool exists;
                const double alpha = alpha_of(index_medium(c, t, to), from, exists);
                ASSERT_EQ(exists, t < to) << from << " to " << to << " at " << degrees;
                if (exists) {
                    EXPECT_NEAR(c + alpha, std::sqrt((to - t) * (to + t)), 1e-14 * to) << degrees;
                }
                const double reflected = alpha_of(index_medium(-c, t, from), from, exists);
                ASSERT_TRUE(exists);
                EXPECT_NEAR(reflected - c, c, 1e-14) << degrees;
            }
}

TEST(NormalMomentum, FindsTheCriticalAngle) {
    const double critical = std::asin(1 / 1.5);
    for (const double offset : {-1e-3, -1e-6, -1e-9, 1e-9, 1e-6, 1e-3}) {
        const double t = 1.5 * std::sin(critical + offset), c = 1.5 * std::cos(critical + offset);
        bool exists;
        const double alpha = alpha_of(index_medium(c, t, 1), 1.5, exists);
        EXPECT_EQ(exists, offset < 0) << offset;
        // The normal part is √(1 − t²). It changes by the rounding error of t², divided by the normal part.
        if (exists) {
            EXPECT_NEAR(c + alpha, std::sqrt((1 - t) * (1 + t)), 1e-15 / std::sqrt(-offset)) << offset;
        }
    }
}

/// H = ±(|p|⁴ − N⁴)/4: the same rays as in index_medium, but H is not quadratic.
auto quartic(double c, double t, double index, double sign) {
    return [=](double s) {
        const double p = c + s, q = p * p + t * t;
        return std::array{sign * 0.25 * (q * q - std::pow(index, 4)), sign * q * p, sign * (q + 2 * p * p)};
    };
}

TEST(NormalMomentum, SolvesForAnHThatIsNotQuadratic) {
    for (const double sign : {1.0, -1.0})
        for (const double to : {1.0, 1.33, 1.5, 2.4})
            for (const double degrees : {0.0, 10.0, 30.0, 41.0, 41.81, 60.0, 80.0, 89.9}) {
                const double angle = degrees * std::numbers::pi / 180, t = 1.5 * std::sin(angle),
                             c = 1.5 * std::cos(angle);
                SCOPED_TRACE(testing::Message() << sign << " to " << to << " at " << degrees);
                bool exists;
                const double alpha = alpha_of(quartic(sign * c, t, to, sign), 1.5, exists);
                ASSERT_EQ(exists, t < to);
                if (exists) {
                    EXPECT_NEAR(sign * (sign * c + alpha), std::sqrt((to - t) * (to + t)), 1e-13);
                }
                const double reflected = alpha_of(quartic(-sign * c, t, 1.5, sign), 1.5, exists);
                ASSERT_TRUE(exists);
                EXPECT_NEAR(sign * (reflected - sign * c), c, 1e-13);
            }
}

TEST(NormalMomentum, SolvesForALinearH) {
    bool exists;
    const auto line = [](double slope) { return [=](double s) { return std::array{slope * s - 0.25, slope, 0.0}; }; };
    EXPECT_NEAR(alpha_of(line(2), 1, exists), 0.125, 1e-16);
    EXPECT_TRUE(exists);
    alpha_of(line(-2), 1, exists);  // the ray would move to the other side
    EXPECT_FALSE(exists);
}

template <class H>
class ContinuationsOf : public testing::Test {};
TYPED_TEST_SUITE(ContinuationsOf, AllHamiltonians, HamiltonianName);

/// Returns random rays of a Hamiltonian that move toward a surface with a random normal.
template <class H>
std::vector<SurfaceRay> rays_at_surfaces(std::size_t count) {
    const auto parameters = default_parameters<H>();
    const System<H, false, double> system(parameters.data());
    Random random(11);
    std::vector<SurfaceRay> rays;
    for (const RayStart& start : random_rays<H>(count, 7)) {
        SurfaceRay ray{{start.q[0], start.q[1], start.q[2]}, {start.p[0], start.p[1], start.p[2]}, start.pt, {}, false};
        const Vec3<double> n{random(-1, 1), random(-1, 1), random(-1, 1)};
        const double scale = (dot(n, system.gradient_p(state_of<double>(start))) > 0 ? -1 : 1) / norm(n);
        ray.normal[0] = n.x * scale;
        ray.normal[1] = n.y * scale;
        ray.normal[2] = n.z * scale;
        rays.push_back(ray);
    }
    return rays;
}

/// Returns the continuations of rays in the space H.
template <class H>
std::vector<Continuation> continued(const std::vector<SurfaceRay>& rays) {
    std::vector<Continuation> continuations(rays.size());
    const auto parameters = default_parameters<H>();
    kagero_kernels()->continue_rays(index_of<H>(), parameters.data(), rays.data(),
                                    static_cast<std::uint32_t>(rays.size()), continuations.data());
    return continuations;
}

// A ray that is reflected twice at the same surface, from both sides, has its first momentum again. A ray that passes
// into its own space keeps its momentum.
TYPED_TEST(ContinuationsOf, TwoReflectionsCancel) {
    std::vector<SurfaceRay> rays = rays_at_surfaces<TypeParam>(37);
    const std::vector<Continuation> reflected = continued<TypeParam>(rays);
    std::vector<SurfaceRay> back = rays, through = rays;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        ASSERT_TRUE(reflected[i].exists);
        const double* v = reflected[i].velocity;
        EXPECT_GT(v[0] * rays[i].normal[0] + v[1] * rays[i].normal[1] + v[2] * rays[i].normal[2], 0);
        for (int k = 0; k < 3; ++k) {
            back[i].p[k] = reflected[i].p[k];
            back[i].normal[k] = through[i].normal[k] = -rays[i].normal[k];
        }
    }
    const std::vector<Continuation> twice = continued<TypeParam>(back), same = continued<TypeParam>(through);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        ASSERT_TRUE(twice[i].exists && same[i].exists);
        // A rounding error of H changes α by that error divided by the slope of H along the normal.
        const double size = std::hypot(reflected[i].p[0], reflected[i].p[1], reflected[i].p[2]) +
                            std::hypot(rays[i].p[0], rays[i].p[1], rays[i].p[2]);
        const double* v = reflected[i].velocity;
        const double slope = v[0] * rays[i].normal[0] + v[1] * rays[i].normal[1] + v[2] * rays[i].normal[2],
                     conditioning = std::max(1.0, std::hypot(v[0], v[1], v[2]) / slope);
        for (int k = 0; k < 3; ++k) {
            EXPECT_NEAR(twice[i].p[k], rays[i].p[k], 1e-14 * size * conditioning);
            EXPECT_NEAR(same[i].p[k], rays[i].p[k], 1e-14 * size * conditioning);
        }
    }
}

// The momentum of a reflected ray solves H = H0 together with its velocity: a ray that starts with this velocity has
// the same momentum. The start of a ray solves other equations, for p and the length of the velocity.
TYPED_TEST(ContinuationsOf, ReflectedRaysAreRaysOfTheSpace) {
    using System = kagero::System<TypeParam, false, double>;
    const auto parameters = default_parameters<TypeParam>();
    const System system(parameters.data());
    const std::vector<SurfaceRay> rays = rays_at_surfaces<TypeParam>(37);
    const std::vector<Continuation> reflected = continued<TypeParam>(rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        State<double> s;
        for (int k = 0; k < 3; ++k) {
            s.y[k] = rays[i].q[k];
            s.y[momentum(k)] = reflected[i].p[k];
        }
        s.pt() = rays[i].pt;
        const Vec3<double> v = system.gradient_p(s);
        const double direction[3] = {v.x, v.y, v.z};
        RayStart start;
        ASSERT_EQ(kagero_kernels()->start(index_of<TypeParam>(), parameters.data(), rays[i].q, direction, &start),
                  Failure::none);
        const double size = std::hypot(start.p[0], start.p[1], start.p[2]);
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(start.p[k], reflected[i].p[k], 1e-11 * size);
    }
}

}  // namespace
}  // namespace kagero::test
