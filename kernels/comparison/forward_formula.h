/// A formula whose gradient is computed by forward-mode differentiation of K, with its components in the lanes. The
/// strategy `per-ray` uses it in its form `gradient`. All functions except the derivatives are those of formulas.
#pragma once

#include "kernels/formula/formula_system.h"
#include "kernels/simd/packed.h"

namespace kagero {

/// A formula with forward programs, which exist only as machine code.
template <bool is_separable>
class ForwardFormula : public System<formula::AnyFormula<is_separable>, false, double> {
    using Base = System<formula::AnyFormula<is_separable>, false, double>;

public:
    using CommonBase = ForwardFormula;
    using SplitGradientBase = ForwardFormula;

    explicit ForwardFormula(const double* parameters)
        : Base(parameters), programs_(formula::programs_in(parameters).forward) {}

    void derivatives(const State<double>& s, double* out) const { gradient<formula::forward_all, phase_size>(s, out); }
    Vec3<double> gradient_q(const State<double>& s) const { return half<formula::forward_by_position>(s); }
    Vec3<double> gradient_p(const State<double>& s) const { return half<formula::forward_by_momentum>(s); }
    // Steppers use the functions above instead of these.
    template <class V>
    void derivatives_at(int) const = delete;
    template <class V>
    void prepared_force(const State<V>&) const = delete;
    template <class V>
    void prepared_velocity(const State<V>&) const = delete;

private:
    /// Computes n derivatives of K.
    template <formula::ForwardIndex program, int n>
    void gradient(const State<double>& s, double* out) const {
        Packed<double, n> g;
        programs_[program].evaluate(s.y, &g, 1);
        std::memcpy(out, &g, n * sizeof(double));
    }
    template <formula::ForwardIndex program>
    Vec3<double> half(const State<double>& s) const {
        double g[space_size];
        gradient<program, space_size>(s, g);
        return {g[0], g[1], g[2]};
    }

    const formula::ForwardProgram* programs_;
};

}  // namespace kagero
