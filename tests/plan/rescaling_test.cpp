// Tests of time rescaling by an expression of the scene, which must not change rays or pictures of a built-in space.
#include "tests/support/plan_fixture.h"

#include "error.h"
#include "film/film.h"
#include "render/render.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kagero::test {
namespace {

const std::string view_text = "\n[camera]\nposition = [-3, 0.5, 0.25]\nlook_at = [0, 0, 0]\n[film]\nsize = [12, 8]\n";

std::vector<RayInput> fan(const Double3& origin) {
    std::vector<RayInput> rays;
    for (int i = 0; i < 37; ++i) rays.push_back({origin, {1, 0.04 * i - 0.9, 0.3 - 0.01 * i}});
    return rays;
}

std::vector<RayEnd> traced(const std::string& space, const Overrides& overrides, const std::string& strategy,
                           const std::vector<RayInput>& rays) {
    const auto plan =
        plan_of_text("[space]\nhamiltonian = " + space + view_text, overrides, with_strategy(strategy), false);
    std::vector<RayEnd> ends;
    trace(*plan, start_rays(*plan, rays), ends);
    return ends;
}

std::string refusal(const std::string& space, const Overrides& overrides) {
    try {
        plan_of_text("[space]\nhamiltonian = " + space + view_text, overrides, with_strategy("packet"));
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

/// Compares position, direction and λ of two ray ends. Errors of position and λ are relative to 1 plus the absolute
/// value.
void expect_close(const RayEnd& a, const RayEnd& b, double tolerance) {
    for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(a.q[k], b.q[k], tolerance * (1 + std::abs(a.q[k])));
        EXPECT_NEAR(a.v[k], b.v[k], tolerance);
    }
    EXPECT_NEAR(a.parameter, b.parameter, tolerance * (1 + a.parameter));
}

Overrides with(Overrides overrides, const std::string& more) {
    overrides.push_back(more);
    return overrides;
}

// The function that captures rays of `kerr` is NaN on some rays that move towards the centre of the hole. Such a ray is
// not captured there, with or without an expression.
TEST(Rescaling, KeepsRaysWhoseCaptureFunctionIsUndefined) {
    const std::string camera =
        "\n[camera]\nposition = [0, -30, 4.5]\nlook_at = [0, 0, -0.4]\nup = [0, 0, 1]\n[film]\nsize = [16, 16]\n";
    const auto ends_with = [&](const Overrides& overrides) {
        const auto plan = plan_of_text("[space]\nhamiltonian = \"kerr\"\nspin = 0.95\n" + camera,
                                       with(overrides, "integrator.method=gauss8"), with_strategy("scalar"));
        std::vector<RayStart> starts;
        for (std::uint32_t y = 0; y < 16; ++y)
            for (std::uint32_t x = 0; x < 16; ++x) starts.push_back(pixel_ray_start(*plan, x, y));
        std::vector<RayEnd> ends;
        trace(*plan, starts, ends);
        return ends;
    };
    const std::vector<RayEnd> without = ends_with({"integrator.rescale=none"}),
                              with_expression = ends_with({"integrator.rescale=\"1\""});
    for (std::size_t i = 0; i < without.size(); ++i) EXPECT_EQ(with_expression[i].status, without[i].status) << i;
}

// The expression is the default rescaling of the space. With the compiled rescaling and with the expression, rays must
// take the same steps. The ray ends differ only because the roundings occur in a different order.
TEST(Rescaling, HasTheRaysOfTheDefaultRescalingForTheSameExpression) {
    struct Case {
        const char *space, *rescale, *method;
        Double3 origin;
    };
    for (const Case& c : {Case{"\"schwarzschild\"\nrg = 0.5\n", "r", "gauss8", {-7, 0.5, 0.25}},
                          Case{"\"schwarzschild\"\nrg = 0.5\n", "sqrt(x^2 + y^2 + z^2)", "dp5", {-7, 0.5, 0.25}},
                          Case{"\"mirage\"\n", "1/(0.85 - 0.3*z^3 + 0.03*cos(3*pi*x))", "srkn6", {0, 0, 0}}}) {
        const Overrides overrides{std::string("integrator.method=") + c.method, "integrator.step=0.1",
                                  "integrator.escape_radius=9"};
        for (const char* strategy : {"packet", "scalar"}) {
            SCOPED_TRACE(std::string(c.space) + c.rescale + ", " + strategy);
            const auto rays = fan(c.origin);
            const auto a = traced(c.space, overrides, strategy, rays);
            const auto b = traced(c.space, with(overrides, std::string("integrator.rescale=\"") + c.rescale + '"'),
                                  strategy, rays);
            std::size_t compared = 0;
            for (std::size_t i = 0; i < a.size(); ++i) {
                ASSERT_EQ(a[i].status, b[i].status) << i;
                EXPECT_EQ(a[i].steps, b[i].steps) << i;
                if (a[i].status == Status::captured) continue;
                expect_close(a[i], b[i], 1e-11);
                ++compared;
            }
            EXPECT_GE(compared, 20u);
        }
    }
}

// The ends of rays with and without rescaling are compared: status, position, direction and λ. The tolerance covers the
// errors of the steps, which the rays magnify.
TEST(Rescaling, DoesNotChangeRayEnds) {
    const char* spaces[] = {"\"kerr\"\nmass = 0.25\nspin = 0.6\n",
                            "\"schwarzschild\"\nrg = 0.5\n",
                            "\"wormhole\"\n",
                            "\"duct\"\n",
                            "\"fisheye\"\n",
                            "\"layer\"\n",
                            "\"shimmer\"\n"};
    for (const char* space : spaces)
        for (const char* rescale : {"1 + 0.1*r", "2 + sin(x)"}) {
            SCOPED_TRACE(std::string(space) + rescale);
            const auto rays = fan({-3, 0.5, 0.25});
            const Overrides fine{"integrator.method=dp54", "integrator.tolerance=1e-11", "integrator.escape_radius=4"};
            const auto a = traced(space, with(fine, "integrator.rescale=none"), "packet", rays);
            const auto b =
                traced(space, with(fine, std::string("integrator.rescale=\"") + rescale + '"'), "packet", rays);
            for (std::size_t i = 0; i < a.size(); ++i) {
                ASSERT_EQ(a[i].status, b[i].status) << i;
                if (a[i].status != Status::escaped) continue;
                expect_close(a[i], b[i], 2e-7);
            }
        }
}

// The redshift depends on the observer and on the orbits of the matter of the disk. Rescaling must
// change neither.
TEST(Rescaling, DoesNotChangeStatusOrRedshift) {
    const std::string scene =
        "[space]\nhamiltonian = \"kerr\"\nmass = 0.25\nspin = 0.6\n"
        "[camera]\nposition = [0, -6, 1]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\nfov = 50\nobserver = \"zamo\"\n"
        "[film]\nsize = [24, 16]\nlayers = [\"color\", \"status\", \"redshift\"]\n"
        "[[object]]\nname = \"disk\"\nshape = \"disk\"\ncenter = [0, 0, 0]\nnormal = [0, 0, 1]\ninner = 1.2\nouter = "
        "3\ntemperature = 6000\n";
    const auto picture = [&](const Overrides& overrides) {
        const auto plan = plan_of_text(scene, overrides, with_strategy("packet"));
        Film film(24, 16, plan->description().film.layers);
        render(*plan, film);
        return film;
    };
    const Overrides fine{"integrator.method=dp54", "integrator.tolerance=1e-10"};
    const Film a = picture(fine), b = picture(with(fine, "integrator.rescale=\"r\""));
    std::size_t disk_pixels = 0;
    for (std::size_t i = 0; i < 24 * 16; ++i) {
        ASSERT_EQ(a.plane("status")[i], b.plane("status")[i]) << i;
        EXPECT_NEAR(a.plane("redshift")[i], b.plane("redshift")[i], 1e-5) << i;
        disk_pixels += a.plane("status")[i] == 0 && a.plane("redshift")[i] > 0;
    }
    EXPECT_GE(disk_pixels, 50u);
}

// Ω is the expression of the scene. With Ω < 0 a ray would be traced backward. Rays that start where Ω ≤ 0 must fail.
TEST(Rescaling, MustBePositive) {
    const std::string built_in = "\"kerr\"\nmass = 0.25\nspin = 0.6\n",
                      formula = "\"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - 1)\"\n";
    for (const std::string& space : {built_in, formula})
        for (const char* strategy : {"packet", "scalar"}) {
            const std::vector<RayInput> inward{{{5, -3, 0.1}, {-1, 0, 0}}, {{5, -2, 0.1}, {-1, 0.1, 0}}},
                outward{{{5, -3, 0.1}, {1, 0, 0}}};
            for (const RayEnd& end : traced(space, {"integrator.rescale=-r"}, strategy, inward))
                EXPECT_EQ(end.failure, Failure::bad_time_rescaling);
            // A ray approaches Ω = 0 in infinitely many steps.
            for (const RayEnd& end :
                 traced(space, {"integrator.rescale=x", "integrator.max_steps=500"}, strategy, inward))
                EXPECT_TRUE(end.status == Status::failed || end.status == Status::step_limit);
            for (const RayEnd& end : traced(space, {"integrator.rescale=x"}, strategy, outward))
                EXPECT_EQ(end.status, Status::escaped);
        }
    for (const std::string& space : {built_in, formula})
        EXPECT_NE(refusal(space, {"integrator.rescale=-r"})
                      .find("integrator.rescale = \"-r\" is not greater than 0 at camera.position"),
                  std::string::npos);
}

TEST(Rescaling, RefusesWrongExpressionsAndUnsupportedMethods) {
    EXPECT_NE(refusal("\"luneburg\"\n", {"integrator.rescale=r"})
                  .find("integrator.rescale: the gradient of its H is discontinuous"),
              std::string::npos);
    EXPECT_NE(refusal("\"kerr\"\n", {"integrator.rescale=px"}).find("it may depend only on x y z r theta phi rho"),
              std::string::npos);
    EXPECT_NE(refusal("\"kerr\"\n", {"integrator.rescale=spin"}).find("unknown name spin"), std::string::npos);
    EXPECT_NE(refusal("\"kerr\"\n", {"integrator.rescale=1-3"}).find("greater than 0"), std::string::npos);
    EXPECT_NE(refusal("\"mirage\"\n", {"integrator.rescale=1+z^2", "integrator.method=srkn6"}).find("not of the form"),
              std::string::npos);
    // If the scene states no method, a supported method replaces the default method of the space.
    EXPECT_EQ(refusal("\"mirage\"\n", {"integrator.rescale=1+z^2"}), "");
    EXPECT_EQ(refusal("\"flat\"\n", {"integrator.rescale=r"}), "");
}

}  // namespace
}  // namespace kagero::test
