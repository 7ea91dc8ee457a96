// Tests of the parser of formulas: values of correct formulas, and messages for malformed ones.
#include "formula/nodes.h"
#include "formula/parser.h"
#include "formula/formula.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kagero::test {
namespace {

/// Values of the variables: x = 2, y = 3, z = 5, px = 7, py = 11, pz = 13, pt = −1.
constexpr std::array<double, 7> point{2, 3, 5, 7, 11, 13, -1};

double value_of(const std::string& text) {
    FormulaScope scope = formula_scope();
    return evaluate(scope, parse_formula(scope, {text, "space.H", {"scene.toml", 3, 5}}), point);
}

/// Returns the message of the InputError for a formula, or "" if the formula is accepted.
std::string message_of(const std::string& text) {
    try {
        value_of(text);
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

// The expected values are computed by C++ and by hand. The relative tolerance is 18 machine epsilons.
TEST(Formula, HasThePrecedenceAndAssociativityOfMathematics) {
    const std::pair<const char*, double> table[] = {
        {"1 + 2*3", 7}, {"(1 + 2)*3", 9}, {"2 - 3 - 4", -5}, {"2 - (3 - 4)", 3}, {"12/3/2", 2}, {"12/(3/2)", 8},
        {"12/3*2", 8},
        {"-x^2", -4}, {"(-x)^2", 4}, {"2^3^2", 512}, {"(2^3)^2", 64}, {"2^-1", 0.5}, {"-2^-x^2", -0.0625},
        {"x^-2", 0.25},
        {"--x", 2}, {"-+-x", 2}, {"3 - -x", 5}, {"3*-x", -6}, {"-x*y", -6}, {"2*x^3*y", 48}, {"x^0", 1}, {"x^1", 2},
        {"x^7", 128},
        {"x^63", std::pow(2, 63)}, {"(-x)^65", -std::pow(2, 65)}, {"x^0.5", std::sqrt(2)}, {"x^1.5", std::pow(2, 1.5)},
        {"x^-0.5", std::sqrt(0.5)},
        {"x^y", 8}, {"y^(1/3)", std::cbrt(3)}, {"x^100", std::pow(2, 100)}, {"2^x", 4}, {"1e3", 1000},
        {"1.5e-3*x", 0.003},
        {".5", 0.5}, {"2.", 2}, {" x\n +\ty ", 5}, {"pi", 3.14159265358979323846}, {"pt", -1}, {"px + py*pz", 150},
        {"sqrt(x*8)", 4}, {"exp(x)", std::exp(2)}, {"log(x)", std::log(2)}, {"sin(x)", std::sin(2)},
        {"cos(x)", std::cos(2)},
        {"tan(x)", std::tan(2)}, {"tanh(x)", std::tanh(2)}, {"atan2(y, x)", std::atan2(3, 2)}, {"abs(pt)", 1},
        {"abs(-z)", 5},
        {"asin(0.3*x)", std::asin(0.6)}, {"asin(1)", std::asin(1)}, {"asin(1e-9)", std::asin(1e-9)},
        {"asin(1 - 2^-40)", std::asin(1 - std::pow(2, -40))}, {"acos(1 - 2^-40)", std::acos(1 - std::pow(2, -40))},
        {"acos(-1)", std::acos(-1)}, {"acos(0.3*x)", std::acos(0.6)}, {"atan(-1e9)", std::atan(-1e9)},
        {"atan(z/x)", std::atan(2.5)}, {"sinh(1e-9)", std::sinh(1e-9)}, {"sinh(-x)", std::sinh(-2)},
        {"cosh(x)", std::cosh(2)}, {"where(x, y, z)", 3}, {"where(-x, y, z)", 5}, {"where(x - 2, y, z)", 5},
        {"where(x, y, log(-1*x))", 3}, {"where(x - 2, 1/(x - 2), z)", 5}, {"where(1, y, z)", 3},
        {"where(-0.5, y, z)", 5}, {"where(x, 0, z) + where(-x, y, 0)", 0},
        {"min(x, y)", 2}, {"max(x, y)", 3}, {"max(min(x, y), -z)", 2}, {"sin(pi)", std::sin(3.14159265358979323846)}};
    for (const auto& [text, expected] : table)
        EXPECT_NEAR(value_of(text), expected, 4e-15 * std::abs(expected)) << text;
}

struct Malformed {
    const char* text;
    int position;         ///< Position of the mistake in characters; the first character has position 1.
    const char* message;  ///< Part of the message.
};

const Malformed malformed[] = {
    {"", 1, "empty"}, {"   ", 4, "empty"}, {"x +", 4, "ends where"}, {"+", 2, "ends where"},
    {"* x", 1, "'*' is written where"},
    {"x + * y", 5, "'*' is written where"}, {"x y", 3, "operator is missing: write x*y"}, {"2x", 2, "write 2*x"},
    {"2(x)", 2, "write 2*("},
    {"(x)(y)", 4, "operator is missing"}, {"(x", 1, "never closed"}, {"((x)", 1, "never closed"},
    {"x)", 2, "has no matching '('"},
    {"(x y)", 4, "operator is missing"}, {"()", 2, "')' is written where"}, {"x,y", 2, "decimal point is '.'"},
    {"(1,5)*x", 3, "decimal point"},
    {"x ** 2", 3, "write ^"}, {"x ^", 4, "ends where"}, {"^x", 1, "'^' is written where"},
    {"x^*2", 3, "'*' is written where"},
    {"pxx", 1, "did you mean px?"}, {"0.5*pyy", 5, "did you mean py?"}, {"sqr(x)", 1, "did you mean sqrt?"},
    {"squirt(x)", 1, "no function"},
    {"Sin(x)", 1, "did you mean sin?"}, {"foo", 1, "unknown name foo"}, {"x + foo*y", 5, "unknown name foo"},
    {"q", 1, "unknown name q"},
    {"PI", 1, "did you mean pi?"}, {"thet", 1, "did you mean theta?"}, {"Ptheta", 1, "did you mean ptheta?"},
    {"l2", 1, "did you mean L2?"}, {"r(x)", 1, "r is not a function"}, {"asn(x)", 1, "did you mean asin?"},
    {"atam(x)", 1, "did you mean atan?"}, {"were(x, y, z)", 1, "did you mean where?"},
    {"where(x, y)", 1, "takes 3 arguments, not 2"}, {"where", 1, "write where(\u2026, \u2026, \u2026)"},
    {"asin(2)", 1, "not a finite number"},
    {"X", 1, "did you mean x?"},
    {"p", 1, "unknown name p"},
    {"sin x", 1, "write sin("}, {"atan2", 1, "write atan2("}, {"x(2)", 1, "x is not a function"},
    {"sin()", 1, "takes 1 argument, not 0"},
    {"sin(x, y)", 1, "takes 1 argument, not 2"}, {"atan2(x)", 1, "takes 2 arguments, not 1"},
    {"min(x, y, z)", 1, "takes 2 arguments, not 3"},
    {"max(x,)", 7, "')' is written where"}, {"sin(x", 4, "never closed"}, {"sin(x;y)", 6, "write ,"},
    {"1.2.3", 4, "one decimal point"},
    {"x + .", 5, "is not a number"}, {"..5", 1, "is not a number"}, {"1e", 2, "exponent"}, {"1e+", 2, "exponent"},
    {"2*1e-", 4, "exponent"},
    {"1e999", 1, "too large"}, {"0x10", 2, "write 0*x10"}, {"1/0", 2, "not a finite number"},
    {"x + log(0)", 5, "not a finite number"},
    {"sqrt(-1)*x", 1, "not a finite number"}, {"(-8)^(1/3)", 5, "not a finite number"},
    {"(-2)^x", 5, "not a finite number"}, {"0^x", 2, "not a finite number"},
    {"x = 2", 3, "'=' is not allowed"},
    {"x < y", 3, "'<' is not allowed"}, {"x & y", 3, "'&' is not allowed"}, {"|x|", 1, "write abs( )"},
    {"[x]", 1, "write ("},
    {"x\u00b2", 2, "write ^2"}, {"x \u2212 y", 3, "write -"}, {"x\u00b7y", 2, "write *"}, {"\u03c0*x", 1, "write pi"},
    {"\u00e9 + x", 1, "is not allowed"},
    {"x % 2", 3, "'%'"}, {"x!", 2, "'!'"}, {"x ? y : z", 3, "'?'"}, {"\"x\"", 1, "is not allowed"}, {"x # y", 3, "'#'"},
    {"x\\y", 2, "is not allowed"}, {"$x", 1, "'$'"}, {"x\ny", 3, "operator is missing"},
    {"x + (y - (z)", 5, "never closed"},
};

TEST(Formula, IsRefusedWithThePositionOfTheMistake) {
    static_assert(std::size(malformed) >= 50);
    for (const auto& [text, position, expected] : malformed) {
        const std::string message = message_of(text),
                          prefix = "scene.toml:3:5: space.H, position " + std::to_string(position) + ": ";
        EXPECT_EQ(message.rfind(prefix, 0), 0u) << "'" << text << "': " << message;
        EXPECT_NE(message.find(expected), std::string::npos) << "'" << text << "': " << message;
        EXPECT_EQ(message.back(), '^') << message;
    }
}

// The position is counted in characters, not in bytes. A message shows only the line with the mistake, and only a part
// of a long line.
TEST(Formula, IsShownWithACaretBelowTheMistake) {
    EXPECT_NE(message_of("0.5 * foo").find("\n    0.5 * foo\n          ^"), std::string::npos)
        << message_of("0.5 * foo");
    EXPECT_NE(message_of("x +\ny * foo").find("\n    y * foo\n        ^"), std::string::npos)
        << message_of("x +\ny * foo");
    const std::string far = message_of(std::string(500, ' ') + "foo");
    EXPECT_LT(far.size(), 500u);
    EXPECT_NE(far.find("position 501"), std::string::npos);
}

TEST(Formula, HasLimitsOfSizeAndDepth) {
    const auto repeated = [](const char* text, int times) {
        std::string all;
        for (int i = 0; i < times; ++i) all += text;
        return all;
    };
    EXPECT_EQ(message_of(repeated("(", 50) + "x" + repeated(")", 50)), "");
    for (const char* opening : {"(", "-", "sin(", "x^", "2*(", "(-"})
        EXPECT_NE(message_of(repeated(opening, 10000)).find("more than 200 levels"), std::string::npos) << opening;
    EXPECT_EQ(message_of("x" + repeated("+y", 1000)), "");
    EXPECT_NE(message_of("x" + repeated("+y", 10000)).find("more than 4096 operations"), std::string::npos);
    EXPECT_NE(message_of("x" + repeated("+y", 100000)).find("longer than 65536 bytes"), std::string::npos);
}

TEST(Formula, RefusesNamesThatAreDefinedOrInvalid) {
    FormulaScope scope = formula_scope();
    define(scope, "rg", number_node(scope, 2), {});
    EXPECT_EQ(evaluate(scope, parse_formula(scope, {"rg*x", "h", {}}), point), 4);
    for (const char* defined : {"x", "pz", "pt", "pi", "rg", "sin", "max"})
        EXPECT_THROW(define(scope, defined, 0, {}), InputError) << defined;
    for (const char* invalid : {"", "2x", "a-b", "a b", "\u00e9", "a.b"})
        EXPECT_THROW(define(scope, invalid, 0, {}), InputError) << invalid;
}

}  // namespace
}  // namespace kagero::test
