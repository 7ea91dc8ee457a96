#include "spaces/formula_form.h"

#include "error.h"
#include "formula/nodes.h"
#include "scene/value.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace kagero {
namespace {

constexpr std::size_t dimensions = 4;  // of the covector (p_x, p_y, p_z, p_t)
using Covector = std::array<double, dimensions>;
using SymmetricMatrix = std::array<Covector, dimensions>;

double value_at(const FormulaDescription& formula, const Double3& q, const Covector& p) {
    return evaluate(formula.scope, formula.parsed.energy, {q[0], q[1], q[2], p[0], p[1], p[2], p[3]});
}

/// Returns the matrix of the quadratic form H(p, p_t) at q.
SymmetricMatrix quadratic_form(const FormulaDescription& formula, const Double3& q) {
    SymmetricMatrix form{};
    const auto unit = [](std::size_t a) {
        Covector e{};
        e[a] = 1;
        return e;
    };
    for (std::size_t a = 0; a < dimensions; ++a) form[a][a] = 2 * value_at(formula, q, unit(a));
    for (std::size_t a = 0; a < dimensions; ++a)
        for (std::size_t b = 0; b < a; ++b) {
            Covector sum = unit(a);
            sum[b] = 1;
            form[a][b] = form[b][a] = value_at(formula, q, sum) - 0.5 * (form[a][a] + form[b][b]);
        }
    return form;
}

/// Returns true if H is the quadratic form ½ p·F p for two test momenta.
bool is_quadratic(const FormulaDescription& formula, const Double3& q, const SymmetricMatrix& form) {
    constexpr double rounding = 1e-10;
    for (const Covector& p : {Covector{0.6, -0.3, 0.7, 0.8}, Covector{-1.1, 0.4, 0.9, -1.7}}) {
        double value = 0, terms = 0;
        for (std::size_t a = 0; a < dimensions; ++a)
            for (std::size_t b = 0; b < dimensions; ++b) {
                value += 0.5 * p[a] * form[a][b] * p[b];
                terms += std::abs(p[a] * form[a][b] * p[b]);
            }
        if (!(std::abs(value_at(formula, q, p) - value) <= rounding * terms)) return false;
    }
    return true;
}

/// Numbers of positive and negative eigenvalues.
struct Signature {
    int positive = 0, negative = 0;
};

/// Returns the signature of a symmetric matrix, from its eigenvalues by Jacobi's method.
Signature signature_of(SymmetricMatrix m) {
    constexpr int sweeps = 12;
    for (int sweep = 0; sweep < sweeps; ++sweep)
        for (std::size_t i = 0; i < dimensions; ++i)
            for (std::size_t k = i + 1; k < dimensions; ++k) {
                const double angle = 0.5 * std::atan2(2 * m[i][k], m[k][k] - m[i][i]), c = std::cos(angle),
                             s = std::sin(angle);
                for (Covector& row : m) {
                    const double x = row[i], y = row[k];
                    row[i] = c * x - s * y;
                    row[k] = s * x + c * y;
                }
                for (std::size_t j = 0; j < dimensions; ++j) {
                    const double x = m[i][j], y = m[k][j];
                    m[i][j] = c * x - s * y;
                    m[k][j] = s * x + c * y;
                }
            }
    double greatest = 0;
    for (std::size_t i = 0; i < dimensions; ++i) greatest = std::max(greatest, std::abs(m[i][i]));
    constexpr double rounding = 1e-12;
    Signature signature;
    for (std::size_t i = 0; i < dimensions; ++i) {
        signature.positive += m[i][i] > rounding * greatest;
        signature.negative += m[i][i] < -rounding * greatest;
    }
    return signature;
}

}  // namespace

FormulaForm form_of(const FormulaDescription& formula, const Double3& q) {
    FormulaForm found;
    if (formula.parsed.level != 0) return found;
    const SymmetricMatrix form = quadratic_form(formula, q);
    if (!is_quadratic(formula, q, form)) return found;
    const Signature signature = signature_of(form);
    const bool contains_pt = std::any_of(form.begin(), form.end(), [](const Covector& row) { return row[3] != 0; });
    const bool is_lorentzian = signature.positive + signature.negative == 4 &&
                               (signature.positive == 1 || signature.negative == 1);
    found.is_spacetime = contains_pt && is_lorentzian;
    found.backward_pt_sign = signature.negative == 1 ? 1 : -1;
    found.has_time_coordinate = !contains_pt && signature.positive > 0 && signature.negative > 0;
    return found;
}

RayFrequency ray_frequency(const FormulaDescription& formula, const Double3& q, bool is_picture) {
    const double pt = formula.parsed.pt;
    const FormulaForm form = form_of(formula, q);
    if (!form.is_spacetime) return {pt, {}};
    if (pt == 0)
        throw InputError(formula.location, "pt is 0; a spacetime needs `[" + formula.table +
                                               ".constants] pt = 1`, the frequency of the light");
    if (pt * form.backward_pt_sign > 0) return {pt, {}};
    const std::string stated = formula.table + ".constants.pt = " + to_toml(pt),
                      signature = form.backward_pt_sign > 0 ? "-+++" : "+---";
    if (!is_picture)
        return {pt, stated + " is the momentum of light that is followed forward in time, because H has the " +
                        "signature " + signature + "; change the sign of pt to follow light backward, as pictures do"};
    return {-pt, "pictures follow light backward in time; H has the signature " + signature +
                     ", so pt = " + to_toml(-pt) + " is used instead of " + stated};
}

std::string cause_of_missing_momentum(const FormulaDescription& formula, const Double3& q) {
    if (!form_of(formula, q).has_time_coordinate) return {};
    return "H is indefinite in px, py, pz, as if one of the coordinates x, y, z was a time; rays are curves in space, "
           "so write the momentum of the time as pt, with [" +
           formula.table + ".constants] pt = 1";
}

}  // namespace kagero
