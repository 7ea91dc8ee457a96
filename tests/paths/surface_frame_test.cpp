// Tests of the rest frame of diffuse surfaces in strong fields, against the metric.
#include "tests/support/plan_fixture.h"

#include "paths/surface_frame.h"
#include "scene/vector3.h"
#include "spaces/rest_frame.h"

#include <gtest/gtest.h>

namespace kagero::test {
namespace {

using Vector4 = std::array<double, 4>;

/// Returns g^{ab} p_b, by elimination without pivoting.
Vector4 raised(SpacetimeMatrix g, Vector4 p) {
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t k = 0; k < 4; ++k) {
            if (k == i) continue;
            const double factor = g[k][i] / g[i][i];
            for (std::size_t a = 0; a < 4; ++a) g[k][a] -= factor * g[i][a];
            p[k] -= factor * p[i];
        }
    for (std::size_t i = 0; i < 4; ++i) p[i] /= g[i][i];
    return p;
}

double product_of(const Vector4& a, const Vector4& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]; }

// Null momenta p, p' that belong to unit directions d, d' of the frame have p · p' = ω² (d · d' − 1), where ω is the
// frequency for matter at rest. The angle of a ray from the conormal is that of its direction from the normal.
TEST(SurfaceFrame, IsTheRestFrameOfTheStaticObserver) {
    const std::vector<std::string> spaces{
        "hamiltonian = \"flat\"\n", "hamiltonian = \"schwarzschild\"\nrg = 1\n",
        "hamiltonian = \"kerr\"\nmass = 0.5\nspin = 0.45\n",
        "hamiltonian = \"formula\"\nH = \"(px^2 + 2*(py + 0.2*pt)^2 + pz^2 - 1.5*pt^2)/2\"\n"
        "[space.constants]\npt = 1\n"};
    const Double3 position{2.2, 1.8, 0.8}, normal = unit({0.3, -0.5, 0.8});
    const std::vector<Double3> directions{unit({0.1, -0.4, 1}), unit({1, 0, 0.5}), unit({-0.2, -1, 0.1})};
    for (const std::string& space : spaces) {
        const auto plan = plan_of_text("[space]\n" + space +
                                           "[camera]\nposition = [4, 4, 4]\nlook_at = [0, 0, 0]\n"
                                           "[film]\nsize = [4, 4]\n",
                                       {});
        SpacetimeMatrix g;
        const double q[3] = {position[0], position[1], position[2]};
        if (metric_at(plan->scene->space, q, g) != Failure::none) continue;
        const double pt = null_ray_sign(*plan->scene), frequency = 1 / std::sqrt(-g[3][3]);
        const DiffusePoint point{0, 0, 0, position, normal, normal, pt};
        SurfaceFrames frames(*plan);
        const SurfaceFrame& frame = frames.at({&point, 1})[0];
        ASSERT_TRUE(frame.exists()) << space;
        std::vector<Vector4> momenta;
        for (const Double3& d : directions) {
            const RayStart start = frame.start_along(d);
            momenta.push_back({start.p[0], start.p[1], start.p[2], start.pt});
            ASSERT_FALSE(start.ingoing);  // the momentum is that of the coordinates of the scene
            EXPECT_EQ(std::abs(start.pt), 1) << space;
        }
        const Vector4 conormal{normal[0], normal[1], normal[2], 0};
        const double length_of_normal = std::sqrt(product_of(conormal, raised(g, conormal)));
        for (std::size_t i = 0; i < 3; ++i) {
            const Vector4 k = raised(g, momenta[i]);
            for (std::size_t j = 0; j < 3; ++j)
                EXPECT_NEAR(product_of(k, momenta[j]), frequency * frequency * (dot(directions[i], directions[j]) - 1),
                            1e-9)
                    << space;
            EXPECT_NEAR(product_of(k, conormal) / length_of_normal / frequency, dot(directions[i], frame.normal()),
                        1e-9)
                << space;
        }
    }
}

}  // namespace
}  // namespace kagero::test
