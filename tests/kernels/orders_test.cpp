// The error of every method falls with the power of the step that its table states, for position, momentum, H and
// parameter alike.
#include "tests/kernels/steps.h"

#include <algorithm>
#include <optional>

namespace kagero::test {
namespace {

template <class H>
class Orders : public ::testing::Test {};
TYPED_TEST_SUITE(Orders, AllHamiltonians, HamiltonianName);

/// Where a ray is at the end of the path, to the precision of its number type.
struct End {
    Quad y[6], energy, parameter;
};
enum Quantity { position, momentum, energy, parameter, quantities };
constexpr const char* quantity_names[] = {"position", "momentum", "H", "parameter"};
using Errors = std::array<double, quantities>;

/// How far methods that step in angles go, radians.
constexpr double path_angle = 1.2;

/// Nothing where a step had no solution: it was too long.
template <class H, class V>
std::optional<End> follow(const Method& method, bool rescaled, const RayStart& ray, int steps,
                          Quad length = path_length<H>) {
    auto run = Steps<V>::template in<H>(method, rescaled);
    run.begin(state_of<V>(ray), V(V(length) / V(steps)));
    for (int i = 0; i < steps; ++i) {
        run.advance(1);
        if (!run.flow.solved) return {};
    }
    End end;
    for (int k = 0; k < 6; ++k) end.y[k] = run.flow.end.y[k];
    end.energy = run.flow.energy, end.parameter = run.flow.end.parameter;
    return end;
}

/// Relative to 1 + |value|; of vectors, the greatest component.
Errors difference(const End& a, const End& b) {
    const auto relative = [](const Quad* x, const Quad* y, int n) {
        Quad size = 0, error = 0;
        for (int k = 0; k < n; ++k)
            if (x[k] != x[k] || y[k] != y[k]) return std::numeric_limits<double>::infinity();
        for (int k = 0; k < n; ++k) size = max(size, abs(y[k])), error = max(error, abs(x[k] - y[k]));
        return static_cast<double>(error / (1 + size));
    };
    return {relative(a.y, b.y, 3), relative(a.y + 3, b.y + 3, 3), relative(&a.energy, &b.energy, 1),
            relative(&a.parameter, &b.parameter, 1)};
}

/// The end of the path in quadruple precision by each of two other methods of high order, with many steps.
struct Reference {
    End by_gauss16, by_gauss12;
    Errors uncertainty = difference(by_gauss16, by_gauss12);
    /// For a method that is not the one measured.
    const End& for_method(const Method& m) const {
        return std::string(m.info.name) == "gauss16" ? by_gauss12 : by_gauss16;
    }
};
template <class H>
const Reference& reference(bool rescaled, int ray) {
    static std::optional<Reference> known[2][bent_rays];
    auto& r = known[rescaled][ray];
    if (!r) r = Reference{*follow<H, Quad>(method_named("gauss16"), rescaled, bent_ray<H>(ray), 32),
                          *follow<H, Quad>(method_named("gauss12"), rescaled, bent_ray<H>(ray), 96)};
    return *r;
}

/// Of the errors summed over rays.
template <class H>
Errors uncertainty(bool rescaled) {
    Errors sum{};
    for (int ray = 0; ray < bent_rays; ++ray)
        for (int i = 0; i < quantities; ++i) sum[i] += reference<H>(rescaled, ray).uncertainty[i];
    return sum;
}

struct Point {
    int steps;
    double error;
};
/// Least-squares slope of −log error over log steps.
double slope(const std::vector<Point>& points) {
    double sx = 0, sy = 0, sxx = 0, sxy = 0;
    const double n = static_cast<double>(points.size());
    for (const Point& p : points) {
        const double x = std::log(p.steps), y = -std::log(p.error);
        sx += x, sy += y, sxx += x * x, sxy += x * y;
    }
    return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

/// Errors summed over rays, so that an accidental zero of one ray's error does not bend the line; nothing where a step
/// is too long.
template <class H, class V>
std::optional<Errors> errors(const Method& method, bool rescaled, int steps) {
    Errors sum{};
    for (int ray = 0; ray < bent_rays; ++ray) {
        const bool angular = method.info.angular;
        const RayStart start = bent_ray<H>(ray, angular);
        const auto end = follow<H, V>(method, rescaled, start, steps, angular ? path_angle : path_length<H>);
        if (!end) return {};
        // Who steps in angles, on H = H0 alone, is compared with another method where the parameter is the same.
        const Errors e =
            difference(*end, angular ? *follow<H, Quad>(method_named("gauss16"), rescaled, start, 32, end->parameter)
                                     : reference<H>(rescaled, ray).for_method(method));
        for (int i = 0; i < quantities; ++i) sum[i] += e[i];
    }
    return sum;
}

/// Errors that may be rounding: those of the coefficients, of which Blanes & Moan's are published to 15 digits, do the
/// same in every step; others come and go in every stage.
template <class V>
double rounding_floor(const Method& method, int steps) {
    const double walk = std::sqrt(steps * stages_of(method));
    return std::max(10 * coefficient_epsilon<V>(method), 30 * walk * static_cast<double>(machine_epsilon<V>));
}

/// Whether the method has no error but rounding in a quantity: all on straight rays; from order 2 on parabolas, whose
/// momentum changes evenly; and the quadratic H of a linear motion by collocation, which keeps quadratic invariants
/// (Hairer, Lubich & Wanner 2006, §IV.2).
bool is_exact(const Method& method, int order, Motion motion, int quantity) {
    switch (motion) {
        case Motion::straight: return true;
        case Motion::uniform: return order > 1 || quantity == momentum;
        case Motion::linear: return collocates(method) && quantity == energy;
        default: return false;
    }
}

/// Steps per path at the fine end of the fit, where the next power of the step is small.
int finest_steps(int order) { return order <= 2 ? 512 : order <= 5 ? 256 : order <= 6 ? 96 : order <= 8 ? 48 : 24; }

/// The errors above rounding and above the reference's own error, from coarse to fine.
template <class H, class V>
std::array<std::vector<Point>, quantities> measure(const Method& method, bool rescaled) {
    std::array<std::vector<Point>, quantities> points;
    const Errors unsure = uncertainty<H>(rescaled);
    const int finest = finest_steps(order_on<H>(method));
    for (int coarse = 4; coarse <= finest; coarse *= 2) {
        for (const int steps : {coarse, coarse + coarse / 2}) {
            const auto e = errors<H, V>(method, rescaled, steps);
            if (!e) continue;
            for (int i = 0; i < quantities; ++i) {
                const double floor = std::max(rounding_floor<V>(method, steps), 100 * unsure[i]);
                if ((*e)[i] > floor) points[i].push_back({steps, (*e)[i]});
            }
        }
    }
    return points;
}

/// Fits the finest steps and the whole range, since two powers of opposite sign bend the line: one of them must show
/// the order, in each quantity, and some quantity no higher order. Symmetric methods have even order, so that to within
/// one settles it; explicit formulas of high order are chosen for a small leading error, so that the next power of the
/// step is seen as well.
template <class H, class V>
void expect_stated_order(const Method& method, bool rescaled) {
    const bool symmetric = symmetric_on<H>(method);
    const std::size_t fitted = symmetric || std::is_same_v<V, Quad> ? 3 : 5;
    // Explicit formulas of order 8 reach the reference's own error after three or four step sizes: their fit is rough.
    const bool short_range = !symmetric && order_on<H>(method) >= 8;
    const double below = short_range ? 1.5
                         : symmetric ? (order_on<H>(method) >= 12 ? 1.5 : 1)
                                     : 0.5,
                 above = symmetric ? 1 : 1.25;
    static const Motion motion = motion_in<H>();
    const int order = order_on<H>(method);
    const auto points = measure<H, V>(method, rescaled);
    double least = order;
    bool any = false;
    for (int i = 0; i < quantities; ++i) {
        if (i == parameter && !rescaled) continue;  // it is the integration parameter itself
        std::string shown = quantity_names[i];
        for (const Point& p : points[i])
            shown += ", " + std::to_string(p.steps) + ": " + std::to_string(std::log10(p.error));
        SCOPED_TRACE(shown);  // log10 of the errors
        if (is_exact(method, order, motion, i)) {
            for (const Point& p : points[i])
                EXPECT_LE(p.error, 30 * coefficient_epsilon<V>(method) * p.steps * stages_of(method)) << "not exact";
            continue;
        }
        // In a Luneburg lens rays are harmonic for less than a quarter of a turn: the highest orders make no error to
        // fit.
        const bool too_exact = motion == Motion::linear && order >= 6;
        if ((short_range || too_exact) && points[i].size() < fitted) continue;
        ASSERT_GE(points[i].size(), fitted);
        const double at_the_end = slope({points[i].end() - fitted, points[i].end()}), overall = slope(points[i]);
        EXPECT_GE(std::max(at_the_end, overall), order - below);
        least = any ? std::min({least, at_the_end, overall}) : std::min(at_the_end, overall), any = true;
    }
    EXPECT_LE(least, order + above) << "of higher order after all?";
}

/// Methods that reach double's rounding after two or three step sizes.
bool needs_quad(const Method& method) {
    return method.info.order >= 8 || (method.info.angular && method.info.order >= 6);
}

TYPED_TEST(Orders, InQuadruplePrecision) {
    for_all_methods<TypeParam>([](const Method& method, bool rescaled) {
        if (needs_quad(method)) expect_stated_order<TypeParam, Quad>(method, rescaled);
    });
}

TYPED_TEST(Orders, InDouble) {
    for_all_methods<TypeParam>([](const Method& method, bool rescaled) {
        if (!needs_quad(method)) expect_stated_order<TypeParam, double>(method, rescaled);
    });
}

// Float leaves too few steps between those too coarse and rounding to fit a line; it must take double's steps to its
// own rounding.
TYPED_TEST(Orders, InFloatAreThoseOfDouble) {
    for_all_methods<TypeParam>([](const Method& method, bool rescaled) {
        if (method.info.order > 4) return;
        for (int ray = 0; ray < bent_rays; ++ray) {
            constexpr int steps = 16;
            const double length = method.info.angular ? path_angle : path_length<TypeParam>;
            const auto in_float = follow<TypeParam, float>(method, rescaled, bent_ray<TypeParam>(ray), steps, length);
            const auto in_double = follow<TypeParam, double>(method, rescaled, bent_ray<TypeParam>(ray), steps, length);
            ASSERT_TRUE(in_float && in_double);
            const Errors e = difference(*in_float, *in_double);
            for (int i = 0; i < quantities; ++i)
                EXPECT_LE(e[i], rounding_floor<float>(method, steps)) << quantity_names[i];
        }
    });
}

}  // namespace
}  // namespace kagero::test
