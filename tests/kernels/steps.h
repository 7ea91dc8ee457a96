/// Performs steps of a method in a space through `SpaceKernel`, in the same way as the tracing loop.
#pragma once

#include "tests/kernels/spaces.h"

#include "kernels/methods/space_kernel.h"

#include <algorithm>
#include <stdexcept>

namespace kagero::test {

/// Returns the methods that support H or, if `rescaled` is set, Ω·(H − H0), according to the module.
template <class H>
const std::vector<Method>& methods_for(bool rescaled) {
    static const auto supported = [](bool with_rescaling) {
        const Module& module = *kagero_kernels();
        std::vector<Method> found;
        for (std::uint32_t i = 0; i < module.integrator_count; ++i)
            if (!module.refusal(index_of<H>(), i, with_rescaling)) found.push_back(methods[i]);
        return found;
    };
    static const std::vector<Method> lists[] = {supported(false), supported(true)};
    return lists[rescaled];
}

/// Calls check(method, false) for each method that supports H. If H declares a time rescaling Ω, also calls
/// check(method, true) for each method that supports Ω·(H − H0).
template <class H, class Check>
void for_all_methods(const Check& check) {
    for (const bool rescaled : rescalings<H>()) {
        for (const Method& method : methods_for<H>(rescaled)) {
            SCOPED_TRACE(std::string(method.info.name) + (rescaled ? ", rescaled" : ""));
            check(method, rescaled);
        }
    }
}

/// Returns the row of the table of methods with the given name; throws if there is none.
inline const Method& method_named(const std::string& name) {
    for (const Method& m : methods)
        if (m.info.name == name) return m;
    throw std::runtime_error("no method " + name);
}

/// Returns the number of stages or substeps of a method per step, to which bounds on rounding errors are proportional.
inline int stages_of(const Method& m) {
    const Coefficients& c = m.coefficients;
    return c.table   ? c.table->stages
           : c.gauss ? c.gauss->stages
                     : static_cast<int>(c.fractions.size()) * (m.kind == StepperKind::recipe ? 3 : 1);
}
/// Returns true if the method is a collocation method.
inline bool collocates(const Method& m) { return m.coefficients.gauss != nullptr; }

/// Returns the relative rounding error of the coefficients of a method in the number type S. Only the coefficients of
/// collocation methods have more digits than double.
template <class S>
double coefficient_epsilon(const Method& m) {
    const double epsilon = static_cast<double>(machine_epsilon<S>);
    return collocates(m) ? epsilon : std::max(epsilon, machine_epsilon<double>);
}

/// Returns true if the step fractions of a composition are palindromic bit for bit. The published coefficients of
/// splitting methods are converted to fractions for semi-implicit Euler and its adjoint. This conversion rounds, so
/// that these fractions are palindromic only to rounding.
inline bool has_palindromic_fractions(const Method& m) {
    const Fractions f = m.coefficients.fractions;
    return std::equal(f.begin(), f.end(), f.rbegin());
}

/// Returns true if m is one of the methods that are implemented as printed in Satoh (2003) (stepper Recipe), and its
/// substeps are exact in the space of H. Recipe integrates each part of H by eq. (9). This is exact if the parts are
/// ½|p|² and V(q), which is also the condition for Nyström methods. In such a space the method is symmetric and has the
/// order of its fractions.
template <class H>
bool recipe_is_exact_split(const Method& m) {
    if (m.kind != StepperKind::recipe) return false;
    for (const Method& supported : methods_for<H>(false))
        if (supported.kind == StepperKind::nystroem) return true;
    return false;
}
/// Returns the order of a method in the space of H.
template <class H>
int order_in(const Method& m) {
    if (recipe_is_exact_split<H>(m)) return m.coefficients.fractions.size() == 1 ? 2 : 4;
    return static_cast<int>(m.info.order);
}
/// Returns true if a method is symmetric in the space of H.
template <class H>
bool symmetric_in(const Method& m) { return m.info.symmetric || recipe_is_exact_split<H>(m); }

/// Returns true if H contains exp, log or tanh, which packets and the standard library round differently.
template <class H>
bool has_exp_log_or_tanh() {
    static Tape tape;
    static const Recording<H> recorded(tape);
    return std::any_of(tape.nodes, tape.nodes + tape.size, [](const Node& n) {
        return !n.uniform && (n.op == Op::exp || n.op == Op::log || n.op == Op::tanh);
    });
}

/// A method in one space, with the state of its stepper.
template <class V>
class SpaceStepper {
public:
    StepperState<V> state;

