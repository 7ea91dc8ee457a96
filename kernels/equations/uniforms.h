/// The values of a program that depend only on the parameters of the Hamiltonian.
#pragma once

#include "kernels/autodiff/program.h"
#include "kernels/simd/lane_memory.h"

namespace kagero {

/// Returns parameter i as a number of type S. If S is a packet, `parameters` contains one number per lane for each
/// parameter: first those of parameter 0, then those of parameter 1, etc.
template <class S>
S parameter_of(const double* parameters, int i) {
    return lanes_of<S>(parameters + i * lane_count<S>);
}

/// The values of the uniform nodes of a program, rounded to S from double or a more precise type.
template <const auto& P, class S>
struct Uniforms {
    S values[P.uniforms + 1];
    explicit Uniforms(const double* parameters) {
        using Wide = decltype(S() + 1.0);
        Wide wide[P.uniforms + 1] = {}, k[parameter_capacity] = {};
        for (int i = 0; i < P.parameter_count(); ++i) k[i] = parameter_of<Wide>(parameters, i);
        fill_uniforms(P.nodes, P.slot, P.size, k, wide);
        for (int i = 0; i < P.uniforms; ++i) values[i] = S(wide[i]);
    }

private:
    static constexpr int parameter_capacity = P.parameter_count() + 1;
};

}  // namespace kagero
