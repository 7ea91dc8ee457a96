// Measures the orders of all methods. The errors of position, momentum, H and λ must decrease with the power of the
// step size that the table of methods states. The reference is a collocation method of high order in quadruple
// precision.
#include "tests/kernels/steps.h"

#include <algorithm>
#include <optional>

namespace kagero::test {
namespace {

template <class H>
class Orders : public ::testing::Test {};
TYPED_TEST_SUITE(Orders, AllHamiltonians, HamiltonianName);

/// State, H and λ at the end of a path.
struct PathEnd {
    Quad y[6], energy, parameter;
};
enum Quantity { position, momentum, energy, parameter, quantities };
constexpr const char* quantity_names[] = {"position", "momentum", "H", "parameter"};
/// One error for each Quantity.
using Errors = std::array<double, quantities>;

/// Length of the path, in radians, for methods whose steps are angles in the orbit plane.
constexpr double path_angle = 1.2;

/// Integrates a ray over a path of the given length. Returns no value if the equations of a step were not solved,
/// because the step was too long.
template <class H, class V>
std::optional<PathEnd> integrate(const Method& method, bool rescaled, const RayStart& ray, int steps,
                          Quad length = path_length<H>) {
    auto stepper = SpaceStepper<V>::template for_space<H>(method, rescaled);
    stepper.begin(state_of<V>(ray), V(V(length) / V(steps)));
    for (int i = 0; i < steps; ++i) {
        stepper.advance(1);
        if (!stepper.state.solved) return {};
    }
    PathEnd end;
    for (int k = 0; k < 6; ++k) end.y[k] = stepper.state.end.y[k];
    end.energy = stepper.state.energy;
    end.parameter = stepper.state.end.parameter;
    return end;
}

/// Returns the difference of each quantity, relative to 1 + |value|. Differences and values of vectors are those of the
/// greatest component.
Errors difference(const PathEnd& a, const PathEnd& b) {
    const auto relative = [](const Quad* x, const Quad* y, int n) {
        Quad size = 0, error = 0;
        for (int k = 0; k < n; ++k)
            if (x[k] != x[k] || y[k] != y[k]) return std::numeric_limits<double>::infinity();
        for (int k = 0; k < n; ++k) {
            size = max(size, abs(y[k]));
            error = max(error, abs(x[k] - y[k]));
        }
        return static_cast<double>(error / (1 + size));
    };
    return {relative(a.y, b.y, 3), relative(a.y + 3, b.y + 3, 3), relative(&a.energy, &b.energy, 1),
            relative(&a.parameter, &b.parameter, 1)};
}

/// The end of a path in quadruple precision, computed by two methods of high order with many steps.
struct Reference {
    PathEnd by_gauss16, by_gauss12;
    Errors uncertainty = difference(by_gauss16, by_gauss12);
    /// Returns the reference that was computed by another method than m.
    const PathEnd& for_method(const Method& m) const {
        return std::string(m.info.name) == "gauss16" ? by_gauss12 : by_gauss16;
    }
};
template <class H>
const Reference& reference(bool rescaled, int ray) {
    static std::optional<Reference> computed[2][bent_ray_count];
    auto& r = computed[rescaled][ray];
    if (!r) r = Reference{*integrate<H, Quad>(method_named("gauss16"), rescaled, bent_ray<H>(ray), 32),
                          *integrate<H, Quad>(method_named("gauss12"), rescaled, bent_ray<H>(ray), 96)};
    return *r;
}

/// Returns the uncertainty of the reference, summed over the rays.
template <class H>
Errors uncertainty(bool rescaled) {
    Errors sum{};
    for (int ray = 0; ray < bent_ray_count; ++ray)
        for (int i = 0; i < quantities; ++i) sum[i] += reference<H>(rescaled, ray).uncertainty[i];
    return sum;
}

/// An error, and the number of steps with which it was measured.
struct Measurement {
    int steps;
    double error;
};
/// Returns the order that the errors imply: the slope of −log(error) over log(steps), by least squares.
double fitted_order(const std::vector<Measurement>& points) {
    double sx = 0, sy = 0, sxx = 0, sxy = 0;
    const double n = static_cast<double>(points.size());
    for (const Measurement& p : points) {
        const double x = std::log(p.steps), y = -std::log(p.error);
        sx += x;
        sy += y;
        sxx += x * x;
        sxy += x * y;
    }
    return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

/// Returns the errors with the given number of steps, summed over the bent rays, because the error of one ray may
/// happen to be zero. Returns no value if the equations of a step were not solved.
template <class H, class V>
std::optional<Errors> errors(const Method& method, bool rescaled, int steps) {
    Errors sum{};
    for (int ray = 0; ray < bent_ray_count; ++ray) {
        const bool angular = method.info.angular;
        const RayStart start = bent_ray<H>(ray, angular);
        const auto end = integrate<H, V>(method, rescaled, start, steps, angular ? path_angle : path_length<H>);
        if (!end) return {};
        // Methods whose steps are angles require H = H0. Their reference is a path that ends at the same λ.
        const Errors e =
            difference(*end, angular ? *integrate<H, Quad>(method_named("gauss16"), rescaled, start, 32, end->parameter)
                                     : reference<H>(rescaled, ray).for_method(method));
        for (int i = 0; i < quantities; ++i) sum[i] += e[i];
    }
    return sum;
}

/// Returns a bound on rounding errors. Rounding errors of the coefficients are the same in every step; the coefficients
/// of Blanes & Moan are published to 15 digits. Rounding errors of the stages are random, so that they grow with the
/// square root of the number of stages.
template <class V>
double rounding_floor(const Method& method, int steps) {
    const double random_walk = std::sqrt(steps * stages_of(method));
    return std::max(10 * coefficient_epsilon<V>(method), 30 * random_walk * static_cast<double>(machine_epsilon<V>));
}

/// Returns true if the method is exact to rounding for a quantity. All methods are exact on straight rays. With
/// constant force, the momentum is always exact, and methods of order 2 and above are exact in all quantities. In
/// linear motion, collocation preserves H, which is a quadratic invariant (Hairer, Lubich & Wanner 2006, §IV.2).
bool is_exact(const Method& method, int order, Motion motion, int quantity) {
    switch (motion) {
        case Motion::straight: return true;
        case Motion::uniform: return order > 1 || quantity == momentum;
        case Motion::linear: return collocates(method) && quantity == energy;
        default: return false;
    }
}

/// Returns the greatest number of steps per path from which the order is fitted. With such short steps, the error terms
/// of higher order are small.
int most_steps(int order) { return order <= 2 ? 512 : order <= 5 ? 256 : order <= 6 ? 96 : order <= 8 ? 48 : 24; }

/// Returns the errors that exceed the rounding errors and 100 times the uncertainty of the reference, in order of
/// increasing number of steps.
template <class H, class V>
std::array<std::vector<Measurement>, quantities> measure(const Method& method, bool rescaled) {
    std::array<std::vector<Measurement>, quantities> points;
    const Errors reference_error = uncertainty<H>(rescaled);
    const int greatest_number = most_steps(order_in<H>(method));
    for (int coarse = 4; coarse <= greatest_number; coarse *= 2) {
        for (const int steps : {coarse, coarse + coarse / 2}) {
            const auto e = errors<H, V>(method, rescaled, steps);
            if (!e) continue;
            for (int i = 0; i < quantities; ++i) {
                const double floor = std::max(rounding_floor<V>(method, steps), 100 * reference_error[i]);
                if ((*e)[i] > floor) points[i].push_back({steps, (*e)[i]});
            }
        }
    }
    return points;
}

/// Fits two orders to the errors of each quantity: one to the smallest step sizes and one to all step sizes, because
/// error terms of opposite sign can change the slope. The greater one must not be below the stated order by more than
/// `tolerance_below`. The least order of the quantities must not exceed the stated order by more than
/// `tolerance_above`. Symmetric methods have even orders, so that a tolerance of 1 suffices. Explicit methods of high
/// order have small leading error coefficients, so that the next order contributes to the fit.
template <class H, class V>
void expect_stated_order(const Method& method, bool rescaled) {
    const bool symmetric = symmetric_in<H>(method);
    const std::size_t fitted_points = symmetric || std::is_same_v<V, Quad> ? 3 : 5;
    // The errors of explicit methods of order 8 reach the uncertainty of the reference after three or four step sizes,
    // so that their fit is less accurate.
    const bool few_points = !symmetric && order_in<H>(method) >= 8;
    const double tolerance_below = few_points  ? 1.5
                                   : symmetric ? (order_in<H>(method) >= 12 ? 1.5 : 1)
                                               : 0.5;
    const double tolerance_above = symmetric ? 1 : 1.25;
    static const Motion motion = motion_in<H>();
    const int order = order_in<H>(method);
    const auto points = measure<H, V>(method, rescaled);
    double least_order = order;
    bool fitted_any = false;
    for (int i = 0; i < quantities; ++i) {
        if (i == parameter && !rescaled) continue;  // λ is the integration parameter itself
        std::string description = std::string(quantity_names[i]) + ", steps: log10(error)";
        for (const Measurement& p : points[i])
            description += ", " + std::to_string(p.steps) + ": " + std::to_string(std::log10(p.error));
        SCOPED_TRACE(description);
        if (is_exact(method, order, motion, i)) {
            for (const Measurement& p : points[i])
                EXPECT_LE(p.error, 30 * coefficient_epsilon<V>(method) * p.steps * stages_of(method))
                    << "The method must be exact to rounding here.";
            continue;
        }
        // In a Luneburg lens rays are harmonic, and the path is shorter than a quarter of a period. The errors of
        // methods of high order are below rounding after a few step sizes.
        const bool nearly_exact = motion == Motion::linear && order >= 6;
        if ((few_points || nearly_exact) && points[i].size() < fitted_points) continue;
        ASSERT_GE(points[i].size(), fitted_points);
        const double at_small_steps = fitted_order({points[i].end() - fitted_points, points[i].end()});
        const double overall = fitted_order(points[i]);
        EXPECT_GE(std::max(at_small_steps, overall), order - tolerance_below);
        least_order = fitted_any ? std::min({least_order, at_small_steps, overall}) : std::min(at_small_steps, overall);
        fitted_any = true;
    }
    EXPECT_LE(least_order, order + tolerance_above) << "The order is higher than the table states.";
}

/// Returns true if the errors of a method in double reach the rounding level after two or three step sizes.
bool needs_quad(const Method& method) {
    return method.info.order >= 8 || (method.info.angular && method.info.order >= 6);
}

TYPED_TEST(Orders, MatchTheTableInQuadruplePrecision) {
    for_all_methods<TypeParam>([](const Method& method, bool rescaled) {
        if (needs_quad(method)) expect_stated_order<TypeParam, Quad>(method, rescaled);
    });
}

TYPED_TEST(Orders, MatchTheTableInDouble) {
    for_all_methods<TypeParam>([](const Method& method, bool rescaled) {
        if (!needs_quad(method)) expect_stated_order<TypeParam, double>(method, rescaled);
    });
}

// In float too few step sizes have errors above the rounding level for a fit. Instead, steps in float must agree with
// the same steps in double to the rounding of float.
TYPED_TEST(Orders, StepsInFloatMatchStepsInDouble) {
    for_all_methods<TypeParam>([](const Method& method, bool rescaled) {
        if (method.info.order > 4) return;
        for (int ray = 0; ray < bent_ray_count; ++ray) {
            constexpr int steps = 16;
            const double length = method.info.angular ? path_angle : path_length<TypeParam>;
            const RayStart start = bent_ray<TypeParam>(ray);
            const auto in_float = integrate<TypeParam, float>(method, rescaled, start, steps, length);
            const auto in_double = integrate<TypeParam, double>(method, rescaled, start, steps, length);
            ASSERT_TRUE(in_float && in_double);
            const Errors e = difference(*in_float, *in_double);
            for (int i = 0; i < quantities; ++i)
                EXPECT_LE(e[i], rounding_floor<float>(method, steps)) << quantity_names[i];
        }
    });
}

}  // namespace
}  // namespace kagero::test
