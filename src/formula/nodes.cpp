#include "formula/nodes.h"

#include "kernels/operation.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

/// A constant. Its functions are those of the standard library, so that constants are the same for every instruction
/// set.
struct Number {
    double x;
    Number(double value) : x(value) {}

    [[maybe_unused]] friend Number operator-(Number a) { return -a.x; }
    [[maybe_unused]] friend Number operator+(Number a, Number b) { return a.x + b.x; }
    [[maybe_unused]] friend Number operator-(Number a, Number b) { return a.x - b.x; }
    [[maybe_unused]] friend Number operator*(Number a, Number b) { return a.x * b.x; }
    [[maybe_unused]] friend Number operator/(Number a, Number b) { return a.x / b.x; }
    [[maybe_unused]] friend bool operator<(Number a, Number b) { return a.x < b.x; }
    [[maybe_unused]] friend bool operator<=(Number a, Number b) { return a.x <= b.x; }
    [[maybe_unused]] friend bool operator>(Number a, Number b) { return a.x > b.x; }
    [[maybe_unused]] friend bool operator>=(Number a, Number b) { return a.x >= b.x; }
    [[maybe_unused]] friend Number select(bool condition, Number a, Number b) { return condition ? a : b; }
    [[maybe_unused]] friend Number fma(Number a, Number b, Number c) { return a.x * b.x + c.x; }
    [[maybe_unused]] friend Number fms(Number a, Number b, Number c) { return a.x * b.x - c.x; }
    [[maybe_unused]] friend Number fnma(Number a, Number b, Number c) { return c.x - a.x * b.x; }
    [[maybe_unused]] friend Number recip(Number a) { return 1 / a.x; }
    [[maybe_unused]] friend Number rsqrt(Number a) { return 1 / std::sqrt(a.x); }
    [[maybe_unused]] friend Number sqrt(Number a) { return std::sqrt(a.x); }
    [[maybe_unused]] friend Number exp(Number a) { return std::exp(a.x); }
    [[maybe_unused]] friend Number log(Number a) { return std::log(a.x); }
    [[maybe_unused]] friend Number sin(Number a) { return std::sin(a.x); }
    [[maybe_unused]] friend Number cos(Number a) { return std::cos(a.x); }
    [[maybe_unused]] friend Number tan(Number a) { return std::tan(a.x); }
    [[maybe_unused]] friend Number tanh(Number a) { return std::tanh(a.x); }
    [[maybe_unused]] friend Number atan2(Number a, Number b) { return std::atan2(a.x, b.x); }
    [[maybe_unused]] friend Number abs(Number a) { return std::abs(a.x); }
    [[maybe_unused]] friend Number min(Number a, Number b) { return a.x < b.x ? a : b; }
    [[maybe_unused]] friend Number max(Number a, Number b) { return a.x > b.x ? a : b; }
};

/// Returns the result of operation F on constants. If `F::total` exists, it is used, because constants may be 0,
/// infinite or NaN. Operations without a name, except gates, do not occur in formulas; for them the function returns
/// `a`.
template <class F>
Number folded(Number a, [[maybe_unused]] Number b) {
    if constexpr (F::name[0] == '\0' && !requires { F::is_gate; }) return a;
    else if constexpr (requires { F::total(a, b); }) return F::total(a, b);
    else if constexpr (F::operands == 1) return F::value(a);
    else return F::value(a, b);
}

bool is_number(const FormulaScope& scope, std::int32_t node) {
    return scope.nodes[static_cast<std::size_t>(node)].op == Op::constant;
}
double value_of(const FormulaScope& scope, std::int32_t node) {
    return scope.nodes[static_cast<std::size_t>(node)].value;
}

/// Returns the bits of FormulaScope::variables for a variable.
std::uint8_t bits_of_variable(std::size_t i) {
    if (i < formula_variables.size()) return static_cast<std::uint8_t>(1u << i);
    return textbook_variables[i - formula_variables.size()].depends_on | FormulaScope::textbook_bit;
}

/// Appends a node with its dependence on the variables. Returns its index.
std::int32_t append(FormulaScope& scope, const FormulaNode& node) {
    std::uint8_t variables = 0;
    const bool leaf = is_leaf(node.op);
    if (node.op == Op::input) variables = bits_of_variable(static_cast<std::size_t>(node.a));
    for (const std::int32_t operand : {node.a, node.b})
        if (!leaf && operand >= 0) variables |= scope.variables[static_cast<std::size_t>(operand)];
    scope.nodes.push_back(node);
    scope.variables.push_back(variables);
    return static_cast<std::int32_t>(scope.nodes.size() - 1);
}

/// Appends base^n by repeated squaring.
std::int32_t append_whole_power(FormulaScope& scope, std::int32_t base, int n) {
    std::int32_t result = -1;
    for (std::int32_t square = base;; square = operation(scope, Op::mul, square, square)) {
        if (n & 1) result = result < 0 ? square : operation(scope, Op::mul, square, result);
        if ((n >>= 1) == 0) break;
    }
    return result < 0 ? number_node(scope, 1) : result;
}

}  // namespace

