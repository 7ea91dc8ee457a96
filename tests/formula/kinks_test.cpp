// Tests of formulas whose derivatives jump because of a min, max, abs or where. Steps end just before such a kink and
// pass it in one short step, so that methods keep their order. A formula whose value jumps is reported.
#include "tests/support/plan_fixture.h"
#include "tests/support/program.h"

#include "scene/value.h"
#include "tuning/resolve.h"

#include <gtest/gtest.h>

#include <boost/math/quadrature/gauss.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace kagero::test {
namespace {

/// Returns a scene with a parabolic layer of the ionosphere, 0.6 (1 − (z − 3)²), below and above which there is no
/// plasma. `layer` is this function without the factor 0.6; u is 1 − (z − 3)².
std::string scene_of(const std::string& layer) {
    return "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - 1 + 0.6*" + layer +
           ")\"\nlet = {u = \"1 - (z - 3)^2\"}\n[integrator]\nescape_radius = 12\n[camera]\nposition = [0, 0, 0]\n"
           "look_at = [1, 0, 0.4]\nup = [0, 0, 1]\n[film]\nsize = [16, 12]\n";
}

/// Forms of the layer: with a kink of each kind, with several kinks in one place, and with a `where` whose branches
/// have no value where they are not taken.
const char* const forms[] = {"max(0, u)",
                             "(0.5*(u + abs(u)))",
                             "where(u, u, 0)",
                             "where(-u, 0, u)",
                             "where(u, u, 1e-30*sqrt(0.01 - u))",
                             "where(u, exp(log(u)), 0)",
                             "(0.25*where(u, u, 0) + 0.75*max(u, 0))",
                             "(0.5*max(u, 0) + 0.5*(u - min(0, u)))"};

/// Direction of a ray that leaves the layer, and the point of its line at z = 0 or z = 4.
struct Exit {
    double pz, x;
};

/// Returns the exit of the ray from the origin with the momentum (px, 0, pz), where px² + pz² = 1. In the layer, z − 3
/// is a sum of cosh(kλ) and sinh(kλ) with k² = 0.6. A ray with pz < k is reflected.
Exit exit_of(double px, double pz) {
    const double k = std::sqrt(0.6), to_layer = 2 / pz;
    if (pz < k) return {-pz, px * (2 * to_layer + 2 / k * std::atanh(pz / k))};
    return {pz, px * (to_layer + 2 / k * std::atanh(k / pz))};
}

class Kinks : public ProgramTest {
protected:
    /// Returns the greatest error of two rays, of which one is reflected and one passes the layer.
    static double error_with(const Overrides& overrides, const std::string& form = forms[0]) {
        const auto plan = plan_of_text(scene_of(form), overrides, {}, false);
        double greatest = 0;
        for (const double pz : {0.4, 0.85}) {
            const double px = std::sqrt(1 - pz * pz);
            std::vector<RayEnd> ends;
            trace(*plan, start_rays(*plan, {{{0, 0, 0}, {px, 0, pz}}}), ends);
            EXPECT_EQ(ends[0].status, Status::escaped);
            const Exit expected = exit_of(px, pz);
            const RayEnd& end = ends[0];
            const double z = expected.pz > 0 ? 4 : 0;
            const double x = end.q[0] + (z - end.q[2]) / end.p[2] * end.p[0];
            greatest = std::max({greatest, std::abs(end.p[2] - expected.pz), std::abs(x - expected.x)});
        }
        return greatest;
    }
};

TEST_F(Kinks, DoNotReduceTheAccuracyOfStepControl) {
    for (const char* form : forms) {
        SCOPED_TRACE(form);
        EXPECT_LT(error_with({}, form), 1e-9);
        EXPECT_LT(error_with({"integrator.method=dp54", "integrator.tolerance=1e-11"}, form), 1e-9);
    }
}

TEST_F(Kinks, DoNotReduceTheOrderOfMethodsWithFixedSteps) {
    const auto error_of = [](const std::string& method, double step, const char* form) {
        return error_with({"integrator.method=" + method, "integrator.step=" + std::to_string(step)}, form);
    };
    struct {
        const char* method;
        double step, order;
    } const cases[] = {{"verlet", 0.1, 2}, {"rk4", 0.2, 4}, {"dp5", 0.2, 5}, {"gauss4", 0.2, 4}};
    for (const char* form : forms) {
        for (const auto& [method, step, order] : cases) {
            SCOPED_TRACE(std::string(form) + ' ' + method);
            const double coarse = error_of(method, step, form), fine = error_of(method, step / 8, form);
            EXPECT_GT(std::log2(coarse / fine) / 3, order - 0.4) << coarse << ' ' << fine;
        }
        EXPECT_LT(error_of("gauss8", 0.4, form), 1e-10) << form;
    }
}

/// Returns log2 of the ratio of successive errors per halving of the step, over the errors that are neither close to
/// rounding nor so large that the ray is a different one; nothing if there are fewer than two.
std::optional<double> fitted_order(const std::vector<double>& errors) {
    constexpr double least = 2e-10, greatest = 0.05;
    const auto is_usable = [](double error) { return error > least && error < greatest; };
    const auto first = std::find_if(errors.begin(), errors.end(), is_usable);
    const auto last = std::find_if_not(first, errors.end(), is_usable);
    if (last - first < 2) return std::nullopt;
    return std::log2(*first / *(last - 1)) / double(last - first - 1);
}

// Methods whose stages lie outside the step, such as yoshida4, and methods whose last stage only predicts the end of
// the step, such as rk4, would otherwise evaluate derivatives behind a kink.
TEST_F(Kinks, DoNotReduceTheOrderOfAnyMethod) {
    const auto plan = plan_of_text(scene_of(forms[0]), {}, {}, false);
    const Module& module = plan->module();
    int tested = 0;
    for (std::uint32_t i = 0; i < module.integrator_count; ++i) {
        const IntegratorInfo& info = module.integrators[i];
        const bool is_supported = !module.formula_refusal(plan->scene->space.parameters.data(), i) && !info.angular;
        if (!is_supported || info.adaptive) continue;
        SCOPED_TRACE(info.name);
        std::vector<double> errors;
        const double coarsest = info.order > 1 ? 0.4 : 0.00625;
        for (double step = coarsest; step > coarsest / 40; step /= 2)
            errors.push_back(
                error_with({std::string("integrator.method=") + info.name, "integrator.step=" + std::to_string(step),
                            "integrator.max_steps=1000000"}));
        const std::optional<double> order = fitted_order(errors);
        if (order) EXPECT_GT(*order, double(info.order) - 0.4);
        else EXPECT_LT(errors[1], 1e-9);
        ++tested;
    }
    EXPECT_GT(tested, 20);
}

/// Returns the number that follows a text in a line.
double number_after(const std::string& line, const std::string& text) {
    const std::size_t position = line.find(text);
    return position == std::string::npos ? std::nan("") : std::stod(line.substr(position + text.size()));
}

TEST_F(Kinks, AreReportedIfHJumpsThere) {
    for (const std::string jump : {"1 + u/abs(u)", "where(u, 2, 0)", "where(u, 2, 1e-30*sqrt(0.01 - u))"}) {
        SCOPED_TRACE(jump);
        write("jump.toml",
              "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - (1 + 0.2*(" + jump +
                  "))^2)\"\n[space.let]\nu = \"1 - x^2 - y^2 - z^2\"\n[integrator]\nescape_radius = 8\n[camera]\n"
                  "position = [-3, 0, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\n[film]\nsize = [16, 12]\n");
        write("rays.csv", "x,y,z,dx,dy,dz\n-3,0.4,0,1,0,0\n-3,0.99,0,1,0,0\n-3,1.2,0,1,0,0\n");
        const Outcome outcome = run("trace jump.toml --rays rays.csv");
        const auto rows = lines_of(outcome.out);
        for (const std::size_t row : {1, 2}) {
            EXPECT_NE(rows.at(row).find("H jumps here"), std::string::npos) << rows[row];
            // The index is 1 before the jump, where |p| = 1, and 1.4 behind it: H = (1 − 1.96)/2.
            EXPECT_NE(rows[row].find(" behind it"), std::string::npos) << rows[row];
            EXPECT_NEAR(number_after(rows[row], "H is "), 0, 1e-9) << rows[row];
            EXPECT_NEAR(number_after(rows[row], "jump and "), -0.48, 1e-5) << rows[row];
        }
        EXPECT_NE(rows.at(3).find("escaped"), std::string::npos);
        EXPECT_NE(outcome.err.find("H jumps here"), std::string::npos) << outcome.err;
    }
}

// A layer of air that is thinner by 3e-5 bends grazing rays visibly.
TEST_F(Kinks, AreReportedAlsoIfHJumpsByLittle) {
    const auto failure_with = [](const std::string& index, const Overrides& overrides = {}) {
        const auto plan = plan_of_text(
            "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - N^2)\"\n[space.let]\nN = \"" + index +
                "\"\n[integrator]\nescape_radius = 8\n[camera]\nposition = [-3, 0, 0]\nlook_at = [0, 0, 0]\nup = [0, "
                "0, "
                "1]\n[film]\nsize = [16, 12]\n",
            overrides, {}, false);
        std::vector<RayEnd> ends;
        trace(*plan, start_rays(*plan, {{{-3, 0.2, 0.5}, {1, 0.1, -0.4}}}), ends);
        return ends[0].failure;
    };
    const std::vector<Overrides> methods{{},
                                         {"integrator.method=gauss8"},
                                         {"integrator.method=verlet"},
                                         {"integrator.rescale=\"1 + r\""}};
    for (const Overrides& method : methods) {
        SCOPED_TRACE(method.empty() ? std::string("the default method") : method[0].text);
        EXPECT_EQ(failure_with("1 + where(z, 0, -0.00003)", method), Failure::hamiltonian_jumps);
        EXPECT_EQ(failure_with("1 + where(z, 0.03, 0)", method), Failure::hamiltonian_jumps);
        EXPECT_EQ(failure_with("1 + max(0, 0.3*z)", method), Failure::none);
        EXPECT_EQ(failure_with("1.5 - 0.01*abs(z)", method), Failure::none);
    }
    EXPECT_EQ(failure_with("1 + min(0.1, max(0, 1000*z))"), Failure::none);
}

/// A ball whose index rises by `step` in each of several shells of thickness w, from 1 outside, linearly in the radius.
struct Shells {
    std::vector<double> radii;  ///< Their outer radii, in descending order.
    double step, width;

