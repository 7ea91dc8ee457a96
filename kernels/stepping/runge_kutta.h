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

template <const auto& table>
struct RungeKutta {
    static constexpr int s = static_cast<int>(sizeof(table.b) / sizeof(double));

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
        f.end_parameter = mul_add(f.h, pace, f.start_parameter);
        f.gradients += V(S(s));
        f.solved = V(S(0)) <= V(S(0));
    }

private:
    template <int I, class System, class V>
    KAGERO_INLINE static void stage(const System& system, const Flow<V>& f, V (&g)[s][6], V& pace) {
        using S = ScalarOf<V>;
        State<V> y;
        for (int k = 0; k < 6; ++k) y.y[k] = moved<I>(f, g, table.a[I], k);
        y.y[6] = f.start.y[6];
        system.derivatives(y, g[I]);
        if (f.want_parameter) pace = mul_add(V(S(table.b[I])), system.pace(y), pace);
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
