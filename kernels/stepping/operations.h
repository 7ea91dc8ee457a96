/// How many floating-point operations a method costs, counted in the programs it runs.
#pragma once

#include "kernels/stepping/methods.h"

namespace kagero {

/// A method on these programs: its gradients with what moves the state between them, and what it does once per step.
inline Operations operations_of(const Method& method, const ProgramOperations& program) {
    const auto alike = [](double per_gradient, double per_step) { return Operations{per_gradient, per_step, per_step}; };
    const double arrival = program.survey, one_sided = 0.5 * (program.force + program.velocity);
    switch (method.kind) {
        case Kind::gauss:
        case Kind::gauss_of_4: {
            // Sums of s stages: 2 s − 1 operations in each of six components; where the stage lies; how far it moved.
            const double s = method.coefficients.gauss->stages, sum = 6 * (2 * s - 1);
            return alike(program.derivatives + sum + 12 + 12, arrival + (s + 1) * sum + 30);
        }
        case Kind::runge_kutta: {
            const ButcherTable& table = *method.coefficients.table;
            double products = 0;
            for (int i = 0; i < table.stages; ++i) {
                products += (table.b[i] != 0) + (table.error[i] != 0);
                for (int j = 0; j < i; ++j) products += table.a[i][j] != 0;
            }
            return alike(program.derivatives, arrival + 12 * products);
        }
        // Into the plane, turning its axes, and out of it, or how long the step may be and whether it is the last: counted in orbit.h, with
        // sine, cosine and roots as what they are made of.
        case Kind::orbit: return {program.slope + 5, arrival + 145, 40};
        case Kind::composition:
        case Kind::recipe:
        case Kind::nystroem:
        case Kind::exact_split: return alike(one_sided + 6, arrival);
    }
    __builtin_unreachable();
}

}  // namespace kagero
