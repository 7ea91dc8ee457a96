// Quantities that rays carry along beside λ: every kind of step integrates them to the order of its method, and neither
// the state nor λ changes because of them.
#include "tests/kernels/steps.h"

#include "kernels/comparison/stages_in_lanes.h"
#include "kernels/integrators/shared_steps.h"
#include "kernels/methods/steppers.h"
#include "kernels/trace/packets.h"

namespace kagero::test {
namespace {

using hamiltonians::Fisheye, hamiltonians::Schwarzschild;

/// λ and two further quantities.
constexpr int carried_quantities = 3;
using Values = std::array<Quad, carried_quantities>;

/// Maxwell's fisheye, whose rays carry the optical path ∫ N² dτ and the change of q·p, ∫ (N² − q·∂K/∂q) dτ. On H = 0
/// both rates are functions of q.
template <class S>
struct FisheyeWithPaths : System<Fisheye, false, S> {
    using System<Fisheye, false, S>::System;
    static constexpr int carried = carried_quantities;
    static constexpr bool carried_rates_need_p = false;

    template <class V>
    KAGERO_INLINE void carried_rates(const State<V>& s, V* rates) const {
        rates[0] = Fisheye::index_squared(this->template parameters<V>(), s.q());
        rates[1] = rates[0] - dot(s.q(), this->dq(s));
    }
    /// Stereographic projection makes rays great circles, and the optical path n0 R/2 times the angle on the sphere.
    static Values closed_form(const State<Quad>& a, const State<Quad>& b) {
        const auto k = make_parameters<Fisheye>(default_parameters<Fisheye>().data());
        const Quad radius2 = Quad(k.radius) * k.radius, step2 = dot(b.q() - a.q(), b.q() - a.q());
        const Quad sine2 = radius2 * step2 / ((radius2 + dot(a.q(), a.q())) * (radius2 + dot(b.q(), b.q())));
        const Quad angle = 2 * atan2(sqrt(sine2), sqrt(1 - sine2));
        return {0, Quad(k.n0) * k.radius / 2 * angle, dot(b.q(), b.p()) - dot(a.q(), a.p())};
    }
    /// Rays with H = 0 to the last digit.
    static State<Quad> start(int which) {
        State<Quad> s = state_of<Quad>(bent_ray<Fisheye>(which));
        const auto k = make_parameters<Fisheye>(default_parameters<Fisheye>().data());
        const Quad length2 = Fisheye::index_squared<Quad>({k.n0, k.radius}, s.q());
        s.set(s.q(), sqrt(length2 / dot(s.p(), s.p())) * s.p());
        return s;
    }
};

/// Any H, whose rays carry ½|q|² and q·p, by their rates of change along the flow: these depend on p.
template <class H, bool Rescaled, class S>
struct WithProducts : System<H, Rescaled, S> {
    using System<H, Rescaled, S>::System;
    static constexpr int carried = carried_quantities;
    static constexpr bool carried_rates_need_p = true;

