/// The enumeration `Op` of the operations in operation_table.h, and the struct and constants of each operation.
#pragma once

#include "kernels/operation_table.h"

#include <cstdint>
#include <type_traits>

namespace kagero {

/// The operations. The first three are leaves: a constant number, a parameter of H, and a component of the ray state.
enum class Op : std::uint8_t {
    constant, parameter, input,
#define KAGERO_OPERATION(OP, OPERATION) OP,
    KAGERO_OPERATIONS(KAGERO_OPERATION)
#undef KAGERO_OPERATION
};

/// Returns true for constants, parameters and inputs.
constexpr bool is_leaf(Op op) { return op <= Op::input; }
/// Returns true if the operation passes or blocks its second operand, depending on the sign of the first.
constexpr bool is_gate(Op op) { return op == Op::if_positive || op == Op::unless_positive; }
/// Returns true if the result or its derivatives jump where the operation changes its branch.
constexpr bool has_branches(Op op) { return op == Op::min || op == Op::max || op == Op::abs || is_gate(op); }
/// Returns true if the branch depends on the sign of the first operand, not on the difference of the operands.
constexpr bool branches_by_sign(Op op) { return op == Op::abs || is_gate(op); }

namespace detail {

template <Op op>
struct OperationAt;
#define KAGERO_OPERATION(OP, OPERATION) \
    template <>                         \
    struct OperationAt<Op::OP> { using Type = operations::OPERATION; };
KAGERO_OPERATIONS(KAGERO_OPERATION)
#undef KAGERO_OPERATION

}  // namespace detail

/// The struct in operation_table.h that defines an operation.
template <Op op>
using Operation = typename detail::OperationAt<op>::Type;

/// The constants of an operation, copied from its struct. Their meaning is given in operation_table.h.
struct OperationInfo {
    const char* name = "";
    int operands = 0;
    double flops = 0, rounding = 0;
    bool is_library = false, is_abbreviation = false;
    constexpr bool has_function_name() const { return name[0] >= 'a' && name[0] <= 'z'; }
};
/// The constants of all operations, indexed by `Op`. Leaves have the default values.
inline constexpr OperationInfo operation_infos[] = {
    {}, {}, {},
#define KAGERO_OPERATION(OP, OPERATION)                                                                          \
    {operations::OPERATION::name,   operations::OPERATION::operands,   operations::OPERATION::flops,             \
     operations::OPERATION::rounding, operations::OPERATION::is_library, operations::OPERATION::is_abbreviation},
    KAGERO_OPERATIONS(KAGERO_OPERATION)
#undef KAGERO_OPERATION
};
inline constexpr int op_count = sizeof(operation_infos) / sizeof(OperationInfo), most_operands = 3;

constexpr const OperationInfo& info_of(Op op) { return operation_infos[static_cast<int>(op)]; }

#ifdef KAGERO_ISA  // only in kernel modules
namespace detail {

template <Op op, class T, int operands>
concept ComposedFor = Operation<op>::is_composed && Operation<op>::operands == operands &&
                      (RayNumber<T> || std::is_same_v<T, Quad>);

}  // namespace detail

/// Defines the composed functions of the table for scalars, packets and Quad.
#define KAGERO_OPERATION(OP, OPERATION)                                                             \
    template <class T>                                                                              \
        requires detail::ComposedFor<Op::OP, T, 1>                                                  \
    KAGERO_INLINE T OP(const T& a) { return operations::OPERATION::value(a); }                      \
    template <class T>                                                                              \
        requires detail::ComposedFor<Op::OP, T, 2>                                                  \
    KAGERO_INLINE T OP(const T& a, const T& b) { return operations::OPERATION::value(a, b); }
KAGERO_FUNCTIONS(KAGERO_OPERATION)
#undef KAGERO_OPERATION
#endif

}  // namespace kagero
