/// The programs of a formula as machine code, which the compiler module generates if it is installed. Without it, the
/// interpreter evaluates the same programs; both give the same bits.
#pragma once

#include "kernels/abi.h"
#include "kernels/simd/lanes.h"

namespace kagero::formula {

/// The machine code of one program for one value type; null pointers if there is none.
struct CompiledProgram {
    CompiledFunction evaluate = nullptr;
    /// The program in two parts: `prepare` computes the values that do not depend on the varying inputs, from the
    /// inputs of the program. `evaluate_prepared` computes the outputs; its inputs are those of the program and these
    /// values. If there are no such values, `prepare` is null.
    CompiledFunction prepare = nullptr, evaluate_prepared = nullptr;
};

/// Index of a value type in the list of types for which programs are compiled; −1 for other types, such as dual
/// numbers, whose programs are always interpreted. The types from `interpreted_type_count` on are used only by
/// kernels/comparison. For them, no interpreter exists.
template <class V>
inline constexpr int compiled_type = -1;
template <>
inline constexpr int compiled_type<Lanes<double, 2>> = 0;
template <>
inline constexpr int compiled_type<Lanes<float, 2>> = 1;
template <>
inline constexpr int compiled_type<double> = 2;
template <>
inline constexpr int compiled_type<float> = 3;
template <>
inline constexpr int compiled_type<Lanes<double, 1>> = 4;
template <>
inline constexpr int compiled_type<Lanes<double, 4>> = 5;
template <>
inline constexpr int compiled_type<Lanes<float, 1>> = 6;
template <>
inline constexpr int compiled_type<Lanes<float, 4>> = 7;
inline constexpr int interpreted_type_count = 4, compiled_type_count = 8;

/// True if programs with this value type can be interpreted.
template <class V>
inline constexpr bool is_interpreted = compiled_type<V> < interpreted_type_count;

}  // namespace kagero::formula
