/// Steps of one method in one space, taken through `SpaceKernel` as the tracing loop takes them.
#pragma once

#include "tests/kernels/spaces.h"

#include "kernels/methods/space_kernel.h"

#include <algorithm>
#include <stdexcept>

namespace kagero::test {

/// The methods that serve H or Ω·(H − H0), as the module says.
template <class H>
const std::vector<Method>& methods_for(bool rescaled) {
    static const auto served = [](bool transformed) {
        const Module& module = *kagero_kernels();
        std::vector<Method> all;
        for (std::uint32_t i = 0; i < module.integrator_count; ++i)
            if (!module.refusal(index_of<H>(), i, transformed)) all.push_back(methods[i]);
        return all;
    };
    static const std::vector<Method> in[] = {served(false), served(true)};
    return in[rescaled];
}

/// Calls check(method, rescaled) for all forms of H and all methods that serve them.
template <class H, class Check>
void for_all_methods(const Check& check) {
    for (const bool rescaled : rescalings<H>()) {
        for (const Method& method : methods_for<H>(rescaled)) {
            SCOPED_TRACE(std::string(method.info.name) + (rescaled ? ", rescaled" : ""));
            check(method, rescaled);
        }
    }
}

inline const Method& method_named(const std::string& name) {
    for (const Method& m : methods)
        if (m.info.name == name) return m;
    throw std::runtime_error("no method " + name);
}

/// Substeps of a method, each with its roundings.
inline int stages_of(const Method& m) {
    const Coefficients& c = m.coefficients;
    return c.table   ? c.table->stages
           : c.gauss ? c.gauss->stages
                     : static_cast<int>(c.fractions.size()) * (m.kind == Kind::recipe ? 3 : 1);
}
inline bool collocates(const Method& m) { return m.coefficients.gauss != nullptr; }

/// Rounding of a method's numbers: only those of collocation have more digits than double.
template <class S>
double coefficient_epsilon(const Method& m) {
    const double epsilon = static_cast<double>(machine_epsilon<S>);
    return collocates(m) ? epsilon : std::max(epsilon, machine_epsilon<double>);
}

/// Whether the same fractions come back in reverse to the last bit: a splitting written for χ and χ* is rounded on the
/// way.
inline bool mirrored(const Method& m) {
    const Fractions f = m.coefficients.fractions;
    return std::equal(f.begin(), f.end(), f.rbegin());
}

/// The printed recipe takes each part of H by eq. (9). Where the parts are ½|p|² and V(q), as Nyström methods want
/// them, that is exact, and the recipe what its name says: symmetric, of the order of its fractions.
template <class H>
bool recipe_is_exact_split(const Method& m) {
    if (m.kind != Kind::recipe) return false;
    for (const Method& served : methods_for<H>(false))
        if (served.kind == Kind::nystroem) return true;
    return false;
}
template <class H>
int order_on(const Method& m) {
    if (recipe_is_exact_split<H>(m)) return m.coefficients.fractions.size() == 1 ? 2 : 4;
    return static_cast<int>(m.info.order);
}
template <class H>
bool symmetric_on(const Method& m) { return m.info.symmetric || recipe_is_exact_split<H>(m); }

/// Whether H computes functions that packets and the standard library round differently.
template <class H>
bool is_transcendental() {
    static Tape tape;
    static const Recording<H> recorded(tape);
    return std::any_of(tape.nodes, tape.nodes + tape.size, [](const Node& n) {
        return !n.uniform && (n.op == Op::exp || n.op == Op::log || n.op == Op::tanh);
    });
}

template <class V>
class Steps {
public:
    StepperState<V> flow;

    template <class H>
    static Steps in(const Method& method, bool rescaled) {
        return with(method, space_kernel<H, V>(rescaled), default_parameters<H>().data());
    }

    static Steps with(const Method& method, const SpaceKernel<V>& kernel, const double* parameters) {
        return Steps(method, kernel, parameters);
    }

    /// Sets out with step length h, in every lane that of `start`.
    void begin(const State<V>& start, const V& h) {
        static_cast<State<V>&>(flow.start) = start;
        flow.h = h;
        flow.start.parameter = flow.gradients = flow.open_iterations = V(ScalarOf<V>(0));
        flow.options.want_carried = flow.options.want_energy = flow.options.want_path = true;
        kernel_.begin[static_cast<int>(method_.kind)](system_, flow, method_.coefficients);
        flow.end = flow.start;
    }
    /// One step, from flow.start to flow.end.
    void step() { kernel_.step[static_cast<int>(method_.kind)](system_, flow, method_.coefficients); }
    /// n steps; flow.end is where they lead.
    void advance(int n) {
        for (int i = 0; i < n; ++i) {
            step();
            flow.start = flow.end;
        }
    }

    /// With this tolerance adaptive methods accept every step, as methods of fixed step do.
    static constexpr ScalarOf<V> any_error = ScalarOf<V>(1e30f);

private:
    Steps(const Method& method, const SpaceKernel<V>& kernel, const double* parameters)
        : method_(method), kernel_(kernel) {
        kernel_.construct(system_, parameters);
        flow.options.tolerance = any_error;
    }

    Method method_;
    SpaceKernel<V> kernel_;
    SystemStorage system_;
};

/// How the right-hand sides of Hamilton's equations depend on the state.
enum class Motion { straight, uniform, linear, general };

/// Found by trying: derivatives at random states and at the states halfway between. Gauss methods begin with the
/// gradient of H.
template <class H>
Motion motion_in() {
    auto steps = Steps<double>::in<H>(method_named("gauss8"), false);
    const auto rays = random_rays<H>(12, 17);
    const auto gradient = [&](const State<double>& s) {
        steps.begin(s, 0);
        return std::to_array(steps.flow.stage[0]);
    };
    double force = 0, change = 0, bend = 0, size = 0;
    for (std::size_t i = 1; i < rays.size(); ++i) {
        const auto a = state_of<double>(rays[0]), b = state_of<double>(rays[i]);
        State<double> half = a;
        for (int k = 0; k < 6; ++k) half.y[k] = 0.5 * (a.y[k] + b.y[k]);
        const auto ga = gradient(a), gb = gradient(b), gh = gradient(half);
        for (int k = 0; k < 6; ++k) {
            if (k < 3) force = std::max(force, std::abs(ga[k])), change = std::max(change, std::abs(gb[k] - ga[k]));
            bend = std::max(bend, std::abs(ga[k] + gb[k] - 2 * gh[k]));
            size = std::max(size, std::abs(gb[k]));
        }
    }
    const double rounding = 100 * machine_epsilon<double> * size;
    return bend > rounding     ? Motion::general
           : change > rounding ? Motion::linear
           : force > rounding  ? Motion::uniform
                               : Motion::straight;
}

}  // namespace kagero::test
