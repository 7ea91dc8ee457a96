// Tests of the functions in kernels/operation_table.h. Derivatives by dual numbers and by the tape are compared with
// finite differences in quadruple precision. Rounding errors are compared with the bounds that the table states.
#include "tests/kernels/steps.h"

#include "kernels/trace/packets.h"

namespace kagero::test {
namespace {

struct Operands {
    double a, b;
};
/// Operands at which all functions are defined and smooth.
constexpr Operands test_operands[] = {{0.3, 0.7}, {1.2, 0.4}, {0.9, 2.1}, {2.5, 1.1}};

/// Scales an operand to the interval (−1, 1) if the function is defined only there.
template <Op op>
double in_domain(double operand) { return op == Op::asin || op == Op::acos ? operand / 3 : operand; }

template <Op op, class T>
T value_at(const T& a, const T& b) {
    if constexpr (Operation<op>::operands == 1) return Operation<op>::value(a);
    else return Operation<op>::value(a, b);
}

/// Returns the derivatives with respect to both operands by central differences in quadruple precision (34 digits).
/// Their error is about h² = 1e-22.
template <Op op>
std::array<Quad, 2> differences(const Operands& at) {
    const Quad h = 1e-11, a = at.a, b = at.b;
    return {(value_at<op, Quad>(a + h, b) - value_at<op, Quad>(a - h, b)) / (2 * h),
            (value_at<op, Quad>(a, b + h) - value_at<op, Quad>(a, b - h)) / (2 * h)};
}

/// Expects that two numbers agree to about 50 rounding errors of double.
void expect_near(double found, Quad expected, const char* description) {
    const double y = static_cast<double>(expected);
    EXPECT_NEAR(found, y, 1e-14 * (1 + std::abs(y))) << description;
}

template <Op op>
void check_dual_numbers(const Operands& at) {
    using DualNumber = Dual<double, 2>;
    if constexpr (!Operation<op>::is_abbreviation) {
        const DualNumber a = DualNumber::variable(at.a, 0), b = DualNumber::variable(at.b, 1);
        const DualNumber y = kagero::detail::apply_at_run_time<DualNumber>(op, a, b, DualNumber(0.0));
        const auto expected = differences<op>(at);
        expect_near(y.value, value_at<op, Quad>(at.a, at.b), "value");
        for (int k = 0; k < Operation<op>::operands; ++k) expect_near(y.derivative[k], expected[k], "derivative");
    }
}

/// Checks an operation that is recorded on a tape, in the same way as the operations of a formula, and evaluated as a
/// program.
template <Op op>
void check_program(const Operands& at) {
    auto t = std::make_unique<Tape>();
    const std::array<int, 2> inputs{t->input(0), t->input(1)};
    std::array<int, 2> gradient{};
    const int node = record(*t, op, inputs[0], inputs[1]);
    record_gradient<2>(*t, node, inputs, gradient);
    const auto program = kagero::detail::extract_untrimmed<3>(*t, {node, gradient[0], gradient[1]});
    const ProgramWithUniforms<double> with_uniforms{
        {program.nodes, nullptr, program.outputs.data(), program.size}, nullptr};
    const double in[] = {at.a, at.b};
    double values[Tape::capacity];
    evaluate(with_uniforms, in, values);
    const auto expected = differences<op>(at);
    expect_near(values[program.outputs[0]], value_at<op, Quad>(at.a, at.b), "value of the program");
    for (int k = 0; k < Operation<op>::operands; ++k)
        expect_near(values[program.outputs[k + 1]], expected[k], "derivative of the program");
}

TEST(OperationTable, DerivativesMatchDifferencesOfValues) {
    for (const Operands& at : test_operands) {
#define KAGERO_OPERATION(OP, OPERATION)                                 \
    {                                                                   \
        SCOPED_TRACE(std::string(#OP) + " at " + std::to_string(at.a)); \
        check_dual_numbers<Op::OP>({in_domain<Op::OP>(at.a), at.b});    \
        check_program<Op::OP>({in_domain<Op::OP>(at.a), at.b});         \
    }
        KAGERO_FUNCTIONS(KAGERO_OPERATION)
#undef KAGERO_OPERATION
    }
}

/// Expects that the rounding error of an operation in double is within the bound of the table, in units of half a unit
/// in the last place. The exact result is computed in quadruple precision.
template <Op op>
void check_rounding(double a, double b) {
    const Quad exact = value_at<op, Quad>(a, b);
    const double error = static_cast<double>(abs(exact - value_at<op, double>(a, b)));
    const double half_ulp = machine_epsilon<double> / 2 * std::abs(static_cast<double>(exact));
    EXPECT_LE(error, Operation<op>::rounding * half_ulp * (1 + 1e-9)) << a << ' ' << b;
}

TEST(OperationTable, RoundingErrorsAreWithinTheStatedBounds) {
    Random random(28);
    for (int i = 0; i < 2000; ++i) {
        const double a = random(0.05, 1.5), b = random(0.05, 1.5);
#define KAGERO_OPERATION(OP, OPERATION) \
    {                                   \
        SCOPED_TRACE(#OP);              \
        check_rounding<Op::OP>(in_domain<Op::OP>(a), b); \
    }
        KAGERO_FUNCTIONS(KAGERO_OPERATION)
#undef KAGERO_OPERATION
    }
}

/// Expects that a function of the table has a relative error of a few units in the last place, and its derivative too.
template <Op op, class Exact, class Slope>
void check_accuracy(double a, const Exact& exact, const Slope& slope) {
    constexpr double tolerance = 8 * machine_epsilon<double>;
    const double y = Operation<op>::value(a), found = Operation<op>::derivative(a, y);
    EXPECT_NEAR(y, exact(a), tolerance * std::abs(exact(a))) << info_of(op).name << ' ' << a;
    EXPECT_NEAR(found, slope(a), tolerance * std::abs(slope(a))) << info_of(op).name << "' " << a;
    const PacketDouble packet = Operation<op>::value(PacketDouble(a));
    EXPECT_NEAR(get_lane(packet, 0), exact(a), tolerance * std::abs(exact(a))) << info_of(op).name << ' ' << a;
}

// Reference values are those of the standard library. Near ±1 the derivative of an arc sine is written with the exact
// difference from 1.
TEST(OperationTable, InverseAndHyperbolicFunctionsAreAccurateEverywhere) {
    for (const double size : {1e-300, 1e-20, 1e-9, 1e-3, 0.3, 0.9, 1.0, 1.7, 20.0, 300.0, 700.0})
        for (const double a : {size, -size}) {
            check_accuracy<Op::sinh>(a, [](double x) { return std::sinh(x); }, [](double x) { return std::cosh(x); });
            check_accuracy<Op::cosh>(a, [](double x) { return std::cosh(x); }, [](double x) { return std::sinh(x); });
            check_accuracy<Op::atan>(
                a, [](double x) { return std::atan(x); }, [](double x) { return 1 / (1 + x * x); });
        }
    for (const double from_one : {1.0, 0.7, 1e-3, 1e-9, 0x1p-40, 0x1p-52})
        for (const double a : {1 - from_one, from_one - 1, 1e-3 * from_one}) {
            const auto slope = [](double x) { return 1 / std::sqrt((1 - x) * (1 + x)); };
            check_accuracy<Op::asin>(a, [](double x) { return std::asin(x); }, slope);
            check_accuracy<Op::acos>(
                a, [](double x) { return std::acos(x); }, [&](double x) { return -slope(x); });
        }
    for (const double a : {1.0, -1.0}) {
        EXPECT_EQ(operations::Asin::value(a), std::asin(a));
        EXPECT_EQ(operations::Acos::value(a), std::acos(a));
    }
}

// A gate returns 0 where it blocks its operand, whatever the operand is. Derivatives are blocked too.
TEST(OperationTable, GatesBlockOperandsThatAreNotFinite) {
    constexpr double infinity = std::numeric_limits<double>::infinity(), nan = std::nan("");
    for (const double blocked : {infinity, -infinity, nan}) {
        Dual<double, 1> operand(blocked);
        operand.derivative[0] = nan;
        for (const double c : {1.0, 0.0, -1.0}) {
            const Op closed = c > 0 ? Op::unless_positive : Op::if_positive;
            const Dual<double, 1> condition = Dual<double, 1>::variable(c, 0),
                                  y = kagero::detail::apply_at_run_time(closed, condition, operand, operand);
            EXPECT_EQ(y.value, 0);
            EXPECT_EQ(y.derivative[0], 0);
            const PacketDouble packet =
                kagero::detail::apply_at_run_time(closed, PacketDouble(c), PacketDouble(blocked), PacketDouble(0.0));
            EXPECT_EQ(get_lane(packet, 0), 0);
        }
    }
    for (const Op gate : {Op::if_positive, Op::unless_positive})
        EXPECT_TRUE(std::isnan(kagero::detail::apply_at_run_time(gate, nan, 1.0, 1.0)));
}

TEST(OperationTable, NamesOfFunctionsAreUnique) {
    for (int i = 0; i < op_count; ++i)
        for (int k = 0; k < i; ++k)
            if (operation_infos[i].has_function_name()) {
                EXPECT_STRNE(operation_infos[i].name, operation_infos[k].name);
            }
}

}  // namespace
}  // namespace kagero::test
