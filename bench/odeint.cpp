#include "bench/odeint.h"

#include "bench/kernels/gradient_rivals.h"

#include <boost/numeric/odeint.hpp>

#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

namespace kagero::bench {
namespace {

namespace odeint = boost::numeric::odeint;
using Numbers = std::array<double, 6>;  // q, p

/// Hamilton's equations of (16), H, or of K = r·H, with derivatives worked out by hand.
template <bool Rescaled>
struct Light {
    Hand<double, Rescaled> hand;
    double pt;

    void operator()(const Numbers& y, Numbers& slope, double) const {
        State<double> s;
        for (std::size_t k = 0; k < 6; ++k) s.y[k] = y[k];
        s.y[6] = pt;
        double out[6];
        hand.derivatives(s, out);
        for (std::size_t k = 0; k < 3; ++k) slope[k] = out[3 + k], slope[3 + k] = -out[k];
    }
    /// How long light takes to a sphere that is not far away, if it goes on as it does: dr/dλ = p_r − r_g (p_r + p_t)/r
    /// is about constant there.
    double time_to(double radius, const Numbers& y) const {
        const double square = y[0] * y[0] + y[1] * y[1] + y[2] * y[2], along = y[0] * y[3] + y[1] * y[4] + y[2] * y[5];
        if (along <= 0 || 9 * square < radius * radius) return std::numeric_limits<double>::infinity();
        const double r = std::sqrt(square), pr = along / r;
        const double speed = pr - hand.rg * (pr + pt) / r;
        if (!(speed > 0)) return std::numeric_limits<double>::infinity();
        return Rescaled ? std::log(radius / r) / speed : (radius - r) / speed;
    }
};

constexpr double first_step = 0.1;
constexpr int most_tries = 100, most_steps = 10000;

/// A stepper forgets the ray before.
void start_again(auto& stepper) {
    if constexpr (requires { stepper.reset(); }) stepper.reset();
}

/// A step that is as long as the tolerance allows; `length` becomes that of the next one.
template <class Stepper>
struct Controlled {
    Stepper stepper;
    explicit Controlled(double tolerance) : stepper(made(tolerance)) {}
    double begin() { return start_again(stepper), first_step; }
    template <class System>
    void step(const System& system, Numbers& y, double& length) {
        double time = 0;
        for (int i = 0; i < most_tries && stepper.try_step(system, y, time, length) == odeint::fail; ++i) {}
    }

private:
    static Stepper made(double tolerance) {
        if constexpr (requires { typename Stepper::stepper_type; })
            return odeint::make_controlled<typename Stepper::stepper_type>(tolerance, tolerance);
        else
            return Stepper(tolerance, tolerance);
    }
};
template <class Single>
using RungeKutta = Controlled<decltype(odeint::make_controlled<Single>(1.0, 1.0))>;
using BulirschStoer = Controlled<odeint::bulirsch_stoer<Numbers>>;

/// Steps of one length.
template <class Stepper>
struct Fixed {
    Stepper stepper;
    double length_of_all;
    explicit Fixed(double length) : length_of_all(length) {}
    double begin() { return start_again(stepper), length_of_all; }
    template <class System>
    void step(const System& system, Numbers& y, double& length) {
        stepper.do_step(system, y, 0.0, length);
    }
};

/// Steps of one length, of which each uses what the ones before found; one of another length is a Runge–Kutta method's,
/// as the first ones are.
template <std::size_t order>
struct Multistep {
    odeint::runge_kutta_fehlberg78<Numbers> single;
    odeint::adams_bashforth_moulton<order, Numbers> stepper;
    double length_of_all;
    bool started = false;
    explicit Multistep(double length) : length_of_all(length) {}
    double begin() { return started = false, length_of_all; }
    template <class System>
    void step(const System& system, Numbers& y, double& length) {
        double time = 0;
        if (length != length_of_all) single.do_step(system, y, time, length);
        else if (started) stepper.do_step(system, y, time, length);
        else stepper.initialize(single, system, y, time, length), started = true;
    }
};

/// Light to the escape sphere: the last steps are shortened to where it should be, and from very close it goes
/// straight.
template <class Way, bool Rescaled>
void follow(const Hole& hole, double number, const std::vector<RayStart>& starts, std::vector<RayEnd>& ends) {
    constexpr double close = 1e-5;
    Way way(number);
    for (std::size_t i = 0; i < starts.size(); ++i) {
        const RayStart& start = starts[i];
        const Light<Rescaled> light{Hand<double, Rescaled>(hole.rg), start.pt};
        Numbers y{start.q[0], start.q[1], start.q[2], start.p[0], start.p[1], start.p[2]}, slope;
        double length = way.begin();
        RayEnd& end = ends[i];
        end.status = Status::step_limit;
        for (int n = 0; n < most_steps; ++n) {
            double left = light.time_to(hole.escape_radius, y);
            if (std::abs(left) < close) {
                light(y, slope, 0);
                for (std::size_t k = 0; k < 6; ++k) y[k] += left * slope[k];
                end.status = Status::escaped;
                break;
            }
            way.step(light, y, left < length ? left : length);
        }
        light(y, slope, 0);
        const double inverse = 1 / std::sqrt(slope[0] * slope[0] + slope[1] * slope[1] + slope[2] * slope[2]);
        for (std::size_t k = 0; k < 3; ++k) end.q[k] = y[k], end.p[k] = y[3 + k], end.v[k] = inverse * slope[k];
    }
}

template <class Way, bool Rescaled>
void add(std::vector<OdeintWay>& ways, const std::string& name, const std::vector<double>& numbers) {
    for (const double number : numbers) {
        char text[32];
        std::snprintf(text, sizeof text, "%g", number);
        ways.push_back({name + (Rescaled ? "/K/" : "/H/") + text, follow<Way, Rescaled>, number});
    }
}
/// Steps as long as the tolerance allows fit either function; of one length they fit K alone.
template <class Way>
void add_controlled(std::vector<OdeintWay>& ways, const std::string& name) {
    std::vector<double> tolerances;
    for (int k = 3; k <= 14; ++k)
        for (const double share : {1.0, 0.5, 0.2}) tolerances.push_back(share * std::pow(10, -k));
    add<Way, false>(ways, name, tolerances);
    add<Way, true>(ways, name, tolerances);
}
template <class Way>
void add_fixed(std::vector<OdeintWay>& ways, const std::string& name) {
    std::vector<double> lengths;
    for (int k = -10; k <= 28; ++k) lengths.push_back(0.5 * std::pow(1.12, -k));  // from 1.55 to 0.02
    add<Way, true>(ways, name, lengths);
}

}  // namespace

std::vector<OdeintWay> odeint_ways() {
    std::vector<OdeintWay> ways;
    add_controlled<RungeKutta<odeint::runge_kutta_cash_karp54<Numbers>>>(ways, "cash_karp54");
    add_controlled<RungeKutta<odeint::runge_kutta_dopri5<Numbers>>>(ways, "dopri5");
    add_controlled<RungeKutta<odeint::runge_kutta_fehlberg78<Numbers>>>(ways, "fehlberg78");
    add_controlled<BulirschStoer>(ways, "bulirsch_stoer");
    add_fixed<Fixed<odeint::runge_kutta_dopri5<Numbers>>>(ways, "dopri5_fixed");
    add_fixed<Fixed<odeint::runge_kutta_fehlberg78<Numbers>>>(ways, "fehlberg78_fixed");
    add_fixed<Multistep<5>>(ways, "adams_bashforth_moulton5");
    add_fixed<Multistep<8>>(ways, "adams_bashforth_moulton8");
    return ways;
}

}  // namespace kagero::bench