double apply(Op op, double a, double b) {
    switch (op) {
#define KAGERO_OPERATION(OP, OPERATION) \
    case Op::OP: return folded<operations::OPERATION>(a, b).x;
        KAGERO_OPERATIONS(KAGERO_OPERATION)
#undef KAGERO_OPERATION
        default: return a;
    }
}

std::int32_t number_node(FormulaScope& scope, double value) { return append(scope, {Op::constant, -1, -1, value}); }

std::int32_t parameter_node(FormulaScope& scope, std::int32_t number, double value) {
    return append(scope, {Op::parameter, number, -1, value});
}

std::int32_t operation(FormulaScope& scope, Op op, std::int32_t a, std::int32_t b) {
    if (is_number(scope, a) && (b < 0 || is_number(scope, b)))
        return number_node(scope, apply(op, value_of(scope, a), b < 0 ? 0 : value_of(scope, b)));
    return append(scope, {op, a, b, 0});
}

std::int32_t power(FormulaScope& scope, std::int32_t base, std::int32_t exponent) {
    // A whole power becomes a product, which is defined for negative bases too. A half-integer power becomes a product
    // with a square root. All other powers are computed by the logarithm, as are half-integer powers above 64 and whole
    // powers above 2^30. An odd whole power above 2^30 therefore requires a positive base.
    constexpr double max_exponent = 1 << 30, max_half_exponent = 64;
    if (is_number(scope, base) && is_number(scope, exponent))
        return number_node(scope, std::pow(value_of(scope, base), value_of(scope, exponent)));
    if (is_number(scope, exponent) && std::abs(value_of(scope, exponent)) <= max_exponent) {
        const double size = std::abs(value_of(scope, exponent)), whole = std::floor(size);
        if (size == whole || (size == whole + 0.5 && size < max_half_exponent)) {
            std::int32_t result =
                size > 0 && whole == 0 ? -1 : append_whole_power(scope, base, static_cast<int>(whole));
            if (size != whole) {
                const std::int32_t root = operation(scope, Op::sqrt, base);
                result = result < 0 ? root : operation(scope, Op::mul, result, root);
            }
            return value_of(scope, exponent) < 0 ? operation(scope, Op::div, number_node(scope, 1), result) : result;
        }
    }
    const bool is_parameter = !is_number(scope, exponent) && !scope.variables[static_cast<std::size_t>(exponent)];
    if (is_parameter && !(is_number(scope, base) && value_of(scope, base) > 0)) scope.has_parameter_exponent = true;
    const bool even = is_number(scope, exponent) && std::fmod(value_of(scope, exponent), 2) == 0;
    const std::int32_t magnitude = even ? operation(scope, Op::abs, base) : base;
    return operation(scope, Op::exp, operation(scope, Op::mul, exponent, operation(scope, Op::log, magnitude)));
}

std::int32_t branch(FormulaScope& scope, std::int32_t condition, std::int32_t a, std::int32_t b) {
    if (is_number(scope, condition)) return value_of(scope, condition) > 0 ? a : b;
    const auto is_zero = [&](std::int32_t node) { return is_number(scope, node) && value_of(scope, node) == 0; };
    if (is_zero(a)) return operation(scope, Op::unless_positive, condition, b);
    const std::int32_t first = operation(scope, Op::if_positive, condition, a);
    return is_zero(b) ? first : operation(scope, Op::add, first, operation(scope, Op::unless_positive, condition, b));
}

std::int32_t textbook_node(FormulaScope& scope, const std::string& name) {
    for (std::size_t i = 0; i < std::size(textbook_variables); ++i) {
        if (name != textbook_variables[i].name) continue;
        const auto [entry, is_new] = scope.textbook_nodes.try_emplace(name, -1);
        if (is_new)
            entry->second = append(scope, {Op::input, static_cast<std::int32_t>(formula_variables.size() + i), -1, 0});
        return entry->second;
    }
    return -1;
}

FormulaScope formula_scope() {
    FormulaScope scope;
    for (std::size_t i = 0; i < formula_variables.size(); ++i)
        scope.names.emplace_back(formula_variables[i], append(scope, {Op::input, static_cast<std::int32_t>(i), -1, 0}));
    scope.names.emplace_back("pi", number_node(scope, 3.14159265358979323846));
    return scope;
}

double evaluate(const FormulaScope& scope, std::int32_t node, const FormulaPoint& variables) {
    std::vector<double> values(static_cast<std::size_t>(node) + 1);
    for (std::size_t i = 0; i < values.size(); ++i) {
        const FormulaNode& n = scope.nodes[i];
        if (n.op == Op::constant || n.op == Op::parameter) values[i] = n.value;
        else if (n.op == Op::input)
            values[i] = static_cast<std::size_t>(n.a) < variables.size() ? variables[static_cast<std::size_t>(n.a)]
                                                                         : std::nan("");
        else
            values[i] =
                apply(n.op, values[static_cast<std::size_t>(n.a)], n.b < 0 ? 0 : values[static_cast<std::size_t>(n.b)]);
    }
    return values.back();
}

}  // namespace kagero
