/// H of Satoh (2003), equation (16), term by term as printed. It is the independent reference of the factored form in
/// kernels/hamiltonians/schwarzschild.h.
#pragma once

#include "kernels/hamiltonians/schwarzschild.h"

namespace kagero::bench {

struct PrintedSchwarzschild : hamiltonians::Schwarzschild {
    template <class V>
    static constexpr V energy(const Parameters<V>& k, const Vec3<V>& q, const Vec3<V>& p, const V& pt) {
        const V r = norm(q), r2 = r * r, r3 = r2 * r;
        return -0.5 * (1 + k.rg / r) * pt * pt +
               0.5 * ((1 - k.rg * q.x * q.x / r3) * p.x * p.x + (1 - k.rg * q.y * q.y / r3) * p.y * p.y +
                      (1 - k.rg * q.z * q.z / r3) * p.z * p.z) -
               k.rg * pt / r2 * dot(q, p) -
               k.rg / r3 * (q.x * q.y * p.x * p.y + q.x * q.z * p.x * p.z + q.y * q.z * p.y * p.z);
    }
};

}  // namespace kagero::bench
