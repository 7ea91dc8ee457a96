// Compares derivatives that are recorded by the tape with the complex-step derivative f'(x) = Im f(x + iε)/ε. The
// complex-step derivative contains no subtraction, so that it is exact to rounding. Second derivatives by nested dual
// numbers are compared with complex-step derivatives of first derivatives.

#include "tests/kernels/spaces.h"

#include "kernels/trace/packets.h"

#include <algorithm>
#include <complex>

namespace kagero::test {

/// A complex number that is ordered by its real part.
struct Complex {
    std::complex<double> z;
    Complex(double x = 0) : z(x) {}
    Complex(std::complex<double> w) : z(w) {}
    friend Complex operator-(Complex a) { return -a.z; }
    friend Complex operator+(Complex a, Complex b) { return a.z + b.z; }
    friend Complex operator-(Complex a, Complex b) { return a.z - b.z; }
    friend Complex operator*(Complex a, Complex b) { return a.z * b.z; }
    friend Complex operator/(Complex a, Complex b) { return a.z / b.z; }
    friend bool operator<(Complex a, Complex b) { return a.z.real() < b.z.real(); }
    friend bool operator>(Complex a, Complex b) { return b < a; }
    friend bool operator>=(Complex a, Complex b) { return a.z.real() >= b.z.real(); }
    friend Complex sqrt(Complex a) { return std::sqrt(a.z); }
    friend Complex exp(Complex a) { return std::exp(a.z); }
    friend Complex log(Complex a) { return std::log(a.z); }
    friend Complex sin(Complex a) { return std::sin(a.z); }
    friend Complex cos(Complex a) { return std::cos(a.z); }
    friend Complex tan(Complex a) { return std::tan(a.z); }
    friend Complex tanh(Complex a) { return std::tanh(a.z); }
    /// Returns the arc tangent to first order in the imaginary parts. A complex step of 1e-100 needs no higher orders.
    friend Complex atan2(Complex a, Complex b) {
        return std::complex<double>(std::atan2(a.z.real(), b.z.real()),
                                    (b.z.real() * a.z.imag() - a.z.real() * b.z.imag()) /
                                        std::norm(std::complex(a.z.real(), b.z.real())));
    }
    friend Complex select(bool m, Complex a, Complex b) { return m ? a : b; }
    friend Complex min(Complex a, Complex b) { return a < b ? a : b; }
    friend Complex max(Complex a, Complex b) { return a > b ? a : b; }
};

namespace {

constexpr double complex_step = 1e-100;

template <class H>
class Gradients : public ::testing::Test {};
TYPED_TEST_SUITE(Gradients, AllHamiltonians, HamiltonianName);

/// One number for each component of position and momentum, and for p_t: a state, or a row of derivatives.
using Vector7 = std::array<double, 7>;

/// Returns H − H0 or, if `rescaled` is set, Ω·(H − H0), in any number type.
template <class H, class T>
T integrated_hamiltonian(const std::array<T, 7>& y, bool rescaled) {
    const auto values = default_parameters<H>();
    std::array<T, H::parameters.size() + 1> k;
    for (std::size_t i = 0; i < k.size(); ++i) k[i] = T(values[i]);
    const auto parameters = make_parameters<H>(k.data());
    const Vec3<T> q{y[0], y[1], y[2]}, p{y[3], y[4], y[5]};
    const T residual = H::energy(parameters, q, p, y[6]) - T(H::level);
    if constexpr (Rescalable<H>) return rescaled ? H::rescale(parameters, q) * residual : residual;
    else return residual;
}

template <class H>
Vector7 gradient_by_complex_step(const Vector7& y, bool rescaled) {
    Vector7 g;
    for (int k = 0; k < 7; ++k) {
        std::array<Complex, 7> z;
        for (int i = 0; i < 7; ++i) z[i] = std::complex<double>(y[i], i == k ? complex_step : 0);
        g[k] = integrated_hamiltonian<H>(z, rescaled).z.imag() / complex_step;
    }
    return g;
}

/// Returns the gradient by dual numbers over T. If T itself carries derivatives, the result carries second derivatives.
template <class H, class T>
std::array<T, 7> gradient_by_duals(const std::array<T, 7>& y, bool rescaled) {
    std::array<Dual<T, 7>, 7> x;
    for (int i = 0; i < 7; ++i) x[i] = Dual<T, 7>::variable(y[i], i);
    return integrated_hamiltonian<H>(x, rescaled).derivative;
}
template <class H>
std::array<Vector7, 7> hessian_by_duals(const Vector7& y, bool rescaled) {
    std::array<Dual<double, 7>, 7> x;
    for (int i = 0; i < 7; ++i) x[i] = Dual<double, 7>::variable(y[i], i);
    const auto g = gradient_by_duals<H>(x, rescaled);
    std::array<Vector7, 7> hessian;
    for (int i = 0; i < 7; ++i) hessian[i] = g[i].derivative;
    return hessian;
}
template <class H>
std::array<Vector7, 7> hessian_by_complex_step(const Vector7& y, bool rescaled) {
    std::array<Vector7, 7> hessian;
    for (int k = 0; k < 7; ++k) {
        std::array<Complex, 7> z;
        for (int i = 0; i < 7; ++i) z[i] = std::complex<double>(y[i], i == k ? complex_step : 0);
        const auto g = gradient_by_duals<H>(z, rescaled);
        for (int i = 0; i < 7; ++i) hessian[i][k] = g[i].z.imag() / complex_step;
    }
    return hessian;
}

/// Returns the change of each derivative, divided by ε, if the derivative and all variables have relative errors of ε.
Vector7 rounding_scale(const Vector7& y, const Vector7& gradient, const std::array<Vector7, 7>& hessian) {
    Vector7 scale;
    for (int i = 0; i < 7; ++i) {
        scale[i] = std::abs(gradient[i]);
        for (int k = 0; k < 7; ++k) scale[i] += std::abs(hessian[i][k] * y[k]);
    }
    return scale;
}
/// Number of rounding errors in a result. Programs have about fifty operations, whose errors partly cancel.
constexpr double roundings = 32;

/// Returns random states in the domain with H ≠ H0, exactly representable in float.
template <class H>
std::vector<Vector7> states(std::size_t n) {
    Random random(3);
    std::vector<Vector7> points;
    for (const RayStart& ray : random_rays<H>(n, 2)) {
        Vector7 y;
        for (int k = 0; k < 3; ++k) {
            y[k] = static_cast<float>(ray.q[k]);
            y[3 + k] = static_cast<float>(ray.p[k] * random(0.5, 2));
        }
        y[6] = static_cast<float>(ray.pt * random(0.5, 2));
        points.push_back(y);
    }
    return points;
}

template <class V>
std::array<double, 6> lane_of(const V (&values)[6], int lane) {
    std::array<double, 6> result;
    for (std::size_t k = 0; k < 6; ++k) result[k] = static_cast<double>(get_lane(values[k], lane));
    return result;
}
void expect_near(const std::array<double, 6>& found, const Vector7& expected, double epsilon, const Vector7& scale) {
    for (std::size_t k = 0; k < 6; ++k)
        EXPECT_NEAR(found[k], expected[k], roundings * epsilon * scale[k]) << "component " << k;
}

/// Checks the program that computes force and velocity together, and the separate programs of force and velocity.
template <class H, bool rescaled, class V>
void check_programs() {
    using S = ScalarOf<V>;
    const System<H, rescaled, S> system(default_parameters<H>().data());
    for (const Vector7& y : states<H>(40)) {
        const Vector7 expected = gradient_by_complex_step<H>(y, rescaled);
        const Vector7 scale = rounding_scale(y, expected, hessian_by_duals<H>(y, rescaled));
        State<V> s;
        for (int k = 0; k < 7; ++k) s.y[k] = V(S(y[k]));
        V together[6];
        system.derivatives(s, together);
        const Vec3<V> dq = system.gradient_q(s), dp = system.gradient_p(s);
        const V separate[6] = {dq.x, dq.y, dq.z, dp.x, dp.y, dp.z};
        for (const int lane : {0, lane_count<V> - 1})
            for (const auto& found : {lane_of(together, lane), lane_of(separate, lane)})
                expect_near(found, expected, static_cast<double>(machine_epsilon<S>), scale);
    }
}
template <class H, class V>
void check_all_programs() {
    check_programs<H, false, V>();
    if constexpr (Rescalable<H>) check_programs<H, true, V>();
}

TYPED_TEST(Gradients, MatchTheComplexStepInPacketsOfDouble) { check_all_programs<TypeParam, PacketDouble>(); }
TYPED_TEST(Gradients, MatchTheComplexStepInPacketsOfFloat) { check_all_programs<TypeParam, PacketFloat>(); }
TYPED_TEST(Gradients, MatchTheComplexStepInDouble) { check_all_programs<TypeParam, double>(); }
TYPED_TEST(Gradients, MatchTheComplexStepInFloat) { check_all_programs<TypeParam, float>(); }

TYPED_TEST(Gradients, SecondDerivativesByDualNumbersMatchTheComplexStep) {
    using H = TypeParam;
    for (const bool rescaled : rescalings<H>()) {
        for (const Vector7& y : states<H>(40)) {
            const auto by_duals = hessian_by_duals<H>(y, rescaled);
            const auto by_complex_step = hessian_by_complex_step<H>(y, rescaled);
            double size = 0;
            for (const Vector7& row : by_complex_step)
                for (const double x : row) size = std::max(size, std::abs(x));
            for (int i = 0; i < 7; ++i) {
                for (int k = 0; k < 7; ++k) {
                    EXPECT_NEAR(by_duals[i][k], by_complex_step[i][k], roundings * machine_epsilon<double> * size)
                        << i << ' ' << k;
                    EXPECT_NEAR(by_duals[i][k], by_duals[k][i], roundings * machine_epsilon<double> * size)
                        << i << ' ' << k;
                }
            }
        }
    }
}

// ∇(Ω (H − H0)) = Ω ∇H + (H − H0) ∇Ω, and dλ/dτ = Ω.
TYPED_TEST(Gradients, RescaledHamiltonianObeysTheProductRule) {
    using H = TypeParam;
    if constexpr (!Rescalable<H>) {
        GTEST_SKIP() << H::name << " has no time rescaling.";
    } else {
        const auto k = default_parameters<H>();
        const System<H, false, double> plain(k.data());
        const System<H, true, double> rescaled(k.data());
        for (const Vector7& y : states<H>(40)) {
            State<double> s;
            std::copy(y.begin(), y.end(), s.y);
            std::array<Dual<double, 3>, H::parameters.size() + 1> parameters;
            for (std::size_t i = 0; i < k.size(); ++i) parameters[i] = k[i];
            const auto at = [&](int i) { return Dual<double, 3>::variable(y[i], i); };
            const auto omega =
                H::rescale(make_parameters<H>(parameters.data()), Vec3<Dual<double, 3>>{at(0), at(1), at(2)});
            double gradient_h[6], gradient_k[6];
            plain.derivatives(s, gradient_h);
            rescaled.derivatives(s, gradient_k);
            const double residual = plain.unscaled_energy_residual(s);
            EXPECT_NEAR(rescaled.time_rescaling_factor(s), omega.value,
                        roundings * machine_epsilon<double> * omega.value);
            const Vector7 scale = rounding_scale(y, gradient_by_complex_step<H>(y, true), hessian_by_duals<H>(y, true));
            for (int i = 0; i < 6; ++i) {
                const double expected = omega.value * gradient_h[i] + (i < 3 ? residual * omega.derivative[i] : 0);
                EXPECT_NEAR(gradient_k[i], expected, 2 * roundings * machine_epsilon<double> * scale[i])
                    << "component " << i;
            }
        }
    }
}

// The event functions contain H − H0 and |p·∂H/∂p| + |H0|, from which energy errors are computed.
TYPED_TEST(Gradients, EnergyResidualAndEnergyScaleMatchTheComplexStep) {
    using H = TypeParam;
    const System<H, false, double> system(default_parameters<H>().data());
    for (const Vector7& y : states<H>(40)) {
        State<double> s;
        std::copy(y.begin(), y.end(), s.y);
        const EventFunctions<double> found = system.event_functions(s);
        const Vector7 g = gradient_by_complex_step<H>(y, false),
                    scale = rounding_scale(y, g, hessian_by_duals<H>(y, false));
        double size = 0, p_dot_velocity = 0;
        for (int k = 0; k < 7; ++k) size += std::abs(y[k]) * scale[k];
        for (int k = 3; k < 6; ++k) p_dot_velocity += y[k] * g[k];
        EXPECT_NEAR(found.energy_residual, integrated_hamiltonian<H>(y, false),
                    roundings * machine_epsilon<double> * size);
        EXPECT_NEAR(found.energy_scale, std::abs(p_dot_velocity) + std::abs(H::level),
                    roundings * machine_epsilon<double> * size);
    }
}

}  // namespace
}  // namespace kagero::test
