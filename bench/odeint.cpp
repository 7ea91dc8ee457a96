#include "bench/odeint.h"

#include "bench/kernels/gradient_methods.h"

#include <boost/numeric/odeint.hpp>

#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

namespace kagero::bench {
namespace {

namespace odeint = boost::numeric::odeint;
using PhasePoint = std::array<double, 6>;  // q, p

/// Hamilton's equations for H of Satoh (2003), equation (16), or for K = r·H. The derivatives are written by hand.
template <bool Rescaled>
struct RayEquations {
    HandWritten<double, Rescaled> hamiltonian;
    double pt;

    /// Sets `derivative` to dy/dλ, or to dy/dτ if `Rescaled`.
    void operator()(const PhasePoint& y, PhasePoint& derivative, double) const {
        State<double> s;
        for (std::size_t k = 0; k < 6; ++k) s.y[k] = y[k];
        s.y[6] = pt;
        double gradient[6];
        hamiltonian.derivatives(s, gradient);
        for (std::size_t k = 0; k < 3; ++k) {
            derivative[k] = gradient[3 + k];
            derivative[3 + k] = -gradient[k];
        }
    }
    /// Estimates the increase of λ, or of τ if `Rescaled`, up to the sphere r = radius. Near that sphere
    /// dr/dλ = p_r − r_g (p_r + p_t)/r is about constant; dτ = dλ/r. Returns infinity for inward rays and for
    /// 3 r < radius.
    double parameter_to(double radius, const PhasePoint& y) const {
        const double qq = y[0] * y[0] + y[1] * y[1] + y[2] * y[2], qp = y[0] * y[3] + y[1] * y[4] + y[2] * y[5];
        if (qp <= 0 || 9 * qq < radius * radius) return std::numeric_limits<double>::infinity();
        const double r = std::sqrt(qq), pr = qp / r;
        const double dr = pr - hamiltonian.rg * (pr + pt) / r;  // dr/dλ
        if (!(dr > 0)) return std::numeric_limits<double>::infinity();
        return Rescaled ? std::log(radius / r) / dr : (radius - r) / dr;
    }
};

/// Length of the first step of methods with step control.
constexpr double first_step = 0.1;
/// Limit of the attempts at one step of a method with step control.
constexpr int max_tries = 100;
/// Limit of the steps of a ray.
constexpr int max_steps = 10000;

/// Resets a stepper that keeps data between steps; call before each ray.
void reset_stepper(auto& stepper) {
    if constexpr (requires { stepper.reset(); }) stepper.reset();
}

/// Stepper with step control. `step` replaces `length` by the proposed length of the next step.
template <class Stepper>
struct Controlled {
    Stepper stepper;
    explicit Controlled(double tolerance) : stepper(make_stepper(tolerance)) {}
    /// Prepares for a new ray and returns the length of its first step.
    double begin() {
        reset_stepper(stepper);
        return first_step;
    }
    template <class System>
    void step(const System& system, PhasePoint& y, double& length) {
        double time = 0;
        for (int i = 0; i < max_tries && stepper.try_step(system, y, time, length) == odeint::fail; ++i) {}
    }

private:
    static Stepper make_stepper(double tolerance) {
        if constexpr (requires { typename Stepper::stepper_type; })
            return odeint::make_controlled<typename Stepper::stepper_type>(tolerance, tolerance);
        else
            return Stepper(tolerance, tolerance);
    }
};
template <class Stepper>
using RungeKutta = Controlled<decltype(odeint::make_controlled<Stepper>(1.0, 1.0))>;
using BulirschStoer = Controlled<odeint::bulirsch_stoer<PhasePoint>>;

/// One-step method with a fixed step. Only the last steps of a ray have another length.
template <class Stepper>
struct Fixed {
    Stepper stepper;
    double fixed_length;
    explicit Fixed(double length) : fixed_length(length) {}
    double begin() {
        reset_stepper(stepper);
        return fixed_length;
    }
    template <class System>
    void step(const System& system, PhasePoint& y, double& length) {
        stepper.do_step(system, y, 0.0, length);
    }
};

/// Multistep method with a fixed step. A Runge–Kutta method takes the first steps, and the last steps of a ray, which
/// are shorter.
template <std::size_t order>
struct Multistep {
    odeint::runge_kutta_fehlberg78<PhasePoint> runge_kutta;
    odeint::adams_bashforth_moulton<order, PhasePoint> stepper;
    double fixed_length;
    bool has_history = false;  ///< True if `stepper` contains the derivatives at previous steps of this ray.
    explicit Multistep(double length) : fixed_length(length) {}
    double begin() {
        has_history = false;
        return fixed_length;
    }
    template <class System>
    void step(const System& system, PhasePoint& y, double& length) {
        double time = 0;
        if (length != fixed_length) runge_kutta.do_step(system, y, time, length);
        else if (has_history) stepper.do_step(system, y, time, length);
        else {
            stepper.initialize(runge_kutta, system, y, time, length);
            has_history = true;
        }
    }
};

/// Integrates rays to the escape sphere. `number` is the tolerance or the step length. The last steps are shortened so
/// that they end at the estimated parameter of the sphere. If the remaining parameter is less than 1e-5, one Euler step
/// reaches the sphere.
template <class Method, bool Rescaled>
void integrate(const Hole& hole, double number, const std::vector<RayStart>& starts, std::vector<RayEnd>& ends) {
    constexpr double close = 1e-5;
    Method method(number);
    for (std::size_t i = 0; i < starts.size(); ++i) {
        const RayStart& start = starts[i];
        const RayEquations<Rescaled> equations{HandWritten<double, Rescaled>(hole.rg), start.pt};
        PhasePoint y{start.q[0], start.q[1], start.q[2], start.p[0], start.p[1], start.p[2]}, derivative;
        double length = method.begin();
        RayEnd& end = ends[i];
        end.status = Status::step_limit;
        for (int n = 0; n < max_steps; ++n) {
            double remaining = equations.parameter_to(hole.escape_radius, y);
            if (std::abs(remaining) < close) {
                equations(y, derivative, 0);
                for (std::size_t k = 0; k < 6; ++k) y[k] += remaining * derivative[k];
                end.status = Status::escaped;
                break;
            }
            method.step(equations, y, remaining < length ? remaining : length);
        }
        equations(y, derivative, 0);
        const double* velocity = derivative.data();
        const double inverse =
            1 / std::sqrt(velocity[0] * velocity[0] + velocity[1] * velocity[1] + velocity[2] * velocity[2]);
        for (std::size_t k = 0; k < 3; ++k) {
            end.q[k] = y[k];
            end.p[k] = y[3 + k];
            end.v[k] = inverse * velocity[k];
        }
    }
}

/// Adds a stepper for K if `Rescaled`, else for H, with each tolerance or step length in `numbers`.
template <class Method, bool Rescaled>
void add(std::vector<OdeintMethod>& methods, const std::string& name, const std::vector<double>& numbers) {
    for (const double number : numbers) {
        char text[32];
        std::snprintf(text, sizeof text, "%g", number);
        methods.push_back({name + (Rescaled ? "/K/" : "/H/") + text, integrate<Method, Rescaled>, number});
    }
}
/// Adds a stepper with step control for H and for K.
template <class Method>
void add_controlled(std::vector<OdeintMethod>& methods, const std::string& name) {
    std::vector<double> tolerances;
    for (int k = 3; k <= 14; ++k)
        for (const double share : {1.0, 0.5, 0.2}) tolerances.push_back(share * std::pow(10, -k));
    add<Method, false>(methods, name, tolerances);
    add<Method, true>(methods, name, tolerances);
}
/// Adds a stepper with a fixed step for K. A fixed step is inefficient for H, which needs short steps near the hole.
template <class Method>
void add_fixed(std::vector<OdeintMethod>& methods, const std::string& name) {
    std::vector<double> lengths;
    for (int k = -10; k <= 28; ++k) lengths.push_back(0.5 * std::pow(1.12, -k));  // from 1.55 to 0.02
    add<Method, true>(methods, name, lengths);
}

}  // namespace

std::vector<OdeintMethod> odeint_methods() {
    std::vector<OdeintMethod> methods;
    add_controlled<RungeKutta<odeint::runge_kutta_cash_karp54<PhasePoint>>>(methods, "cash_karp54");
    add_controlled<RungeKutta<odeint::runge_kutta_dopri5<PhasePoint>>>(methods, "dopri5");
    add_controlled<RungeKutta<odeint::runge_kutta_fehlberg78<PhasePoint>>>(methods, "fehlberg78");
    add_controlled<BulirschStoer>(methods, "bulirsch_stoer");
    add_fixed<Fixed<odeint::runge_kutta_dopri5<PhasePoint>>>(methods, "dopri5_fixed");
    add_fixed<Fixed<odeint::runge_kutta_fehlberg78<PhasePoint>>>(methods, "fehlberg78_fixed");
    add_fixed<Multistep<5>>(methods, "adams_bashforth_moulton5");
    add_fixed<Multistep<8>>(methods, "adams_bashforth_moulton8");
    return methods;
}

}  // namespace kagero::bench
