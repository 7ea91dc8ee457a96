// Tests of carried quantities besides λ. Every stepper must integrate them with the order of its method. Their presence
// must change neither the state nor λ. The reference values are closed forms at the ends of rays that are integrated in
// quadruple precision.
#include "tests/kernels/steps.h"

#include "kernels/comparison/stages_in_lanes.h"
#include "kernels/integrators/shared_steps.h"
#include "kernels/methods/steppers.h"
#include "kernels/trace/packets.h"

namespace kagero::test {
namespace {

using hamiltonians::Fisheye, hamiltonians::Schwarzschild;

/// Number of carried quantities: λ and two others.
constexpr int carried_quantities = 3;
/// One value for each carried quantity; the first is λ.
using CarriedValues = std::array<Quad, carried_quantities>;

/// Maxwell's fisheye with two carried quantities: the optical path ∫ N² dτ, where N is the index of refraction, and the
/// change of q·p, which is ∫ (N² − q·∂K/∂q) dτ. On H = 0 both rates are functions of q alone.
template <class S>
struct FisheyeWithPaths : System<Fisheye, false, S> {
    using System<Fisheye, false, S>::System;
    static constexpr int carried = carried_quantities;
    static constexpr bool carried_rates_need_p = false;

    template <class V>
    KAGERO_INLINE void carried_rates(const State<V>& s, V* rates) const {
        rates[0] = Fisheye::index_squared(this->template parameters<V>(), s.q());
        rates[1] = rates[0] - dot(s.q(), this->gradient_q(s));
    }
    /// Returns the carried quantities of a ray from a to b; the element for λ is 0. Stereographic projection maps the
    /// rays of the fisheye to great circles. The optical path is n0 R/2 times the angle between the images of a and b
    /// on the sphere, where R is the radius of the fisheye.
    static CarriedValues closed_form(const State<Quad>& a, const State<Quad>& b) {
        const auto k = make_parameters<Fisheye>(default_parameters<Fisheye>().data());
        const Quad radius2 = Quad(k.radius) * k.radius, distance2 = dot(b.q() - a.q(), b.q() - a.q());
        const Quad sine2 =  // sin² of half the angle
            radius2 * distance2 / ((radius2 + dot(a.q(), a.q())) * (radius2 + dot(b.q(), b.q())));
        const Quad angle = 2 * atan2(sqrt(sine2), sqrt(1 - sine2));
        return {0, Quad(k.n0) * k.radius / 2 * angle, dot(b.q(), b.p()) - dot(a.q(), a.p())};
    }
    /// Returns the start of a bent ray. Its momentum is rescaled so that H = 0 in quadruple precision.
    static State<Quad> start(int ray_index) {
        State<Quad> s = state_of<Quad>(bent_ray<Fisheye>(ray_index));
        const auto k = make_parameters<Fisheye>(default_parameters<Fisheye>().data());
        const Quad n2 = Fisheye::index_squared<Quad>({k.n0, k.radius}, s.q());
        s.set(s.q(), sqrt(n2 / dot(s.p(), s.p())) * s.p());
        return s;
    }
};

/// The system of H with two carried quantities: the changes of ½|q|² and of q·p along the ray. Their rates depend on p.
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
    /// Returns the carried quantities of a ray from a to b; the element for λ is 0.
    static CarriedValues closed_form(const State<Quad>& a, const State<Quad>& b) {
        return {0, (dot(b.q(), b.q()) - dot(a.q(), a.q())) / 2, dot(b.q(), b.p()) - dot(a.q(), a.p())};
    }
    static State<Quad> start(int ray_index) { return state_of<Quad>(bent_ray<H>(ray_index)); }
};

template <class S>
using SchwarzschildWithProducts = WithProducts<Schwarzschild, true, S>;
template <class S>
using FisheyeWithProducts = WithProducts<Fisheye, false, S>;

/// Performs `steps` steps of length h with N carried quantities. Stops after a step whose equations were not solved.
/// Returns the stepper state after the last step.
template <class Stepper, int N, class System, class V>
StepperState<V, N> integrate(const System& system, const Coefficients& coefficients, const State<V>& start, const V& h,
                             int steps) {
    using S = ScalarOf<V>;
    StepperState<V, N> state{};
    static_cast<State<V>&>(state.start) = start;
    state.h = h;
    state.options.compute_carried = true;
    state.options.tolerance = SpaceStepper<V>::unlimited_tolerance;
    state.gradients = state.lane_iterations = V(S(0));
    for (int k = 0; k < N; ++k) state.start.carried(k) = V(S(0));
    for (int i = 0; i < steps; ++i) {
        if (i > 0) state.start = state.end;
        state.start.velocity = system.gradient_p(state.start);
        if (i == 0) Stepper::begin(system, state, coefficients);
        Stepper::step(system, state, coefficients);
        if (!(to_bits(state.solved) & 1)) break;
        state.end.pt() = state.start.pt();
    }
    return state;
}

/// Calls check.operator()<Stepper>(method) for each method whose stepper supports the type `System`.
template <class System, class Check>
void for_all_steppers(const Check& check) {
    for (const Method& method : methods) {
        SCOPED_TRACE(method.info.name);
        visit_kind(method.kind, [&]<class Stepper>() {
            if constexpr (!Stepper::template refusal<System>()) check.template operator()<Stepper>(method);
        });
    }
}

/// Returns the exact carried quantities at the end of the path of a bent ray. The state and λ at the end are computed
/// by a collocation method of order 16, without carried quantities other than λ.
template <class System, class H>
CarriedValues expected(int ray_index) {
    const auto parameters = default_parameters<H>();
    const kagero::System<H, System::rescaled, Quad> plain(parameters.data());
    constexpr int steps = 64;
    const State<Quad> start = System::start(ray_index);
    const Quad h = Quad(path_length<H>) / steps;
    const auto state = integrate<Gauss<0>, 1>(plain, {.gauss = &gauss_tableau<8>}, start, h, steps);
    EXPECT_TRUE(state.solved);
    CarriedValues values = System::closed_form(start, state.end);
    values[0] = state.end.parameter;
    return values;
}

/// An error, and the number of steps with which it was measured.
struct Measurement {
    double steps, error;
};
/// Returns the order that the errors imply: the slope of −log(error) over log(steps), by least squares.
double fitted_order(const Measurement* first, const Measurement* last) {
    double sx = 0, sy = 0, sxx = 0, sxy = 0;
    const double n = double(last - first);
    for (const Measurement* p = first; p != last; ++p) {
        const double x = std::log(p->steps), y = -std::log(p->error);
        sx += x;
        sy += y;
        sxx += x * x;
        sxy += x * y;
    }
    return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

/// Returns the errors of each carried quantity for several numbers of steps, summed over the bent rays. Leaves out
/// errors below the rounding level, and numbers of steps for which the equations of a step were not solved.
template <class Stepper, class System, class H>
std::array<std::vector<Measurement>, carried_quantities> errors(const Method& method) {
    static const CarriedValues exact[] = {expected<System, H>(0), expected<System, H>(1), expected<System, H>(2)};
    static_assert(std::size(exact) == bent_ray_count);
    const auto parameters = default_parameters<H>();
    const System system(parameters.data());
    const int order = int(method.info.order), most_steps = order <= 5 ? 32 : 24;
    const double rounding = 100 * std::max(coefficient_epsilon<Quad>(method), 1e-31);
    std::array<std::vector<Measurement>, carried_quantities> measurements;
    for (int coarse = 4; coarse <= most_steps; coarse *= 2) {
        for (const int steps : {coarse, coarse + coarse / 2}) {
            double sum[carried_quantities] = {};
            bool solved = true;
            for (int ray = 0; ray < bent_ray_count; ++ray) {
                const Quad h = Quad(path_length<H>) / steps;
                const State<Quad> start = System::start(ray);
                const auto state = integrate<Stepper, carried_quantities>(system, method.coefficients, start, h, steps);
                solved = solved && state.solved;
                for (int k = 0; k < carried_quantities; ++k)
                    sum[k] += double(abs(state.end.carried(k) - exact[ray][k]));
            }
            for (int k = 0; k < carried_quantities; ++k)
                if (solved && sum[k] > rounding) measurements[k].push_back({double(steps), sum[k]});
        }
    }
    return measurements;
}

/// Fits two orders to the errors of each quantity: one to the three smallest step sizes, one to all step sizes. The
/// greater one must not be below the order of the method by more than 0.6, or 1.5 for methods of order 8 and above. For
/// methods of order below 9, the least order of the quantities must not exceed that of the method by more than 1.6.
template <class System, class H>
void expect_order() {
    int tested_kinds = 0;  // one bit per StepperKind
    for_all_steppers<System>([&]<class Stepper>(const Method& method) {
        tested_kinds |= 1 << int(method.kind);
        const auto measurements = errors<Stepper, System, H>(method);
        const double order = method.info.order;
        double least_order = std::numeric_limits<double>::infinity();
        for (int quantity = System::rescaled ? 0 : 1; quantity < carried_quantities; ++quantity) {
            const std::vector<Measurement>& points = measurements[quantity];
            std::string description = "quantity " + std::to_string(quantity) + ", steps: log10(error)";
            for (const Measurement& p : points)
                description += ", " + std::to_string(int(p.steps)) + ": " + std::to_string(std::log10(p.error));
            SCOPED_TRACE(description);
            // The errors of explicit methods of high order reach the rounding level of their coefficients after a few
            // step sizes, so that too few points remain for a fit.
            if (order >= 8 && !method.info.symmetric && points.size() < 3) continue;
            ASSERT_GE(points.size(), 3u);
            const Measurement* last = points.data() + points.size();
            const double fitted = std::max(fitted_order(last - 3, last), fitted_order(points.data(), last));
            EXPECT_GE(fitted, order - (order >= 8 ? 1.5 : 0.6));
            least_order = std::min(least_order, fitted);
        }
        if (std::isfinite(least_order) && order < 9) {
            EXPECT_LE(least_order, order + 1.6) << "The order is higher than the table states.";
        }
    });
    const int always_supporting =  // kinds of steppers that support every system with carried quantities
        1 << int(StepperKind::composition) | 1 << int(StepperKind::runge_kutta) |
                        1 << int(StepperKind::gauss) | 1 << int(StepperKind::gauss_4_stages);
    EXPECT_EQ(tested_kinds, always_supporting | (Nystroem::refusal<System>() ? 0 : 1 << int(StepperKind::nystroem)));
}

TEST(CarriedQuantities, PositionDependentRatesConvergeWithTheOrderOfTheMethod) {
    static_assert(!Nystroem::refusal<FisheyeWithPaths<Quad>>());
    expect_order<FisheyeWithPaths<Quad>, Fisheye>();
}
TEST(CarriedQuantities, MomentumDependentRatesConvergeWithTheOrderOfTheMethod) {
    expect_order<FisheyeWithProducts<Quad>, Fisheye>();
}
TEST(CarriedQuantities, ConvergeWithTheOrderOfTheMethodUnderTimeRescaling) {
    expect_order<SchwarzschildWithProducts<Quad>, Schwarzschild>();
}

/// Expects that state and λ after two steps are the same in `System` and in `Plain`, bit for bit. `Plain` is the same
/// system with λ as its only carried quantity. Without time rescaling λ must be equal to τ.
template <class System, class Plain, class H>
void expect_same_state_and_parameter() {
    const auto parameters = default_parameters<H>();
    const System system(parameters.data());
    const Plain plain(parameters.data());
    const State<double> start = state_of<double>(bent_ray<H>());
    const double h = path_length<H> / 16;
    for_all_steppers<System>([&]<class Stepper>(const Method& method) {
        const auto with_others = integrate<Stepper, carried_quantities>(system, method.coefficients, start, h, 2);
        const auto without_others = integrate<Stepper, 1>(plain, method.coefficients, start, h, 2);
        EXPECT_TRUE(with_others.solved && without_others.solved);
        for (int k = 0; k < phase_size; ++k) EXPECT_EQ(with_others.end.y[k], without_others.end.y[k]) << k;
        EXPECT_EQ(with_others.end.parameter, without_others.end.parameter);
        if constexpr (!System::rescaled) {
            EXPECT_EQ(with_others.end.parameter, h + h);
        }
    });
}
TEST(CarriedQuantities, DoNotChangeStateOrParameter) {
    expect_same_state_and_parameter<FisheyeWithProducts<double>, System<Fisheye, false, double>, Fisheye>();
    expect_same_state_and_parameter<SchwarzschildWithProducts<double>, System<Schwarzschild, true, double>,
                                Schwarzschild>();
}

// Compares the carried quantities of one ray bit for bit between scalar steps, a lane of a packet, and steps whose
// stages are computed in the lanes.
TEST(CarriedQuantities, AreEqualInScalarsPacketsAndStagesInLanes) {
    const auto parameters = default_parameters<Schwarzschild>();
    const SchwarzschildWithProducts<double> system(parameters.data());
    const RayStart ray = bent_ray<Schwarzschild>();
    const double h = path_length<Schwarzschild> / 16;
    for_all_steppers<SchwarzschildWithProducts<double>>([&]<class Stepper>(const Method& method) {
        const auto start = state_of<double>(ray);
        const auto packet_start = state_of<PacketDouble>(ray);
        const auto scalar = integrate<Stepper, carried_quantities>(system, method.coefficients, start, h, 2);
        const auto packet =
            integrate<Stepper, carried_quantities>(system, method.coefficients, packet_start, PacketDouble(h), 2);
        EXPECT_TRUE(scalar.solved);
        for (int k = 0; k < carried_quantities; ++k)
            EXPECT_EQ(scalar.end.carried(k), get_lane(packet.end.carried(k), 1)) << k;
        if constexpr (Stepper::family == MethodFamily::gauss) {
            const auto in_lanes =
                integrate<StagesInLanes<0>, carried_quantities>(system, method.coefficients, start, h, 2);
            for (int k = 0; k < carried_quantities; ++k) EXPECT_EQ(scalar.end.carried(k), in_lanes.end.carried(k)) << k;
        }
    });
}

// Steps in a called system are compared with the same steps in the system itself, whose functions are inlined.
TEST(CarriedQuantities, AreEqualInCalledAndInlineSystems) {
    using HoleWithProducts = WithProducts<Schwarzschild, false, double>;
    static_assert(HoleWithProducts::called);
    const auto parameters = default_parameters<Schwarzschild>();
    const HoleWithProducts system(parameters.data());
    const State<double> start = state_of<double>(bent_ray<Schwarzschild>());
    const double h = path_length<Schwarzschild> / 16;
    const auto compare = [&]<class Stepper>(const Coefficients& coefficients) {
        const auto inlined = integrate<Stepper, carried_quantities>(system, coefficients, start, h, 2);
        const auto called =
            integrate<Stepper, carried_quantities>(as_called<double>(system), coefficients, start, h, 2);
        for (int k = 0; k < carried_quantities; ++k) EXPECT_EQ(inlined.end.carried(k), called.end.carried(k)) << k;
    };
    compare.operator()<Composition>({.fractions = fractions::verlet});
    compare.operator()<RungeKutta>({.table = &kutta4});
    compare.operator()<Gauss<0>>({.gauss = &gauss_tableau<2>});
}

TEST(CarriedQuantities, KeepTheirValuesWhenNotRequested) {
    const auto parameters = default_parameters<Schwarzschild>();
    const SchwarzschildWithProducts<double> system(parameters.data());
    for_all_steppers<SchwarzschildWithProducts<double>>([&]<class Stepper>(const Method& method) {
        const auto start = state_of<double>(bent_ray<Schwarzschild>());
        auto state = integrate<Stepper, carried_quantities>(system, method.coefficients, start, 0.125, 1);
        state.options.compute_carried = false;
        state.start.carried(1) = 3;
        state.start.carried(2) = -5;
        Stepper::step(system, state, method.coefficients);
        EXPECT_EQ(state.end.carried(1), 3);
        EXPECT_EQ(state.end.carried(2), -5);
    });
}

// The steppers Orbit, ExactSplit and Recipe support no carried quantity besides λ. Nyström methods do not compute the
// momentum at their nodes, so that they support only rates that depend on position alone.
TEST(CarriedQuantities, AreRefusedByMethodsThatCannotIntegrateThem) {
    using Hole = System<Schwarzschild, false, double>;
    using HoleWithProducts = WithProducts<Schwarzschild, false, double>;
    EXPECT_EQ(Orbit::refusal<Hole>(), nullptr);
    EXPECT_EQ(ExactSplit::refusal<Hole>(), nullptr);
    EXPECT_EQ(Recipe::refusal<Hole>(), nullptr);
    for (const char* reason : {Orbit::refusal<HoleWithProducts>(), ExactSplit::refusal<HoleWithProducts>(),
                               Recipe::refusal<HoleWithProducts>()}) {
        ASSERT_NE(reason, nullptr);
        EXPECT_NE(std::string(reason).find("carried quantities"), std::string::npos) << reason;
    }
    EXPECT_EQ((Nystroem::refusal<System<Fisheye, false, double>>()), nullptr);
    EXPECT_NE(Nystroem::refusal<FisheyeWithProducts<double>>(), nullptr);
}

}  // namespace
}  // namespace kagero::test
