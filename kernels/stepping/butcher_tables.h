/// Coefficients of explicit Runge–Kutta methods: data only, each with its source.
#pragma once

namespace kagero {

inline constexpr int max_rk_stages = 13;

/// Butcher's table; a is strictly lower triangular. With step control `error` is b − b̂ and `estimate_order` the order of b̂; else 0.
struct ButcherTable {
    int stages;
    double a[max_rk_stages][max_rk_stages];
    double b[max_rk_stages];
    double error[max_rk_stages] = {};
    int estimate_order = 0;
};

/// Kutta (1901).
inline constexpr ButcherTable kutta4{
    4,
    {{}, {1. / 2}, {0, 1. / 2}, {0, 0, 1}},
    {1. / 6, 1. / 3, 1. / 3, 1. / 6},
};

/// Dormand & Prince (1980), the fifth-order formula of RK5(4)7M.
inline constexpr ButcherTable dormand_prince5{
    6,
    {{},
     {1. / 5},
     {3. / 40, 9. / 40},
     {44. / 45, -56. / 15, 32. / 9},
     {19372. / 6561, -25360. / 2187, 64448. / 6561, -212. / 729},
     {9017. / 3168, -355. / 33, 46732. / 5247, 49. / 176, -5103. / 18656}},
    {35. / 384, 0, 500. / 1113, 125. / 192, -2187. / 6784, 11. / 84},
};

/// The same with its embedded fourth-order formula, which needs the derivative at the end.
inline constexpr ButcherTable dormand_prince54 = [] {
    ButcherTable t = dormand_prince5;
    t.stages = 7;
    for (int j = 0; j < 6; ++j) t.a[6][j] = t.b[j];
    constexpr double error[7] = {71. / 57600, 0, -71. / 16695, 71. / 1920, -17253. / 339200, 22. / 525, -1. / 40};
    for (int j = 0; j < 7; ++j) t.error[j] = error[j];
    t.estimate_order = 4;
    return t;
}();

/// Fehlberg (1968), RK7(8)13 of NASA TR R-287, table X, continued with the eighth-order formula.
inline constexpr ButcherTable fehlberg78{
    13,
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

}  // namespace kagero
