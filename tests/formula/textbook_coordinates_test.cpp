// Tests of the variables r theta phi rho pr ptheta pphi prho L2: their values, and formulas from textbooks whose terms
// are singular on the axis although their sum is regular.
#include "formula/nodes.h"
#include "formula/parser.h"
#include "kernels/operation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace kagero::test {
namespace {

/// Parses formulas with helpers, and evaluates them.
class Formulas {
public:
    explicit Formulas(const std::vector<std::pair<const char*, const char*>>& helpers = {}) {
        for (const auto& [name, text] : helpers) define(scope_, name, parse_helper(scope_, source(text)), {});
    }
    double operator()(const std::string& text, const FormulaPoint& at) {
        return evaluate(scope_, parse_formula(scope_, source(text)), at);
    }
    /// Returns the derivative of a formula with respect to each variable, by differences of fourth order.
    FormulaPoint gradient(const std::string& text, const FormulaPoint& at) {
        const std::int32_t node = parse_formula(scope_, source(text));
        constexpr double h = 1e-3;
        FormulaPoint result{};
        for (std::size_t i = 0; i < at.size(); ++i) {
            const auto value = [&](double offset) {
                FormulaPoint point = at;
                point[i] += offset;
                return evaluate(scope_, node, point);
            };
            result[i] = (8 * (value(h) - value(-h)) - (value(2 * h) - value(-2 * h))) / (12 * h);
        }
        return result;
    }

private:
    static FormulaText source(const std::string& text) { return {text, "space.H", {"scene.toml", 1, 1}}; }
    FormulaScope scope_ = formula_scope();
};

const FormulaPoint off_axis[] = {
    {2, 3, 5, 7, 11, 13, -1}, {-0.3, 0.4, -1.2, 0.5, 0.25, -2, 1}, {1, -2, 0.5, 1, 1, 3, 1}};
/// Points on the axis, at both poles.
const FormulaPoint on_axis[] = {{0, 0, 5, 0.7, 0.2, 0.4, -1}, {0, 0, -3, -0.5, 0.25, 2, 1}, {0, 0, 4, 0, 0, 1, 1}};

void expect_equal(double found, double expected, const std::string& what, double tolerance = 1e-13) {
    EXPECT_NEAR(found, expected, tolerance * (1 + std::abs(expected))) << what;
}

TEST(TextbookCoordinates, HaveTheirValues) {
    Formulas formulas;
    for (const FormulaPoint& at : off_axis) {
        const auto [x, y, z, px, py, pz, pt] = at;
        const double rho = std::hypot(x, y), r = std::hypot(x, y, z), lx = y * pz - z * py, ly = z * px - x * pz,
                     lz = x * py - y * px;
        const std::pair<const char*, double> table[] = {
            {"r", r}, {"rho", rho}, {"theta", std::acos(z / r)}, {"phi", std::atan2(y, x)},
            {"pr", (x * px + y * py + z * pz) / r}, {"ptheta", (z * (x * px + y * py) - rho * rho * pz) / rho},
            {"prho", (x * px + y * py) / rho},
            {"pphi", lz}, {"L2", lx * lx + ly * ly + lz * lz}, {"sin(theta)", rho / r}, {"cos(theta)", z / r},
            {"tan(theta)", rho / z}, {"sin(phi)", y / rho}, {"cos(phi)", x / rho}, {"tan(phi)", y / x},
            {"sin(theta)^2", rho * rho / (r * r)}, {"rho^2", rho * rho}, {"rho^3", rho * rho * rho},
            {"ptheta^2 + pphi^2/sin(theta)^2", lx * lx + ly * ly + lz * lz},
            {"pr^2 + L2/r^2", px * px + py * py + pz * pz}, {"exp(-theta)*sin(2*phi)",
             std::exp(-std::acos(z / r)) * std::sin(2 * std::atan2(y, x))}};
        for (const auto& [text, expected] : table) expect_equal(formulas(text, at), expected, text);
    }
}

/// Formulas that contain terms such as pθ² and pφ²/sin²θ, and the same without them.
const std::pair<const char*, const char*> same[] = {
    {"ptheta^2 + pphi^2/sin(theta)^2", "L2"},
    {"pphi^2/sin(theta)^2 + ptheta^2", "L2"},
    {"ptheta^2 + (pphi/sin(theta))^2", "L2"},
    {"ptheta*ptheta + pphi^2*sin(theta)^-2", "L2"},
    {"(ptheta^2 + pphi^2/sin(theta)^2)/r^2", "L2/r^2"},
    {"ptheta^2/r^2 + pphi^2/rho^2", "L2/r^2"},
    {"prho^2 + pphi^2/rho^2", "px^2 + py^2"},
    {"0.5*(-pt^2 + (pphi + a*rho^2*pt)^2/rho^2 + prho^2 + pz^2)",
     "0.5*(-pt^2 + px^2 + py^2 + 2*a*pphi*pt + a^2*(x^2 + y^2)*pt^2 + pz^2)"},
    {"rho*prho", "x*px + y*py"},
    {"0.5*(pr^2 + (ptheta^2 + pphi^2/(1 - cos(theta)^2))/r^2 - 1)", "0.5*(px^2 + py^2 + pz^2 - 1)"},
    {"0.5*(pr^2 + ptheta^2/r^2 + pphi^2/(r^2*sin(theta)^2))", "0.5*(px^2 + py^2 + pz^2)"},
    {"0.5*(pr^2 + ptheta^2/r^2 + pphi^2/(r*sin(theta))^2)", "0.5*(px^2 + py^2 + pz^2)"},
    {"sqrt(pr^2 + ptheta^2/r^2 + pphi^2/(r*sin(theta))^2)", "sqrt(px^2 + py^2 + pz^2)"},
    {"ptheta^2 + pphi^2/tan(theta)^2", "L2 - pphi^2"},
    {"ptheta^2 + cos(theta)^2*(pphi^2/sin(theta)^2 - a^2*pt^2)", "L2 - pphi^2 - a^2*pt^2*z^2/r^2"},
    {"(pphi/sin(theta) - a*sin(theta)*pt)^2 + ptheta^2", "L2 - 2*a*pphi*pt + a^2*pt^2*(x^2 + y^2)/r^2"},
    {"(ptheta^2 + pphi^2/sin(theta)^2)^2", "L2^2"},
    {"(1 - 2*M/r)*pr^2 - pt^2/(1 - 2*M/r) + (ptheta^2 + pphi^2/sin(theta)^2)/r^2",
     "(1 - 2*M/r)*pr^2 - pt^2/(1 - 2*M/r) + L2/r^2"},
    {"exp(-ptheta^2 - pphi^2/sin(theta)^2) + z*ptheta^2 + z*pphi^2/sin(theta)^2", "exp(-L2) + z*L2"},
    {"(ptheta*sin(theta))^2", "(z*(x*px + y*py) - (x^2 + y^2)*pz)^2/r^2"},
    // Kerr: a sum of squares, the components of the inverse metric, and g^φφ in two forms.
    {"(D*pr^2 + ptheta^2 + (pphi/sin(theta) - a*sin(theta)*pt)^2 - ((r^2 + a^2)*pt - a*pphi)^2/D)/(2*S)", "K"},
    {"0.5*(D/S*pr^2 + ptheta^2/S + (D - a^2*sin(theta)^2)/(S*D*sin(theta)^2)*pphi^2 + 4*M*a*r/(S*D)*pt*pphi"
     " - ((r^2 + a^2)^2 - a^2*D*sin(theta)^2)/(S*D)*pt^2)", "K"},
    {"(D*pr^2 + ptheta^2 + (1 - 2*M*r/S)*S/(D*sin(theta)^2)*pphi^2)/(2*S) + 2*M*a*r/(S*D)*pt*pphi"
     " - ((r^2 + a^2)^2/D - a^2*sin(theta)^2)/(2*S)*pt^2", "K"}};
const std::vector<std::pair<const char*, const char*>> same_helpers{
    {"M", "1"}, {"a", "0.9"}, {"S", "r^2 + a^2*cos(theta)^2"}, {"D", "r^2 - 2*M*r + a^2"},
    {"K", "(D*pr^2 + L2 - 2*a*pphi*pt + a^2*(x^2 + y^2)/r^2*pt^2 - ((r^2 + a^2)*pt - a*pphi)^2/D)/(2*S)"}};

TEST(TextbookCoordinates, KeepTheValueOfFormulasWhoseTermsCancel) {
    for (const auto& [text, regular] : same)
        for (const FormulaPoint& at : off_axis) {
            Formulas formulas(same_helpers);
            const double expected = formulas(regular, at);
            expect_equal(formulas(text, at), expected, text, 1e-12);
        }
}

TEST(TextbookCoordinates, LeaveSuchFormulasRegularOnTheAxis) {
    for (const auto& [text, regular] : same)
        for (const FormulaPoint& at : on_axis) {
            Formulas formulas(same_helpers);
            expect_equal(formulas(text, at), formulas(regular, at), text, 1e-12);
            const FormulaPoint found = formulas.gradient(text, at), expected = formulas.gradient(regular, at);
            for (std::size_t i = 0; i < at.size(); ++i) expect_equal(found[i], expected[i], text, 1e-9);
        }
}

// A formula whose singular terms do not cancel has the same values as before, and no value on the axis.
TEST(TextbookCoordinates, LeaveSingularFormulasAsTheyAre) {
    Formulas formulas;
    for (const char* text :
         {"ptheta^2 + 2*pphi^2/sin(theta)^2", "ptheta^2", "pphi^2/sin(theta)^2", "ptheta + pphi", "prho^2"}) {
        const auto [x, y, z, px, py, pz, pt] = off_axis[0];
        const double rho = std::hypot(x, y), sine2 = rho * rho / (rho * rho + z * z), pphi = x * py - y * px,
                     ptheta = (z * (x * px + y * py) - rho * rho * pz) / rho;
        const std::string name = text;
        const double expected = name == "ptheta^2"              ? ptheta * ptheta
                                : name == "pphi^2/sin(theta)^2" ? pphi * pphi / sine2
                                : name == "ptheta + pphi"       ? ptheta + pphi
                                : name == "prho^2"              ? std::pow((x * px + y * py) / rho, 2)
                                                                : ptheta * ptheta + 2 * pphi * pphi / sine2;
        expect_equal(formulas(text, off_axis[0]), expected, text);
        EXPECT_FALSE(std::isfinite(formulas(text, on_axis[0]))) << text;
    }
}

TEST(TextbookCoordinates, GiveWayToTheNamesOfTheScene) {
    Formulas formulas({{"r", "x + 1"}, {"L2", "r^2"}});
    EXPECT_EQ(formulas("r + L2", {2, 0, 0, 0, 0, 0, 0}), 12);
    FormulaScope scope = formula_scope();
    parse_helper(scope, {"r^2", "space.let.r2", {}});
    try {
        define(scope, "r", number_node(scope, 1), {});
        FAIL() << "a name with two meanings";
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("is used by a formula above"), std::string::npos) << error.what();
    }
}

}  // namespace
}  // namespace kagero::test
