/// Methods for the six derivatives of H, equation (16) of Satoh (2003), and of K = r·H. The reverse tape is the method
/// of kagero; the others are compared with it.
#pragma once

#include "bench/kernels/sparse_dual.h"
#include "kernels/hamiltonians/schwarzschild.h"
#include "kernels/autodiff/dual.h"
#include "kernels/equations/system.h"

namespace kagero::bench {

using hamiltonians::Schwarzschild;

/// Hand-written derivatives with common subexpressions, fused multiply-adds and a single 1/√. With r = |q|,
/// p_r = p·q/r and u = p_r + p_t:
///
///     H:  a = r_g u/r²,  ∂H/∂p = p − a q,          ∂H/∂q = (a/r)(3u/2 − p_t) q − a p
///     K:  a = r_g u/r,   ∂K/∂p = r p − a q,        ∂K/∂q = (1/r)(T + a q·p/r) q − a p,     T = (|p|² − p_t²)/2
template <class V, bool Rescaled>
struct HandWritten {
    static constexpr const char* name = "hand";
    ScalarOf<V> rg;
    explicit HandWritten(const double* parameters) : rg(ScalarOf<V>(parameters[0])) {}
    explicit HandWritten(ScalarOf<V> radius) : rg(radius) {}

    /// Sets `out` to ∂/∂q and ∂/∂p of H, or of K if `Rescaled`.
    KAGERO_INLINE void derivatives(const State<V>& s, V* out) const {
        const SharedTerms c(*this, s);
        const V along_q = c.along_q(s), r = c.r2 * c.ir;
        for (int k = 0; k < 3; ++k) {
            out[k] = fms(along_q, s.y[k], c.a * s.y[3 + k]);
            if constexpr (Rescaled) out[3 + k] = fms(r, s.y[3 + k], c.a * s.y[k]);
            else out[3 + k] = fnma(c.a, s.y[k], s.y[3 + k]);
        }
    }
    /// Returns ∂K/∂q.
    KAGERO_INLINE Vec3<V> gradient_q(const State<V>& s) const requires Rescaled {
        const SharedTerms c(*this, s);
        const V along_q = c.along_q(s);
        const auto at = [&](int k) __attribute__((always_inline)) { return fms(along_q, s.y[k], c.a * s.y[3 + k]); };
        return {at(0), at(1), at(2)};
    }
    /// Returns ∂K/∂p.
    KAGERO_INLINE Vec3<V> gradient_p(const State<V>& s) const requires Rescaled {
        const SharedTerms c(*this, s);
        const V r = c.r2 * c.ir;
        const auto at = [&](int k) __attribute__((always_inline)) { return fms(r, s.y[3 + k], c.a * s.y[k]); };
        return {at(0), at(1), at(2)};
    }

private:
    /// Terms that occur in both ∂/∂q and ∂/∂p: r², 1/r, p_r, u and a.
    struct SharedTerms {
        V r2, ir, pr, u, a;
        KAGERO_INLINE SharedTerms(const HandWritten& hand, const State<V>& s) {
            const Vec3<V> q = s.q();
            r2 = fused_dot(q, q);
            ir = rsqrt(r2);
            pr = fused_dot(q, s.p()) * ir;
            u = pr + s.y[6];
            a = Rescaled ? V(hand.rg) * u * ir : V(hand.rg) * u * (ir * ir);
        }
        /// Returns the coefficient of q in ∂/∂q.
        KAGERO_INLINE V along_q(const State<V>& s) const {
            using S = ScalarOf<V>;
            const V pt = s.y[6];
            if (!Rescaled) return a * ir * fms(V(S(1.5)), u, pt);
            const Vec3<V> p = s.p();
            const V twice_t = fma(p.x, p.x, fma(p.y, p.y, fms(p.z, p.z, pt * pt)));
            return ir * fma(V(S(0.5)), twice_t, a * pr);
        }
    };
    KAGERO_INLINE static V fused_dot(const Vec3<V>& a, const Vec3<V>& b) {
        return fma(a.x, b.x, fma(a.y, b.y, a.z * b.z));
    }
};

/// Forward differentiation with dual numbers that contain all six derivatives.
template <class V, bool Rescaled>
struct DenseForward {
    static constexpr const char* name = "dense_forward";
    using D = Dual<V, 6>;
    double rg;
    explicit DenseForward(const double* parameters) : rg(parameters[0]) {}

    /// Without `flatten`, the compiler does not inline the operations of Dual on packets.
    __attribute__((flatten)) void derivatives(const State<V>& s, V* out) const {
        const auto variable = [&](int k) { return D::variable(s.y[k], k); };
        const Vec3<D> q{variable(0), variable(1), variable(2)}, p{variable(3), variable(4), variable(5)};
        const Schwarzschild::Parameters<D> k{D(rg)};
        D pt;
        pt.value = s.y[6];
        D h = Schwarzschild::energy(k, q, p, pt);
        if constexpr (Rescaled) h = Schwarzschild::rescale(k, q) * h;
        for (int i = 0; i < 6; ++i) out[i] = h.derivative[static_cast<std::size_t>(i)];
    }
};

/// Forward differentiation of H in the form H = (|p|² − p_t²)/2 − r_g u²/(2r), with dual numbers that contain only
/// derivatives that can differ from zero; with fused multiply-adds and a single 1/√.
template <class V, bool Rescaled>
struct SparseForward {
    static constexpr const char* name = "sparse_forward";
    ScalarOf<V> rg;
    explicit SparseForward(const double* parameters) : rg(ScalarOf<V>(parameters[0])) {}

    KAGERO_INLINE void derivatives(const State<V>& s, V* out) const {
        using S = ScalarOf<V>;
        const auto x = variable<0>(s.y[0]);
        const auto y = variable<1>(s.y[1]);
        const auto z = variable<2>(s.y[2]);
        const auto px = variable<3>(s.y[3]);
        const auto py = variable<4>(s.y[4]);
        const auto pz = variable<5>(s.y[5]);
        const SparseDual<V, 0> pt{s.y[6], {}}, half{V(S(0.5)), {}}, radius{V(rg), {}};
        const auto r2 = x * x + y * y + z * z;
        const auto ir = rsqrt(r2);
        const auto u = pt + (x * px + y * py + z * pz) * ir;
        const auto t = half * (px * px + py * py + pz * pz - pt * pt);
        const auto h = [&] {
            if constexpr (Rescaled) return (r2 * ir) * t - half * radius * (u * u);
            else return t - half * (radius * ir) * (u * u);
        }();
        for (int i = 0; i < variable_count; ++i) out[i] = h.derivative[i];
    }
};

/// The method of kagero: straight-line code that is extracted from the reverse sweep of a tape.
template <class V, bool Rescaled>
struct ReverseTape {
    static constexpr const char* name = "reverse_tape";
    System<Schwarzschild, Rescaled, ScalarOf<V>> system;
    explicit ReverseTape(const double* parameters) : system(parameters) {}
    KAGERO_INLINE void derivatives(const State<V>& s, V* out) const { system.derivatives(s, out); }
};

}  // namespace kagero::bench
