/// Coefficients of compositions and splittings. This file contains only data; each list names its source.
#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace kagero {

/// Fractions of the step, in the order in which a method applies two maps alternately: χ and χ* (composition.h), or the
/// flows of two parts of H (splitting.h). Weights are the fractions of the second-order step S2 in a composition of S2.
using Fractions = std::span<const double>;

namespace fractions {

/// Returns the palindrome of n entries with the given first half. The remaining middle entry makes the sum 1; if n is
/// even, the two middle entries are equal.
template <std::size_t n, std::size_t half>
constexpr std::array<double, n> palindrome(const std::array<double, half>& first_half) {
    static_assert(half == (n - 1) / 2);
    std::array<double, n> entries{};
    double remainder = 1;
    for (std::size_t i = 0; i < half; ++i) {
        entries[i] = entries[n - 1 - i] = first_half[i];
        remainder -= 2 * first_half[i];
    }
    for (std::size_t i = half; i < n - half; ++i) entries[i] = remainder / static_cast<double>(n - 2 * half);
    return entries;
}
/// Converts weights w of the self-adjoint S2 = χ*_{w/2} χ_{w/2} to fractions for χ and χ* alternately.
template <std::size_t n>
constexpr std::array<double, 2 * n> halve(const std::array<double, n>& weights) {
    std::array<double, 2 * n> result{};
    for (std::size_t i = 0; i < n; ++i) result[2 * i] = result[2 * i + 1] = weights[i] / 2;
    return result;
}
/// Converts weights w of the Strang step A_{w/2} B_w A_{w/2} to fractions for A and B alternately. Adjacent half steps
/// of A are merged.
template <std::size_t n>
constexpr std::array<double, 2 * n + 1> strang(const std::array<double, n>& weights) {
    std::array<double, 2 * n + 1> result{};
    for (std::size_t i = 0; i < n; ++i) {
        result[2 * i] += weights[i] / 2;
        result[2 * i + 1] = weights[i];
        result[2 * i + 2] = weights[i] / 2;
    }
    return result;
}
/// Interleaves two lists: a₁ b₁ a₂ b₂ … The longer list a provides the first and the last entry.
template <std::size_t n>
constexpr std::array<double, 2 * n + 1> interleave(const std::array<double, n + 1>& a, const std::array<double, n>& b) {
    std::array<double, 2 * n + 1> result{};
    for (std::size_t i = 0; i < n; ++i) {
        result[2 * i] = a[i];
        result[2 * i + 1] = b[i];
    }
    result[2 * n] = a[n];
    return result;
}
/// Converts a splitting a₁ b₁ a₂ … to fractions for χ and χ* alternately: α₁ = a₁, α₂ = b₁ − α₁, α₃ = a₂ − α₂ …
/// (McLachlan 1995).
template <std::size_t n>
constexpr std::array<double, 2 * n> from_splitting(const std::array<double, n + 1>& a, const std::array<double, n>& b) {
    std::array<double, 2 * n> result{};
    double previous = 0;
    for (std::size_t i = 0; i < n; ++i) {
        result[2 * i] = previous = a[i] - previous;
        result[2 * i + 1] = previous = b[i] - previous;
    }
    return result;
}

// ---- weights of S2 --------------------------------------------------------------------------------------------------
/// One weight: S2 itself. Order 2.
inline constexpr std::array<double, 1> single_step{1.0};
/// Three weights, Satoh (2003) eqs. (12), (13); Yoshida (1990). Order 4.
inline constexpr auto yoshida4_weights = palindrome<3>(std::array{1.351207191959657634});
/// Nine weights, Satoh (2003) eqs. (14), (15). Order 4.
inline constexpr auto nine_weights = palindrome<9>(std::array{1. / 6, 1. / 6, 1. / 6, 1. / 6});
/// Five weights, Suzuki (1990): 1/(4 − 4^{1/3}). Order 4.
inline constexpr auto suzuki4_weights = palindrome<5>(std::array{0.41449077179437573714, 0.41449077179437573714});
/// Nine weights, Kahan & Li (1997). Order 6.
inline constexpr auto kahan_li6_weights = palindrome<9>(
    std::array{.39216144400731413928, .33259913678935943860, -.70624617255763935981, .082213596293550800230});
/// Seventeen weights, Kahan & Li (1997). Order 8.
inline constexpr auto kahan_li8_weights = palindrome<17>(
    std::array{.13020248308889008088, .56116298177510838456, -.38947496264484728641, .15884190655515560090,
               -.39590389413323757734, .18453964097831570709, .25837438768632204729, .29501172360931029887});

// ---- splittings: Blanes & Moan (2002) -------------------------------------------------------------------------------
/// The splitting S6 with 6 stages. Order 4.
inline constexpr auto s6_a = palindrome<7>(std::array{.0792036964311957, .353172906049774, -.0420650803577195});
inline constexpr auto s6_b = palindrome<6>(std::array{.209515106613362, -.143851773179818});
/// The splitting S10 with 10 stages. Order 6.
inline constexpr auto s10_a = palindrome<11>(
    std::array{.0502627644003922, .413514300428344, .0450798897943977, -.188054853819569, .541960678450780});
inline constexpr auto s10_b =
    palindrome<10>(std::array{.148816447901042, -.132385865767784, .067307604692185, .432666402578175});
/// Nyström splitting of order 4; the first substep is a kick.
inline constexpr auto srkn6_b = palindrome<7>(std::array{.0829844064174052, .396309801498368, -.0390563049223486});
inline constexpr auto srkn6_a = palindrome<6>(std::array{.245298957184271, .604872665711080});
/// Nyström splitting of order 6; the first substep is a kick.
inline constexpr auto srkn11_b = palindrome<12>(
    std::array{.0414649985182624, .198128671918067, -.0400061921041533, .0752539843015807, -.0115113874206879});
inline constexpr auto srkn11_a = palindrome<11>(
    std::array{.123229775946271, .290553797799558, -.127049212625417, -.246331761062075, .357208872795928});
/// Nyström splitting of order 6; the first substep is a drift.
inline constexpr auto srkn14_a =
    palindrome<15>(std::array{.0378593198406116, .102635633102435, -.0258678882665587, .314241403071447,
                              -.130144459517415, .106417700369543, -.00879424312851058});
inline constexpr auto srkn14_b = palindrome<14>(std::array{.09171915262446165, .183983170005006, -.05653436583288827,
                                                           .004914688774712854, .143761127168358, .328567693746804});

// ---- fractions for χ and χ* alternately -----------------------------------------------------------------------------
inline constexpr auto verlet = halve(single_step);
inline constexpr auto yoshida4 = halve(yoshida4_weights);
inline constexpr auto suzuki4_nine = halve(nine_weights);
inline constexpr auto suzuki4 = halve(suzuki4_weights);
inline constexpr auto s6 = from_splitting(s6_a, s6_b);
inline constexpr auto s10 = from_splitting(s10_a, s10_b);
inline constexpr auto kahan_li6 = halve(kahan_li6_weights);
inline constexpr auto kahan_li8 = halve(kahan_li8_weights);

// ---- fractions for two exact flows alternately ----------------------------------------------------------------------
inline constexpr auto srkn6 = interleave(srkn6_b, srkn6_a);
inline constexpr auto srkn11 = interleave(srkn11_b, srkn11_a);
inline constexpr auto srkn14 = interleave(srkn14_a, srkn14_b);
inline constexpr auto split_verlet = strang(single_step);
inline constexpr auto split_yoshida4 = strang(yoshida4_weights);
inline constexpr auto split_suzuki4_nine = strang(nine_weights);
inline constexpr auto split_suzuki4 = strang(suzuki4_weights);
inline constexpr auto split_s6 = interleave(s6_a, s6_b);
inline constexpr auto split_s10 = interleave(s10_a, s10_b);
inline constexpr auto split_kahan_li6 = strang(kahan_li6_weights);
inline constexpr auto split_kahan_li8 = strang(kahan_li8_weights);

}  // namespace fractions
}  // namespace kagero