    std::string index() const {
        std::string sum = "1";
        for (const double radius : radii)
            sum += " + " + to_toml(step) + "*min(1, max(0, (" + to_toml(radius) + " - r)/w))";
        return sum;
    }
    /// Returns the angle by which the ball bends a ray with the impact parameter b that crosses all shells (Bouguer:
    /// n r sin α = b). The integral over a shell is computed with the rule of Gauss and Legendre.
    double deflection(double b) const {
        double polar_angle = std::asin(b / radii.front()), n = 1;  // between the ray's direction and its closest point
        for (std::size_t k = 0; k < radii.size(); ++k) {
            const double outer = radii[k], inner = outer - width, n_outside = n;
            polar_angle += boost::math::quadrature::gauss<double, 30>::integrate(
                [&](double r) {
                    const double index = n_outside + step * (outer - r) / width;
                    return b / (r * std::sqrt(index * index * r * r - b * b));
                },
                inner, outer);
            n += step;
            polar_angle += (k + 1 < radii.size() ? std::asin(b / (n * radii[k + 1])) : std::numbers::pi / 2) -
                           std::asin(b / (n * inner));
        }
        return 2 * polar_angle - std::numbers::pi;
    }
};

/// Expects that rays in the direction of x, with impact parameters up to `greatest`, are bent as by the shells.
void expect_deflection_by(const Shells& shells, double greatest, Precision precision, double tolerance) {
    SCOPED_TRACE(std::string(precision == Precision::float32 ? "float" : "double") +
                 ", w = " + std::to_string(shells.width));
    Options options;
    options.precision = precision;
    auto plan = plan_of_text(
        "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - n^2)\"\n[space.constants]\nw = " +
            to_toml(shells.width) + "\n[space.let]\nn = \"" + shells.index() +
            "\"\n[integrator]\nescape_radius = 12\n[camera]\nposition = [0, -8, 1]\nlook_at = [0, 0, 0]\n[film]\n"
            "size = [16, 12]\n",
        {}, options, false);
    *plan = tune(std::move(*plan), options, Purpose::ray_list);  // chooses the bound on the steps
    constexpr int count = 500;
    std::vector<RayInput> rays;
    for (int i = 0; i < count; ++i)
        rays.push_back({{-8, 0.97 * greatest * i / count, 0.24 * greatest * i / count}, {1, 0, 0}});
    std::vector<RayEnd> ends;
    trace(*plan, start_rays(*plan, rays), ends);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        ASSERT_EQ(ends[i].status, Status::escaped) << i;
        const double b = std::hypot(rays[i].position[1], rays[i].position[2]);
        const Double3 v = unit(Double3{ends[i].v[0], ends[i].v[1], ends[i].v[2]});
        EXPECT_NEAR(std::atan2(std::hypot(v[1], v[2]), v[0]), shells.deflection(b), tolerance) << i;
    }
}

// However steep, H is continuous.
TEST_F(Kinks, AreNoJumpsWhereHIsSteep) {
    for (const auto& [width, tolerance] : {std::pair{0.03, 1e-8}, std::pair{1e-3, 1e-9}, std::pair{1e-4, 1e-8},
                                           std::pair{1e-5, 1e-7}, std::pair{1e-6, 1e-6}})
        expect_deflection_by({{2}, 0.3, width}, 1.98, Precision::float64, tolerance);
    for (const double width : {0.1, 0.01}) expect_deflection_by({{2}, 0.3, width}, 1.98, Precision::float32, 1e-3);
}

// The switching function is the product of 16 factors. It is very small between the shells, and steep in the core.
TEST_F(Kinks, MayBeMany) {
    const Shells shells{{2, 1.8, 1.6, 1.4, 1.2, 1, 0.8, 0.6}, 0.02, 0.01};
    expect_deflection_by(shells, 0.65, Precision::float64, 1e-9);
    expect_deflection_by(shells, 0.65, Precision::float32, 1e-3);
}

}  // namespace
}  // namespace kagero::test
