#include "formula/polynomial.h"

#include <cmath>

namespace kagero {

void add_to(Polynomial& a, const Polynomial& b, double factor) {
    constexpr double rounding = 1e-13;
    for (const auto& [monomial, coefficient] : b) {
        const auto [term, is_new] = a.try_emplace(monomial, factor * coefficient);
        if (is_new) continue;
        const double before = term->second, sum = before + factor * coefficient;
        if (std::abs(sum) <= rounding * std::abs(before)) a.erase(term);
        else term->second = sum;
    }
}

Monomial product(Monomial a, const Monomial& b) {
    for (const auto& [atom, power] : b)
        if ((a[atom] += power) == 0) a.erase(atom);
    return a;
}

Polynomial product(const Polynomial& a, const Polynomial& b) {
    Polynomial result;
    for (const auto& [monomial, coefficient] : a)
        for (const auto& [other, factor] : b) add_to(result, {{product(monomial, other), coefficient * factor}});
    return result;
}

int power_of(const Monomial& monomial, std::int32_t atom) {
    const auto found = monomial.find(atom);
    return found == monomial.end() ? 0 : found->second;
}

Monomial atom_to(std::int32_t atom, int power) {
    return power == 0 ? Monomial{} : Monomial{{atom, power}};
}

Polynomial with_square(const Polynomial& p, std::int32_t atom, const Polynomial& square) {
    Polynomial result;
    for (const auto& [monomial, coefficient] : p) {
        const int power = power_of(monomial, atom), squares = power > 0 ? power / 2 : 0;
        Polynomial term{{product(monomial, atom_to(atom, -2 * squares)), coefficient}};
        for (int i = 0; i < squares; ++i) term = product(term, square);
        add_to(result, term);
    }
    return result;
}

Monomial common_factor(const Polynomial& p) {
    if (p.empty()) return {};
    Monomial common = p.begin()->first;
    for (const auto& [monomial, coefficient] : p)
        for (auto it = common.begin(); it != common.end();) {
            const int power = power_of(monomial, it->first);
            if (power * it->second <= 0) {
                it = common.erase(it);
                continue;
            }
            if (std::abs(power) < std::abs(it->second)) it->second = power;
            ++it;
        }
    return common;
}

}  // namespace kagero
