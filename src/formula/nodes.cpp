#include "formula/nodes.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

bool is_number(const FormulaScope& scope, std::int32_t node) {
    return scope.nodes[static_cast<std::size_t>(node)].op == FormulaOp::number;
}
double value_of(const FormulaScope& scope, std::int32_t node) { return scope.nodes[static_cast<std::size_t>(node)].value; }

std::int32_t append(FormulaScope& scope, const FormulaNode& node) {
    std::uint8_t variables = 0;
    const bool leaf = node.op == FormulaOp::number || node.op == FormulaOp::variable;
    if (node.op == FormulaOp::variable) variables = static_cast<std::uint8_t>(1u << node.a);
    for (const std::int32_t operand : {node.a, node.b})
        if (!leaf && operand >= 0) variables |= scope.variables[static_cast<std::size_t>(operand)];
    scope.nodes.push_back(node);
    scope.variables.push_back(variables);
    return static_cast<std::int32_t>(scope.nodes.size() - 1);
}

/// base^n by repeated squaring.
std::int32_t whole_power(FormulaScope& scope, std::int32_t base, int n) {
    std::int32_t result = -1;
    for (std::int32_t square = base;; square = operation(scope, FormulaOp::mul, square, square)) {
        if (n & 1) result = result < 0 ? square : operation(scope, FormulaOp::mul, square, result);
        if ((n >>= 1) == 0) break;
    }
    return result < 0 ? number_node(scope, 1) : result;
}

}  // namespace

double apply(FormulaOp op, double a, double b) {
    switch (op) {
        case FormulaOp::add: return a + b;
        case FormulaOp::sub: return a - b;
        case FormulaOp::mul: return a * b;
        case FormulaOp::div: return a / b;
        case FormulaOp::neg: return -a;
        case FormulaOp::sqrt: return std::sqrt(a);
        case FormulaOp::exp: return std::exp(a);
        case FormulaOp::log: return std::log(a);
        case FormulaOp::sin: return std::sin(a);
        case FormulaOp::cos: return std::cos(a);
        case FormulaOp::tan: return std::tan(a);
        case FormulaOp::tanh: return std::tanh(a);
        case FormulaOp::abs: return std::abs(a);
        case FormulaOp::atan2: return std::atan2(a, b);
        case FormulaOp::min: return std::isnan(a) || a < b ? a : b;  // as kernels/autodiff/program.h has it
        case FormulaOp::max: return std::isnan(a) || a > b ? a : b;
        case FormulaOp::number:
        case FormulaOp::variable: break;
    }
    return a;
}

std::int32_t number_node(FormulaScope& scope, double value) { return append(scope, {FormulaOp::number, -1, -1, value}); }

std::int32_t operation(FormulaScope& scope, FormulaOp op, std::int32_t a, std::int32_t b) {
    if (is_number(scope, a) && (b < 0 || is_number(scope, b)))
        return number_node(scope, apply(op, value_of(scope, a), b < 0 ? 0 : value_of(scope, b)));
    return append(scope, {op, a, b, 0});
}

std::int32_t power(FormulaScope& scope, std::int32_t base, std::int32_t exponent) {
    // Whole powers are products and halves products with a root, so that even a negative number has the former. The rest is left to the
    // logarithm: halves beyond 64, and whole powers beyond 2^30, of which odd ones thus want a base above 0.
    constexpr double greatest = 1 << 30, greatest_half = 64;
    if (is_number(scope, base) && is_number(scope, exponent))
        return number_node(scope, std::pow(value_of(scope, base), value_of(scope, exponent)));
    if (is_number(scope, exponent) && std::abs(value_of(scope, exponent)) <= greatest) {
        const double size = std::abs(value_of(scope, exponent)), whole = std::floor(size);
        if (size == whole || (size == whole + 0.5 && size < greatest_half)) {
            std::int32_t result = size > 0 && whole == 0 ? -1 : whole_power(scope, base, static_cast<int>(whole));
            if (size != whole) {
                const std::int32_t root = operation(scope, FormulaOp::sqrt, base);
                result = result < 0 ? root : operation(scope, FormulaOp::mul, result, root);
            }
            return value_of(scope, exponent) < 0 ? operation(scope, FormulaOp::div, number_node(scope, 1), result) : result;
        }
    }
    const bool even = is_number(scope, exponent) && std::fmod(value_of(scope, exponent), 2) == 0;
    const std::int32_t size = even ? operation(scope, FormulaOp::abs, base) : base;
    return operation(scope, FormulaOp::exp, operation(scope, FormulaOp::mul, exponent, operation(scope, FormulaOp::log, size)));
}

FormulaScope formula_scope() {
    FormulaScope scope;
    for (std::size_t i = 0; i < formula_variables.size(); ++i)
        scope.names.emplace_back(formula_variables[i], append(scope, {FormulaOp::variable, static_cast<std::int32_t>(i), -1, 0}));
    scope.names.emplace_back("pi", number_node(scope, 3.14159265358979323846));
    return scope;
}

double evaluate(const FormulaScope& scope, std::int32_t node, const std::array<double, 7>& variables) {
    std::vector<double> values(static_cast<std::size_t>(node) + 1);
    for (std::size_t i = 0; i < values.size(); ++i) {
        const FormulaNode& n = scope.nodes[i];
        if (n.op == FormulaOp::number) values[i] = n.value;
        else if (n.op == FormulaOp::variable) values[i] = variables[static_cast<std::size_t>(n.a)];
        else values[i] = apply(n.op, values[static_cast<std::size_t>(n.a)], n.b < 0 ? 0 : values[static_cast<std::size_t>(n.b)]);
    }
    return values.back();
}

}  // namespace kagero
