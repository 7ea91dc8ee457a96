/// Laurent polynomials in atoms: sums of products of integer powers, which may be negative. They are used to find terms
/// of a formula that cancel.
#pragma once

#include <cstdint>
#include <map>

namespace kagero {

/// The powers of atoms, which are numbered; no power is 0.
using Monomial = std::map<std::int32_t, int>;
/// The coefficients of monomials; no coefficient is 0.
using Polynomial = std::map<Monomial, double>;

/// Adds factor · b to a. A sum that is zero except for rounding is removed.
void add_to(Polynomial& a, const Polynomial& b, double factor = 1);

/// Returns the product of two monomials.
Monomial product(Monomial a, const Monomial& b);

/// Returns the product of two polynomials.
Polynomial product(const Polynomial& a, const Polynomial& b);

/// Returns the power of an atom in a monomial; 0 if it is absent.
int power_of(const Monomial& monomial, std::int32_t atom);

/// Returns the atom to the given power as a monomial.
Monomial atom_to(std::int32_t atom, int power);

/// Replaces the square of an atom by `square`, as often as possible, in all monomials.
Polynomial with_square(const Polynomial& p, std::int32_t atom, const Polynomial& square);

/// Returns the greatest common factor of all monomials: for each atom the power nearest to 0, if all powers have the
/// same sign.
Monomial common_factor(const Polynomial& p);

}  // namespace kagero
