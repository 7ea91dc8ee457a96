/// How many floating-point operations a method costs, counted in the programs it runs. Lower bounds: products, sums, quotients, roots,
/// functions, minima and maxima count one each, fused ones two; comparisons, signs and masks count nothing.
#pragma once

#include "kernels/stepping/methods.h"

namespace kagero {

constexpr double operations_of(Op op) {
    switch (op) {
        case Op::constant: case Op::parameter: case Op::input: case Op::neg: case Op::at_least: return 0;
        case Op::mul_add: case Op::mul_sub: case Op::neg_mul_add: return 2;
        default: return 1;
    }
}

/// Of one run; what depends on parameters alone is done once per job.
template <int Size, int Outputs>
constexpr double operations_of(const Program<Size, Outputs>& program) {
    double sum = 0;
    for (int k = 0; k < program.size; ++k)
        if (!program.nodes[k].uniform) sum += operations_of(program.nodes[k].op);
    return sum;
}

/// Of the programs of a Hamiltonian that every method runs.
struct ProgramOperations {
    double derivatives, force, velocity, survey;
};

template <class H, bool Rescaled>
constexpr ProgramOperations program_operations() {
    return {operations_of(derivatives_program<H, Rescaled>), operations_of(force_program<H, Rescaled>),
            operations_of(velocity_program<H, Rescaled>), operations_of(survey_program<H, Rescaled>)};
}

/// A method on these programs: its gradients with what moves the state between them, and what it does once per step.
inline Operations operations_of(const Method& method, const ProgramOperations& program) {
    const double arrival = program.survey, one_sided = 0.5 * (program.force + program.velocity);
    switch (method.kind) {
        case Kind::gauss:
        case Kind::gauss_of_4: {
            // Sums of s stages: 2 s − 1 operations in each of six components; where the stage lies; how far it moved.
            const double s = method.coefficients.gauss->stages, sum = 6 * (2 * s - 1);
            return {program.derivatives + sum + 12 + 12, arrival + (s + 1) * sum + 30};
        }
        case Kind::runge_kutta: {
            const ButcherTable& table = *method.coefficients.table;
            double products = 0;
            for (int i = 0; i < table.stages; ++i) {
                products += (table.b[i] != 0) + (table.error[i] != 0);
                for (int j = 0; j < i; ++j) products += table.a[i][j] != 0;
            }
            return {program.derivatives, arrival + 12 * products};
        }
        default: return {one_sided + 6, arrival};
    }
}

}  // namespace kagero
