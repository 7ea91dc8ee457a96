/// Explicit Runge–Kutta methods with fixed step: not symplectic, for comparison and where a ray passes only once.
#pragma once

#include "kernels/stepping/implicit.h"

namespace kagero {

/// Butcher's table; a is strictly lower triangular, zeros cost nothing.
template <int s>
struct ButcherTable {
    double a[s][s];
    double b[s];
};

/// Kutta (1901).
inline constexpr ButcherTable<4> classical_rk4{
    {{}, {1. / 2}, {0, 1. / 2}, {0, 0, 1}},
    {1. / 6, 1. / 3, 1. / 3, 1. / 6},
};
/// Dormand & Prince (1980), the fifth-order formula of RK5(4)7M.
inline constexpr ButcherTable<6> dormand_prince5{
    {{},
     {1. / 5},
     {3. / 40, 9. / 40},
     {44. / 45, -56. / 15, 32. / 9},
     {19372. / 6561, -25360. / 2187, 64448. / 6561, -212. / 729},
     {9017. / 3168, -355. / 33, 46732. / 5247, 49. / 176, -5103. / 18656}},
    {35. / 384, 0, 500. / 1113, 125. / 192, -2187. / 6784, 11. / 84},
};

/// Dormand & Prince (1980), RK5(4)7M: the fifth-order formula with its embedded fourth-order one. `error` is b − b̂.
template <int s>
struct EmbeddedTable {
    double a[s][s];
    double b[s];
    double error[s];
    int estimate_order;  ///< of the embedded formula
};
inline constexpr EmbeddedTable<7> dormand_prince54{
    {{},
     {1. / 5},
     {3. / 40, 9. / 40},
     {44. / 45, -56. / 15, 32. / 9},
     {19372. / 6561, -25360. / 2187, 64448. / 6561, -212. / 729},
     {9017. / 3168, -355. / 33, 46732. / 5247, 49. / 176, -5103. / 18656},
     {35. / 384, 0, 500. / 1113, 125. / 192, -2187. / 6784, 11. / 84}},
    {35. / 384, 0, 500. / 1113, 125. / 192, -2187. / 6784, 11. / 84, 0},
    {71. / 57600, 0, -71. / 16695, 71. / 1920, -17253. / 339200, 22. / 525, -1. / 40},
    4,
};
/// Fehlberg (1968), RK8(7)13 (NASA TR R-287, table X), continued with the eighth-order formula.
inline constexpr EmbeddedTable<13> fehlberg78{
    {{},
     {2. / 27},
     {1. / 36, 1. / 12},
     {1. / 24, 0, 1. / 8},
     {5. / 12, 0, -25. / 16, 25. / 16},
     {1. / 20, 0, 0, 1. / 4, 1. / 5},
     {-25. / 108, 0, 0, 125. / 108, -65. / 27, 125. / 54},
     {31. / 300, 0, 0, 0, 61. / 225, -2. / 9, 13. / 900},
     {2, 0, 0, -53. / 6, 704. / 45, -107. / 9, 67. / 90, 3},
     {-91. / 108, 0, 0, 23. / 108, -976. / 135, 311. / 54, -19. / 60, 17. / 6, -1. / 12},
     {2383. / 4100, 0, 0, -341. / 164, 4496. / 1025, -301. / 82, 2133. / 4100, 45. / 82, 45. / 164, 18. / 41},
     {3. / 205, 0, 0, 0, 0, -6. / 41, -3. / 205, -3. / 41, 3. / 41, 6. / 41, 0},
     {-1777. / 4100, 0, 0, -341. / 164, 4496. / 1025, -289. / 82, 2193. / 4100, 51. / 82, 33. / 164, 12. / 41, 0, 1}},
    {0, 0, 0, 0, 0, 34. / 105, 9. / 35, 9. / 35, 9. / 280, 9. / 280, 0, 41. / 840, 41. / 840},
    {-41. / 840, 0, 0, 0, 0, 0, 0, 0, 0, 0, -41. / 840, 41. / 840, 41. / 840},
    7,
};

template <const auto& table>
struct RungeKutta {
    static constexpr int s = static_cast<int>(sizeof(table.b) / sizeof(double));
    static constexpr bool adaptive = requires { table.error; };

    template <class System>
    static constexpr const char* refusal() { return nullptr; }
    template <class System, class V>
    static void begin(const System&, Flow<V>&) {}

    template <class System, class V>
    static void step(const System& system, Flow<V>& f) {
        using S = ScalarOf<V>;
        V g[s][6];
        V pace(S(0));
        [&]<int... I>(std::integer_sequence<int, I...>) {
            (stage<I>(system, f, g, pace), ...);
        }(std::make_integer_sequence<int, s>{});
        for (int k = 0; k < 6; ++k) f.end.y[k] = moved<s>(f, g, table.b, k);
        f.end_parameter = System::rescaled ? mul_add(f.h, pace, f.start_parameter) : f.start_parameter + f.h;
        f.gradients += V(S(s));
        f.solved = V(S(0)) <= V(S(0));
        if constexpr (adaptive) control(f, g);
    }

private:
    /// Elementary step control (Hairer, Nørsett & Wanner 1993, §II.4), each lane for itself: a step whose estimated local error exceeds
    /// the tolerance, relative to 1 + |value|, is rejected, and the next length aims at it with a safety factor.
    template <class V>
    KAGERO_INLINE static void control(Flow<V>& f, const V (&g)[s][6]) requires adaptive {
        using S = ScalarOf<V>;
        V error(S(0));
        for (int k = 0; k < 6; ++k) {
            const int d = k < 3 ? k + 3 : k - 3;
            V sum(S(0));
            for (int j = 0; j < s; ++j)
                if (table.error[j] != 0) sum = mul_add(V(S(table.error[j])), g[j][d], sum);
            error = max(error, abs(f.h * sum) / (V(S(1)) + abs(f.end.y[k])));
        }
        const V relative = max(error * V(S(1) / f.tolerance), V(S(1e-6)));
        const V factor = exp(log(relative) * V(S(-1.0 / (table.estimate_order + 1))));
        f.accepted = relative <= V(S(1));
        f.suggested = f.h * max(min(V(S(0.9)) * factor, V(S(4))), V(S(0.2)));
    }

    template <int I, class System, class V>
    KAGERO_INLINE static void stage(const System& system, const Flow<V>& f, V (&g)[s][6], V& pace) {
        using S = ScalarOf<V>;
        State<V> y;
        for (int k = 0; k < 6; ++k) y.y[k] = moved<I>(f, g, table.a[I], k);
        y.y[6] = f.start.y[6];
        system.derivatives(y, g[I]);
        if (System::rescaled && f.want_parameter) pace = mul_add(V(S(table.b[I])), system.pace(y), pace);
    }
    template <int used, class V>
    KAGERO_INLINE static V moved(const Flow<V>& f, const V (&g)[s][6], const double (&weight)[s], int k) {
        using S = ScalarOf<V>;
        const int d = k < 3 ? k + 3 : k - 3;
        V sum(S(0));
        for (int j = 0; j < used; ++j)
            if (weight[j] != 0) sum = mul_add(V(S(weight[j])), g[j][d], sum);
        return k < 3 ? mul_add(f.h, sum, f.start.y[k]) : neg_mul_add(f.h, sum, f.start.y[k]);
    }
};

}  // namespace kagero