    /// Returns a stepper for H or, if `rescaled` is set, for Ω·(H − H0), with the default parameters.
    template <class H>
    static SpaceStepper for_space(const Method& method, bool rescaled) {
        return with_kernel(method, space_kernel<H, V>(rescaled), default_parameters<H>().data());
    }

    /// Returns a stepper that uses the given kernel and parameters.
    static SpaceStepper with_kernel(const Method& method, const SpaceKernel<V>& kernel, const double* parameters) {
        return SpaceStepper(method, kernel, parameters);
    }

    /// Sets the start of the first step and the step length h, and initialises the stepper.
    void begin(const State<V>& start, const V& h) {
        static_cast<State<V>&>(state.start) = start;
        state.h = h;
        state.start.parameter = state.gradients = state.lane_iterations = V(ScalarOf<V>(0));
        state.options.compute_carried = state.options.compute_energy_error = state.options.compute_energy = true;
        kernel_.begin[static_cast<int>(method_.kind)](system_, state, method_.coefficients);
        state.end = state.start;
    }
    /// Performs one step from state.start to state.end.
    void step() { kernel_.step[static_cast<int>(method_.kind)](system_, state, method_.coefficients); }
    /// Performs n steps. state.end is the end of the last step.
    void advance(int n) {
        for (int i = 0; i < n; ++i) {
            step();
            state.start = state.end;
        }
    }

    /// A tolerance with which adaptive methods accept every step, so that their step length is fixed.
    static constexpr ScalarOf<V> unlimited_tolerance = ScalarOf<V>(1e30f);

private:
    SpaceStepper(const Method& method, const SpaceKernel<V>& kernel, const double* parameters)
        : method_(method), kernel_(kernel) {
        kernel_.construct(system_, parameters);
        state.options.tolerance = unlimited_tolerance;
    }

    Method method_;
    SpaceKernel<V> kernel_;
    SystemStorage system_;
};

/// How the right-hand sides of Hamilton's equations depend on the state.
enum class Motion {
    straight,  ///< The force is zero.
    uniform,   ///< The force is constant.
    linear,    ///< The right-hand sides are linear functions of the state.
    general,   ///< The right-hand sides are nonlinear functions of the state.
};

/// Returns how the right-hand sides of Hamilton's equations of H depend on the state. Compares gradients of H at random
/// states and halfway between two of these states.
template <class H>
Motion motion_in() {
    auto stepper = SpaceStepper<double>::for_space<H>(method_named("gauss8"), false);
    const auto rays = random_rays<H>(12, 17);
    const auto gradient = [&](const State<double>& s) {
        stepper.begin(s, 0);  // computes the gradient of H
        return std::to_array(stepper.state.stage[0]);
    };
    double force = 0, change = 0, nonlinearity = 0, size = 0;
    for (std::size_t i = 1; i < rays.size(); ++i) {
        const auto a = state_of<double>(rays[0]), b = state_of<double>(rays[i]);
        State<double> middle = a;
        for (int k = 0; k < 6; ++k) middle.y[k] = 0.5 * (a.y[k] + b.y[k]);
        const auto ga = gradient(a), gb = gradient(b), g_middle = gradient(middle);
        for (int k = 0; k < 6; ++k) {
            if (k < 3) {
                force = std::max(force, std::abs(ga[k]));
                change = std::max(change, std::abs(gb[k] - ga[k]));
            }
            nonlinearity = std::max(nonlinearity, std::abs(ga[k] + gb[k] - 2 * g_middle[k]));
            size = std::max(size, std::abs(gb[k]));
        }
    }
    const double rounding = 100 * machine_epsilon<double> * size;
    return nonlinearity > rounding ? Motion::general
           : change > rounding     ? Motion::linear
           : force > rounding      ? Motion::uniform
                                   : Motion::straight;
}

}  // namespace kagero::test