    template <class V>
    KAGERO_INLINE void carried_rates(const State<V>& s, V* rates) const {
        PhaseGradient<V> g;
        this->derivatives(s, g);
        rates[0] = dot(s.q(), velocity_in(g));
        rates[1] = dot(s.p(), velocity_in(g)) - dot(s.q(), force_in(g));
    }
    static Values closed_form(const State<Quad>& a, const State<Quad>& b) {
        return {0, (dot(b.q(), b.q()) - dot(a.q(), a.q())) / 2, dot(b.q(), b.p()) - dot(a.q(), a.p())};
    }
    static State<Quad> start(int which) { return state_of<Quad>(bent_ray<H>(which)); }
};

template <class S>
using SchwarzschildWithProducts = WithProducts<Schwarzschild, true, S>;
template <class S>
using FisheyeWithProducts = WithProducts<Fisheye, false, S>;

/// `steps` steps of length h; the rays carry N quantities. Stops after a step that is not solved.
template <class Stepper, int N, class System, class V>
StepperState<V, N> follow(const System& system, const Coefficients& coefficients, const State<V>& start, const V& h,
                  int steps) {
    using S = ScalarOf<V>;
    StepperState<V, N> f{};
    static_cast<State<V>&>(f.start) = start;
    f.h = h, f.options.want_carried = true, f.options.tolerance = Steps<V>::any_error;
    f.gradients = f.open_iterations = V(S(0));
    for (int k = 0; k < N; ++k) f.start.carried(k) = V(S(0));
    for (int i = 0; i < steps; ++i) {
        if (i > 0) f.start = f.end;
        f.start.velocity = system.dp(f.start);
        if (i == 0) Stepper::begin(system, f, coefficients);
        Stepper::step(system, f, coefficients);
        if (!(to_bits(f.solved) & 1)) break;
        f.end.pt() = f.start.pt();
    }
    return f;
}

/// Calls check.operator()<Stepper>(method) for the methods that serve a system.
template <class System, class Check>
void for_all_steps(const Check& check) {
    for (const Method& method : methods) {
        SCOPED_TRACE(method.info.name);
        visit_kind(method.kind, [&]<class Stepper>() {
            if constexpr (!Stepper::template refusal<System>()) check.template operator()<Stepper>(method);
        });
    }
}

/// What rays have carried at the end of the path, with λ by a method of high order that carries nothing else.
template <class System, class H>
Values expected(int which) {
    const auto parameters = default_parameters<H>();
    const kagero::System<H, System::rescaled, Quad> plain(parameters.data());
    constexpr int steps = 64;
    const State<Quad> start = System::start(which);
    const auto f = follow<Gauss<0>, 1>(plain, {.gauss = &gauss_tableau<8>}, start, Quad(path_length<H>) / steps, steps);
    EXPECT_TRUE(f.solved);
    Values values = System::closed_form(start, f.end);
    values[0] = f.end.parameter;
    return values;
}

struct Point {
    double steps, error;
};
/// Of −log error over log steps, by least squares.
double slope(const Point* first, const Point* last) {
    double sx = 0, sy = 0, sxx = 0, sxy = 0;
    const double n = double(last - first);
    for (const Point* p = first; p != last; ++p) {
        const double x = std::log(p->steps), y = -std::log(p->error);
        sx += x, sy += y, sxx += x * x, sxy += x * y;
    }
    return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

/// The errors of all quantities, summed over rays, where they are above rounding and every step was solved.
template <class Stepper, class System, class H>
std::array<std::vector<Point>, carried_quantities> errors(const Method& method) {
    static const Values exact[] = {expected<System, H>(0), expected<System, H>(1), expected<System, H>(2)};
    static_assert(std::size(exact) == bent_rays);
    const auto parameters = default_parameters<H>();
    const System system(parameters.data());
    const int order = int(method.info.order), finest = order <= 2 ? 256 : order <= 5 ? 128 : order <= 8 ? 48 : 24;
    const double rounding = 100 * std::max(coefficient_epsilon<Quad>(method), 1e-31);
    std::array<std::vector<Point>, carried_quantities> points;
    for (int coarse = 4; coarse <= finest; coarse *= 2) {
        for (const int steps : {coarse, coarse + coarse / 2}) {
            double sum[carried_quantities] = {};
            bool solved = true;
            for (int ray = 0; ray < bent_rays; ++ray) {
                const Quad h = Quad(path_length<H>) / steps;
                const State<Quad> start = System::start(ray);
                const auto f = follow<Stepper, carried_quantities>(system, method.coefficients, start, h, steps);
                solved = solved && f.solved;
                for (int k = 0; k < carried_quantities; ++k) sum[k] += double(abs(f.end.carried(k) - exact[ray][k]));
            }
            for (int k = 0; k < carried_quantities; ++k)
                if (solved && sum[k] > rounding) points[k].push_back({double(steps), sum[k]});
        }
    }
    return points;
}

template <class System, class H>
void expect_order() {
    int kinds = 0;
    for_all_steps<System>([&]<class Stepper>(const Method& method) {
        kinds |= 1 << int(method.kind);
        const auto all = errors<Stepper, System, H>(method);
        const double order = method.info.order;
        double least = std::numeric_limits<double>::infinity();
        for (int quantity = System::rescaled ? 0 : 1; quantity < carried_quantities; ++quantity) {
            const std::vector<Point>& points = all[quantity];
            std::string shown = "quantity " + std::to_string(quantity);
            for (const Point& p : points)
                shown += ", " + std::to_string(int(p.steps)) + ": " + std::to_string(std::log10(p.error));
            SCOPED_TRACE(shown);  // log10 of the errors
            // Explicit formulas of high order reach the rounding of their coefficients after a few step sizes.
            if (order >= 8 && !method.info.symmetric && points.size() < 3) continue;
            ASSERT_GE(points.size(), 3u);
            const Point* last = points.data() + points.size();
            const double found = std::max(slope(last - 3, last), slope(points.data(), last));
            EXPECT_GE(found, order - (order >= 8 ? 1.5 : 0.6));
            least = std::min(least, found);
        }
        if (std::isfinite(least) && order < 9) {
            EXPECT_LE(least, order + 1.6) << "of higher order after all?";
        }
    });
    const int generic =
        1 << int(Kind::composition) | 1 << int(Kind::runge_kutta) | 1 << int(Kind::gauss) | 1 << int(Kind::gauss_of_4);
    EXPECT_EQ(kinds, generic | (Nystroem::refusal<System>() ? 0 : 1 << int(Kind::nystroem)));
}

TEST(Carried, ByPositionInEverySeparableStepToItsOrder) {
    static_assert(!Nystroem::refusal<FisheyeWithPaths<Quad>>());
    expect_order<FisheyeWithPaths<Quad>, Fisheye>();
}
TEST(Carried, ByMomentumToTheOrderOfTheMethod) { expect_order<FisheyeWithProducts<Quad>, Fisheye>(); }
TEST(Carried, InImplicitStepsOfARescaledHamiltonianToTheOrderOfTheMethod) {
    expect_order<SchwarzschildWithProducts<Quad>, Schwarzschild>();
}

/// State and λ of rays that carry more are those of rays that do not, to the last bit; without rescaling λ is τ.
template <class System, class Plain, class H>
void expect_nothing_else_changes() {
    const auto parameters = default_parameters<H>();
    const System system(parameters.data());
    const Plain plain(parameters.data());
    const State<double> start = state_of<double>(bent_ray<H>());
    const double h = path_length<H> / 16;
    for_all_steps<System>([&]<class Stepper>(const Method& method) {
        const auto more = follow<Stepper, carried_quantities>(system, method.coefficients, start, h, 2);
        const auto less = follow<Stepper, 1>(plain, method.coefficients, start, h, 2);
        EXPECT_TRUE(more.solved && less.solved);
        for (int k = 0; k < phase_size; ++k) EXPECT_EQ(more.end.y[k], less.end.y[k]) << k;
        EXPECT_EQ(more.end.parameter, less.end.parameter);
        if constexpr (!System::rescaled) {
            EXPECT_EQ(more.end.parameter, h + h);
        }
    });
}
TEST(Carried, ChangesNeitherStateNorParameter) {
    expect_nothing_else_changes<FisheyeWithProducts<double>, System<Fisheye, false, double>, Fisheye>();
    expect_nothing_else_changes<SchwarzschildWithProducts<double>, System<Schwarzschild, true, double>,
                                Schwarzschild>();
}

// A ray in a packet carries what it does by itself, and so does one whose stages lie in the lanes.
TEST(Carried, IsTheSameInPacketsAndInLanes) {
    const auto parameters = default_parameters<Schwarzschild>();
    const SchwarzschildWithProducts<double> system(parameters.data());
    const RayStart ray = bent_ray<Schwarzschild>();
    const double h = path_length<Schwarzschild> / 16;
    for_all_steps<SchwarzschildWithProducts<double>>([&]<class Stepper>(const Method& method) {
        const auto one = follow<Stepper, carried_quantities>(system, method.coefficients, state_of<double>(ray), h, 2);
        const auto many = follow<Stepper, carried_quantities>(system, method.coefficients, state_of<PacketDouble>(ray),
                                                           PacketDouble(h), 2);
        EXPECT_TRUE(one.solved);
        for (int k = 0; k < carried_quantities; ++k)
            EXPECT_EQ(one.end.carried(k), get_lane(many.end.carried(k), 1)) << k;
        if constexpr (Stepper::family == Family::gauss) {
            const auto stages =
                follow<StagesInLanes<0>, carried_quantities>(system, method.coefficients, state_of<double>(ray), h, 2);
            for (int k = 0; k < carried_quantities; ++k) EXPECT_EQ(one.end.carried(k), stages.end.carried(k)) << k;
        }
    });
}

// A step in a called system carries what the same step does inline.
TEST(Carried, IsTheSameInCalledSystems) {
    using HoleWithProducts = WithProducts<Schwarzschild, false, double>;
    static_assert(HoleWithProducts::called);
    const auto parameters = default_parameters<Schwarzschild>();
    const HoleWithProducts system(parameters.data());
    const State<double> start = state_of<double>(bent_ray<Schwarzschild>());
    const double h = path_length<Schwarzschild> / 16;
    const auto compare = [&]<class Stepper>(const Coefficients& coefficients) {
        const auto direct = follow<Stepper, carried_quantities>(system, coefficients, start, h, 2);
        const auto called = follow<Stepper, carried_quantities>(as_called<double>(system), coefficients, start, h, 2);
        for (int k = 0; k < carried_quantities; ++k) EXPECT_EQ(direct.end.carried(k), called.end.carried(k)) << k;
    };
    compare.operator()<Composition>({.fractions = fractions::verlet});
    compare.operator()<RungeKutta>({.table = &kutta4});
    compare.operator()<Gauss<0>>({.gauss = &gauss_tableau<2>});
}

// Quantities that are not wanted keep their values.
TEST(Carried, StaysWhereItIsNotWanted) {
    const auto parameters = default_parameters<Schwarzschild>();
    const SchwarzschildWithProducts<double> system(parameters.data());
    for_all_steps<SchwarzschildWithProducts<double>>([&]<class Stepper>(const Method& method) {
        auto f = follow<Stepper, carried_quantities>(system, method.coefficients,
                                                  state_of<double>(bent_ray<Schwarzschild>()), 0.125, 1);
        f.options.want_carried = false;
        f.start.carried(1) = 3, f.start.carried(2) = -5;
        Stepper::step(system, f, method.coefficients);
        EXPECT_EQ(f.end.carried(1), 3);
        EXPECT_EQ(f.end.carried(2), -5);
    });
}

// Closed forms have no nodes, and Nyström's methods have no momentum at the position of a node.
TEST(Carried, IsRefusedWhereAStepCannotIntegrateIt) {
    using Hole = System<Schwarzschild, false, double>;
    using HoleWithProducts = WithProducts<Schwarzschild, false, double>;
    EXPECT_EQ(Orbit::refusal<Hole>(), nullptr);
    EXPECT_EQ(ExactSplit::refusal<Hole>(), nullptr);
    EXPECT_EQ(Recipe::refusal<Hole>(), nullptr);
    for (const char* reason : {Orbit::refusal<HoleWithProducts>(), ExactSplit::refusal<HoleWithProducts>(),
                               Recipe::refusal<HoleWithProducts>()}) {
        ASSERT_NE(reason, nullptr);
        EXPECT_NE(std::string(reason).find("carry"), std::string::npos) << reason;
    }
    EXPECT_EQ((Nystroem::refusal<System<Fisheye, false, double>>()), nullptr);
    EXPECT_NE(Nystroem::refusal<FisheyeWithProducts<double>>(), nullptr);
}

}  // namespace
}  // namespace kagero::test
