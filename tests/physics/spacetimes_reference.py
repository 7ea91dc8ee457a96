#!/usr/bin/python3
"""Computes the expected ends of rays and redshifts in the metrics of docs/spacetimes, independent of kagero.

    spacetimes_reference.py

Writes spacetimes_reference.json in the folder of this script; spacetimes_from_literature_test.cpp reads it. The values
are closed forms and quadratures of the printed line elements, in extended precision. They use neither H nor Hamilton's
equations. Requires numpy and scipy.

Units: lengths of the scenes, angles in radians, p_t = 1. Rays run backward in time, so times are negative. In this
script b is the impact parameter L/E, and A, B, C are functions of the radial coordinate u of
ds^2 = -A dt^2 + B du^2 + C (dtheta^2 + sin^2(theta) dphi^2).
"""
import json
import pathlib

import numpy as np
from scipy.special import ellipj, ellipkinc

LD = np.longdouble
PI = 4 * np.arctan(LD(1))
NODES, WEIGHTS = (values.astype(LD) for values in np.polynomial.legendre.leggauss(40))
SKY = [-100, 60, 10]  # A point that a ray reaches far from the hole.
TOWARD = [0, 1, 0.3]  # Rays at the rim of a shadow are in the plane of the camera, the centre and this direction.
CHECKS = []


def plain(value):
    """Returns a value of numpy as numbers and lists of Python."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [plain(item) for item in value]
    return float(value) if isinstance(value, np.floating) else value


def add(scene, what, source, **fields):
    """Appends a check. Fields that are None are left out."""
    fields = {key: plain(value) for key, value in fields.items() if value is not None}
    CHECKS.append({"scene": scene, "what": what, "source": source} | fields)


def add_redshift(scene, what, source, value, settings=None, constants=None, status="escaped"):
    """Appends a check of the redshift at the centre of the picture."""
    add(scene, what, source, constants=constants, settings=settings or {"camera.look_at": SKY}, status=status,
        redshift=value, tolerance=1e-6)


def quad(f, a, b, panels=24):
    """Returns the integral of f from a to b by Gauss-Legendre rules with 40 nodes."""
    edges = [LD(a) + (LD(b) - LD(a)) * LD(k) / panels for k in range(panels + 1)]
    return sum((v - u) / 2 * np.sum(WEIGHTS * f((u + v) / 2 + (v - u) / 2 * NODES)) for u, v in zip(edges, edges[1:]))


def quad_from_root(f, root, end, breaks=()):
    """Returns the integral of f from root to end > root, where f is like 1/sqrt(u - root) near the root."""
    span = np.sqrt(LD(end) - root)
    edges = [LD(0)] + [span * LD(2)**-k for k in range(11)]
    edges = sorted(edges + [np.sqrt(c - root) for c in breaks if root < c < end])
    return sum(quad(lambda s: 2 * s * f(root + s * s), a, b, 4) for a, b in zip(edges, edges[1:]))


def bisect(f, a, b):
    """Returns the zero of f between a and b."""
    a, b = LD(a), LD(b)
    sign = f(a) > 0
    for _ in range(200):
        middle = (a + b) / 2
        if middle in (a, b):
            break
        if (f(middle) > 0) == sign:
            a = middle
        else:
            b = middle
    return (a + b) / 2


def first_zero(f, start, low):
    """Returns the first zero of f on the way from start, where f > 0, down to low; None if there is none."""
    grid = np.linspace(LD(start), LD(low), 40001)
    below = np.nonzero(f(grid[1:]) < 0)[0]
    return bisect(f, grid[below[0]], grid[below[0] + 1]) if len(below) else None


def vector(values):
    return np.asarray(values, LD)


def unit(values):
    v = vector(values)
    return v / np.sqrt(v @ v)


def frame(phi):
    """Returns the unit vectors along rho and phi."""
    return vector([np.cos(phi), np.sin(phi), 0]), vector([-np.sin(phi), np.cos(phi), 0])


class Spherical:
    """A spherical spacetime. u = u_of(R) and R = r_of(u) relate u to the radius R in the scene; slope is du/dR.

    Rays end at low. g(u) is the derivative of the difference between the time of the scene and the static time.
    """

    def __init__(self, A, B, C, u_of=lambda R: R, slope=lambda R: LD(1), r_of=lambda u: u, low=0, breaks=(), g=None):
        self.A, self.B, self.C, self.u_of, self.slope, self.r_of = A, B, C, u_of, slope, r_of
        self.low, self.breaks, self.g = low, breaks, g

    def plane(self, q, d):
        """Returns |q|, the unit vectors of the orbit plane along and across q, and the components of d."""
        q, d = vector(q), vector(d)
        e1 = unit(q)
        across = d - (d @ e1) * e1
        return np.sqrt(q @ q), e1, unit(across), d @ e1, np.sqrt(across @ across)

    def impact(self, q, d):
        R, _, _, radial, across = self.plane(q, d)
        u = self.u_of(R)
        du, dphi = self.slope(R) * radial, across / R
        return self.C(u) * dphi / np.sqrt(self.A(u) * (self.B(u) * du * du + self.C(u) * dphi * dphi))

    def radial_squared(self, u, b):
        return 1 / self.A(u) - b * b / self.C(u)

    def angle(self, b):
        """Returns dphi/du of the orbit."""
        return lambda u: b * np.sqrt(self.B(u)) / self.C(u) / np.sqrt(self.radial_squared(u, b))

    def time(self, b):
        """Returns dt/du of the orbit."""
        return lambda u: np.sqrt(self.B(u)) / self.A(u) / np.sqrt(self.radial_squared(u, b))

    def end(self, q, d, u_end):
        """Returns the end at u_end of a ray, behind a turning point if there is one."""
        R, e1, e2, _, _ = self.plane(q, d)
        b, u = self.impact(q, d), self.u_of(R)
        turning = first_zero(lambda v: self.radial_squared(v, b), u, self.low)
        if turning is None:  # The ray goes through a throat.
            edges = [c for c in self.breaks if u_end < c < u]
            edges = [u_end, *sorted(edges), u]
            swept, time = (sum(quad(f(b), x, y, 120) for x, y in zip(edges, edges[1:]))
                           for f in (self.angle, self.time))
        else:
            swept, time = (quad_from_root(f(b), turning, u, self.breaks) +
                           quad_from_root(f(b), turning, u_end, self.breaks) for f in (self.angle, self.time))
        if self.g:
            time -= quad(self.g, u, u_end, 200)
        R = self.r_of(u_end)
        er, ephi = np.cos(swept) * e1 + np.sin(swept) * e2, np.cos(swept) * e2 - np.sin(swept) * e1
        du = (-1 if turning is None else 1) * np.sqrt(self.radial_squared(u_end, b) / self.B(u_end))
        momentum = self.B(u_end) * du * self.slope(R) * er + b / R * ephi
        return {"end_position": R * er, "end_direction": unit(du / self.slope(R) * er + R * b / self.C(u_end) * ephi),
                "end_momentum": None if self.g else momentum, "time": -time}

    def direction(self, q, b):
        """Returns the direction of the ray from q, inward, with the impact parameter b."""
        R, e1, e2, _, _ = self.plane(q, TOWARD)
        u = self.u_of(R)
        du = -np.sqrt((self.C(u)**2 / (b * b * self.A(u)) - self.C(u)) / self.B(u))
        return unit(du / self.slope(R) * e1 + R * e2)

    def point_at(self, q, d, swept):
        """Returns u where the orbit has swept an angle, and its impact parameter."""
        b, u = self.impact(q, d), self.u_of(self.plane(q, d)[0])
        turning = first_zero(lambda v: self.radial_squared(v, b), u, self.low)
        half = quad_from_root(self.angle(b), turning, u)
        side = -1 if swept < half else 1
        end = u if side < 0 else 10 * u
        found = bisect(lambda v: half + side * quad_from_root(self.angle(b), turning, v) - swept,
                       turning * (1 + LD(1e-6)), end)
        return found, b


def hole(f, low, **more):
    """Returns the spacetime -f dt^2 + dr^2/f + r^2 dOmega^2."""
    return Spherical(f, lambda r: 1 / f(r), lambda r: r * r, low=low, **more)


def wormhole(A, B, C, c, **more):
    """Returns a wormhole whose radial coordinate is l = R - c/R."""
    def r_of(u):
        root = (abs(u) + np.sqrt(u * u + 4 * c)) / 2
        return root if u > 0 else c / root
    return Spherical(A, B, C, lambda R: R - c / R, lambda R: 1 + c / R**2, r_of, **more)


def rim(scene, space, q, b, source, throat=None, constants=None):
    """Checks that rays at b (1 +- 1e-6) pass outside, or fall into the hole or through the throat."""
    for factor, passes in ((1 + LD(1e-6), True), (1 - LD(1e-6), False)):
        add(scene, f"ray at b = {float(b * factor)!r}, critical b = {float(b)!r}", source, constants=constants,
            position=q, direction=space.direction(q, b * factor),
            status="escaped" if passes or throat else "captured", farther_than=throat if passes else None,
            nearer_than=None if passes else throat)


def rays(scene, space, q, directions, u_end, source="quadratures of the printed line element", constants=None):
    """Checks the ends of rays at u_end."""
    for d in directions:
        add(scene, f"ray with b = {float(space.impact(q, d))!r}", source, constants=constants, position=q, direction=d,
            status="escaped", **space.end(q, d, LD(u_end)), tolerance=1e-8)


def static_redshift(scene, space, q, u_sky=None, constants=None, settings=None):
    """Checks the redshift of the sky for a static camera: sky at infinity, or at rest at u_sky."""
    sky = 1 if u_sky is None else space.A(LD(u_sky))
    camera = space.A(space.u_of(np.sqrt(vector(q) @ vector(q))))
    add_redshift(scene, "redshift of the sky, static camera", "sqrt(g_tt of the sky/g_tt of the camera)",
                 np.sqrt(sky / camera), settings, constants)


def schwarzschild():
    """Three charts of Schwarzschild's hole."""
    f = lambda r: 1 - 2 / r
    critical = 3 * np.sqrt(LD(3))
    areal = hole(f, 2.02)
    isotropic = hole(f, 2.02, u_of=lambda R: R * (1 + 1 / (2 * R))**2, slope=lambda R: 1 - 1 / (4 * R * R),
                     r_of=lambda r: (r - 1 + np.sqrt(r * r - 2 * r)) / 2)
    river = hole(f, 2.02, g=lambda r: -np.sqrt(2 / r) / (1 - 2 / r))
    for scene, space, q, r_sky in (("schwarzschild", areal, [-15, 0, 0.5], None),
                                   ("schwarzschild-isotropic", isotropic, [-14, 0, 0.5], None),
                                   ("painleve-gullstrand", river, [-15, 0, 0.5], 100)):
        rim(scene, space, q, critical, "b = 3 sqrt(3) M (Hagihara 1931, Synge 1966)")
        near = space.direction(q, critical * LD(1.01))
        rays(scene, space, q, [[1, 0.42, 0.11], near], space.u_of(LD(100)),
             "quadratures in areal r; Darwin (1959) has the angle as elliptic integrals")
        static_redshift(scene, space, q, r_sky)
    # A camera with the velocity v dq/dt has the local speed beta in isotropic coordinates.
    R, v = LD(14), LD(1) / 4
    u, w = 1 + 1 / (2 * R), 1 - 1 / (2 * R)
    beta = v * u**3 / w
    for target, cosine in (([-14, 1, 0], 1), ([-14, -1, 0], -1), ([-15, 0, 0], 0), ([-14.6, 0.8, 0], LD(8) / 10)):
        add_redshift("schwarzschild-isotropic", "redshift of the sky for a moving camera",
                     "(u/w)/(gamma (1 - beta cos)) of special relativity, beta = v u^3/w",
                     u / w * np.sqrt(1 - beta**2) / (1 - beta * cosine),
                     {"camera.position": [-14, 0, 0], "camera.look_at": target, "camera.velocity": [0, v, 0]})
    # In the static time t, dr/dt = -v f. In the time T of the outward river, dT = dt (1 + v^2).
    v = np.sqrt(2 / LD(15))
    add_redshift("painleve-gullstrand", "redshift of the sky for a camera in free fall from rest at infinity",
                 "1/(1 + v) for a sky at infinity, times sqrt(-g_tt) of the sky at r = 100",
                 np.sqrt(f(LD(100))) / (1 + v),
                 {"camera.position": [-15, 0, 0], "camera.look_at": [-16, 0, 0],
                  "camera.velocity": [v * f(LD(15)) / (1 + v * v), 0, 0]})


def reissner_nordstrom():
    q, scene, charge = [-17, 0, 3.5], "reissner-nordstrom", LD(9) / 10
    f = lambda r: 1 - 2 / r + charge**2 / r**2
    space = hole(f, 1.05 * (1 + np.sqrt(1 - charge**2)))
    photon = (3 + np.sqrt(9 - 8 * charge**2)) / 2
    rim(scene, space, q, photon / np.sqrt(f(photon)),
        "b = r/sqrt(f) at r = (3M + sqrt(9M^2 - 8Q^2))/2 (Chandrasekhar 1983)")
    rays(scene, space, q, [[1, 0.35, -0.05]], 100)
    static_redshift(scene, space, q)
    for d in ([1, 0.4, -0.21], [1, -0.4, -0.21]):
        R, e1, e2, radial, across = space.plane(q, d)
        swept = np.arctan2(-e1[2], e2[2]) % PI  # The orbit meets the plane z = 0.
        r, b = space.point_at(q, d, swept)
        add(scene, "point where a ray meets the disk", "inverse of the quadrature of dphi/dr", position=q, direction=d,
            status="hit", end_position=r * (np.cos(swept) * e1 + np.sin(swept) * e2), tolerance=1e-7)
        omega, spin = np.sqrt(r - charge**2) / r**2, b * np.cross(e1.astype(float), e2.astype(float))[2]
        look_at = vector(q) + radial / np.sqrt(f(R)) * e1 + across * e2  # d in the rest frame of the camera
        add_redshift(scene, f"redshift of the disk at r = {float(r)!r}",
                     "(1/sqrt(f))/(u^t (1 + Omega L_z)), u^t = 1/sqrt(f - r^2 Omega^2), Omega^2 = (M r - Q^2)/r^4",
                     np.sqrt((f(r) - (r * omega)**2) / f(R)) / (1 + omega * spin), {"camera.look_at": look_at},
                     status="hit")


def bounded_holes():
    """Holes inside an outer horizon: Kottler's and Kiselev's."""
    q, cosmological = [-12, 0, 0.5], LD(6) / 1000
    f = lambda r: 1 - 2 / r - cosmological * r * r / 3
    root = np.sqrt(cosmological)
    edge = LD(95) / 100 * 2 / root * np.cos(np.arccos(-3 * root) / 3)
    space = hole(f, 1.03 * 2 / root * np.cos((PI + np.arccos(3 * root)) / 3))
    rim("kottler", space, q, 3 * np.sqrt(LD(3)) / np.sqrt(1 - 9 * cosmological),
        "b = 3 sqrt(3) M/sqrt(1 - 9 Lambda M^2), photon sphere r = 3M (Lake and Roeder 1977)")
    rays("kottler", space, q, [[1, 0.75, 0.1]], edge, "quadratures; the orbit does not depend on Lambda (Islam 1983)")
    static_redshift("kottler", space, q, edge)
    # Islam's theorem: the same angle in Schwarzschild's spacetime, with 1/b^2 + Lambda/3.
    b, plain_hole = space.impact(q, [1, 0.75, 0.1]), hole(lambda r: 1 - 2 / r, 2.05)
    angles = []
    for s, impact in ((space, b), (plain_hole, 1 / np.sqrt(1 / b**2 + cosmological / 3))):
        turning = first_zero(lambda v: s.radial_squared(v, impact), 12, s.low)
        angles.append(sum(quad_from_root(s.angle(impact), turning, LD(end)) for end in (12, edge)))
    assert abs(angles[0] - angles[1]) < 1e-11

    q, c = [-15, 0, 0.5], LD(2) / 100
    f = lambda r: 1 - 2 / r - c * r
    space = hole(f, 1.05 * (1 - np.sqrt(1 - 8 * c)) / (2 * c))
    edge, photon = LD(9) / 10 * (1 + np.sqrt(1 - 8 * c)) / (2 * c), (1 - np.sqrt(1 - 6 * c)) / c
    rim("kiselev", space, q, photon / np.sqrt(f(photon)), "b = r/sqrt(f) at r = (1 - sqrt(1 - 6 M c))/c")
    rays("kiselev", space, q, [[1, 0.6, 0.1]], edge)
    static_redshift("kiselev", space, q, edge)


def regular_holes():
    """Hayward's and Bardeen's holes, and Hayward's core without a horizon."""
    q = [-15, 0, 0.5]
    for scene, f, slope, low, constants in (
            ("hayward", *hayward(LD(9) / 10), 1e-6, None), ("hayward", *hayward(LD(6) / 10), 1.8, {"l": 0.6}),
            ("bardeen", *bardeen(LD(75) / 100), 1.4, None)):
        space = hole(f, low)
        photon = bisect(lambda r: r * slope(r) - 2 * f(r), 2.3, 3.5)
        through = low < 1
        if not through:
            rim(scene, space, q, photon / np.sqrt(f(photon)), "b = r/sqrt(f) at r f' = 2 f", constants=constants)
        rays(scene, space, q, [[1, 0.42, 0.11]] + ([[1, 0.2, 0.1], [1, 0.05, 0.02]] if through else []), 100,
             constants=constants)
        static_redshift(scene, space, q, constants=constants)


def hayward(l):
    """Returns f and its derivative."""
    return (lambda r: 1 - 2 * r * r / (r**3 + 2 * l * l),
            lambda r: -2 * (2 * r * (r**3 + 2 * l * l) - 3 * r**4) / (r**3 + 2 * l * l)**2)


def bardeen(g):
    """Returns f and its derivative."""
    return (lambda r: 1 - 2 * r * r / (r * r + g * g)**1.5,
            lambda r: 6 * r**3 / (r * r + g * g)**2.5 - 4 * r / (r * r + g * g)**1.5)


def wormholes():
    one = lambda u: LD(1) + 0 * u
    # Ellis's drainhole in its static form: A = F, B = 1/F, C = ((l - m)^2 + k^2)/F.
    scene, q, m, n = "ellis-drainhole", [-8, 0, 0.4], LD(6) / 10, LD(12) / 10
    k = np.sqrt(n * n - m * m)
    F = lambda l: np.exp(-2 * m / k * (PI / 2 - np.arctan((l - m) / k)))
    space = wormhole(F, lambda l: 1 / F(l), lambda l: ((l - m)**2 + k * k) / F(l), n * n / 4, low=-60,
                     g=lambda l: np.sqrt(1 - F(l)) / F(l))
    rim(scene, space, q, np.sqrt(4 * m * m + k * k) / F(3 * m), "photon sphere l = 3m of Ellis (1973)", n / 2)
    rays(scene, space, q, [[1, 0.6, 0.1]], space.u_of(LD(60)))
    rays(scene, space, q, [[1, 0.2, 0.1]], -60)
    static_redshift(scene, space, q, space.u_of(LD(60)))
    static_redshift(scene, space, q, -60, settings={"camera.look_at": [0, 0.3, 0.1]})

    scene, q, b0 = "morris-thorne-zero-density", [-9, 0, 0.5], LD(2)
    space = Spherical(one, lambda R: (1 + b0 / (4 * R))**4, lambda R: R * R * (1 + b0 / (4 * R))**4, low=b0**2 / 1600)
    rim(scene, space, q, b0, "b = b0, the radius of the throat", b0 / 4)
    rays(scene, space, q, [[1, 0.42, 0.1]], 100)
    rays(scene, space, q, [[1, 0.1, 0.06]], b0**2 / 1600)

    scene, q, p, a, width = "morris-thorne-interstellar", [-6, 0, 0.4], LD(1), LD(1) / 2, LD(3) / 10
    def radius(l):
        x = 2 / (PI * width) * np.maximum(abs(l) - a, 0)
        return p + width * (x * np.arctan(x) - np.log(1 + x * x) / 2)
    space = wormhole(one, one, lambda l: radius(l)**2, p * p / 4, low=-60, breaks=(-a, a))
    rim(scene, space, q, p, "b = p, the radius of the throat (James et al. 2015)", 0.5)
    rays(scene, space, q, [[1, 0.3, 0.1]], space.u_of(LD(60)))
    rays(scene, space, q, [[1, 0.08, 0.05]], -60)

    scene, q = "simpson-visser", [-15, 0, 0.5]
    for a, throat, low, constants in ((LD(24) / 10, 1.2, -100, None), (LD(1), None, 1.8, {"a": 1})):
        f = lambda l: 1 - 2 / np.sqrt(l * l + a * a)
        space = wormhole(f, lambda l: 1 / f(l), lambda l: l * l + a * a, a * a / 4, low=low)
        rim(scene, space, q, 3 * np.sqrt(LD(3)), "b = 3 sqrt(3) m for a < 3m (Simpson and Visser 2019)", throat,
            constants)
        rays(scene, space, q, [[1, 0.42, 0.11]], space.u_of(LD(100)), constants=constants)
        if throat:
            rays(scene, space, q, [[1, 0.2, 0.1]], -100)
        static_redshift(scene, space, q, constants=constants)


def singular_fields():
    """The naked singularity of Janis, Newman and Winicour, a global monopole, and two extreme holes."""
    scene, q = "janis-newman-winicour", [-15, 0, 0.5]
    for width, constants in ((LD(25) / 10, None), (LD(8), {"b": 8})):
        g = 2 / width
        f = lambda r: 1 - width / r
        space = Spherical(lambda r: f(r)**g, lambda r: f(r)**-g, lambda r: f(r)**(1 - g) * r * r, low=1.001 * width)
        if g > 0.5:
            photon = (1 + 2 * g) * width / 2
            rim(scene, space, q, photon * f(photon)**((1 - 2 * g) / 2),
                "b = r f^(1/2 - g) at r = (1 + 2g) b/2 (Virbhadra and Ellis 2002)")
        rays(scene, space, q, [[1, 0.42, 0.11]] + ([] if g > 0.5 else [[1, 0.2, 0.11]]), 100, constants=constants)
        static_redshift(scene, space, q, constants=constants)

    # A ray is a straight line of the cone; its distance from the apex is c = b/k.
    k, q, one = LD(9) / 10, [-10, 0, 0], lambda r: LD(1) + 0 * r
    space = Spherical(one, one, lambda r: (k * r)**2)
    for d in ([1, 0.3, 0.2], [1, -0.05, 0.1]):
        R, e1, e2, _, _ = space.plane(q, d)
        b = space.impact(q, d)
        swept = (PI - np.arcsin(b / k / R) - np.arcsin(b / k / 60)) / k
        er, ephi = np.cos(swept) * e1 + np.sin(swept) * e2, np.cos(swept) * e2 - np.sin(swept) * e1
        outward = np.sqrt(1 - (b / k / 60)**2)
        add("global-monopole", f"ray with b = {float(b)!r}",
            "straight line of the cone: angle (pi - asin(c/r0) - asin(c/r1))/k (Barriola and Vilenkin 1989)",
            position=q, direction=d, status="escaped", end_position=60 * er,
            end_direction=unit(outward * er + b / (k * k * 60) * ephi), end_momentum=outward * er + b / 60 * ephi,
            tolerance=1e-9)

    # In the plane y = 0 between the holes, U depends on the distance from the centre only.
    scene, U = "majumdar-papapetrou", lambda r: 1 + 2 / np.sqrt(r * r + 4)
    space = Spherical(lambda r: U(r)**-2, lambda r: U(r)**2, lambda r: (U(r) * r)**2, low=1e-6)
    rays(scene, space, [-16, 0, 0.5], [[1, 0, 0.4], [1, 0, 0.25]], 100, "quadratures in the plane of symmetry")
    static_redshift(scene, space, [-16, 0, 0.5])
    factor = lambda y: (1 + 1 / (y - 2) + 1 / (y + 2))**2
    add(scene, "ray along the axis of both holes", "t is the integral of U^2 dy", position=[0, 12, 0],
        direction=[0, 1, 0], status="escaped", end_position=[0, 100, 0], end_momentum=[0, factor(LD(100)), 0],
        time=-quad(factor, 12, 100), tolerance=1e-9)


class Rotating:
    """A rotating hole of the form of Boyer and Lindquist, with S = X - a^2 sin^2(theta).

    Charts: "bl", "ks" for Kerr and Schild, "doran". w is 2Mr - Q^2.
    """

    def __init__(self, X, dX, D, dD, a, horizon, chart="bl", w=None):
        self.X, self.dX, self.D, self.dD, self.a, self.horizon, self.chart, self.w = X, dX, D, dD, a, horizon, chart, w

    def azimuth_shift(self, r):
        """Returns d(phi of the chart - phi of Boyer and Lindquist)/dr."""
        if self.chart == "bl":
            return 0 * r
        flow = 1 if self.chart == "ks" else np.sqrt(self.w(r) / (r * r + self.a**2))
        return -self.a * flow / self.D(r)

    def time_shift(self, r):
        """Returns d(t of the chart - t of Boyer and Lindquist)/dr."""
        return -(self.w(r) if self.chart == "ks" else np.sqrt(self.w(r) * (r * r + self.a**2))) / self.D(r)

    def spherical(self, q):
        x, y, z = vector(q)
        if self.chart != "ks":
            return np.sqrt(x * x + y * y + z * z), np.arctan2(np.sqrt(x * x + y * y), z), np.arctan2(y, x)
        b = x * x + y * y + z * z - self.a**2
        r = np.sqrt((b + np.sqrt(b * b + 4 * self.a**2 * z * z)) / 2)
        theta = np.arctan2(np.sqrt((x * x + y * y) / (r * r + self.a**2)), z / r)
        return r, theta, np.arctan2(y, x) - np.arctan2(-self.a, r)

    def cartesian(self, r, theta, phi):
        rho, turn = r * np.sin(theta), 0
        if self.chart == "ks":
            rho, turn = np.sqrt(r * r + self.a**2) * np.sin(theta), np.arctan2(-self.a, r)
        return vector([rho * np.cos(phi + turn), rho * np.sin(phi + turn), r * np.cos(theta)])

    def jacobian(self, *point):
        """Returns the derivatives of x, y, z by r, theta, phi, by differences of fourth order."""
        step = LD(1e-6)
        columns = []
        for axis in np.eye(3).astype(LD) * step:
            f = [self.cartesian(*(vector(point) + k * axis)) for k in (-2, -1, 1, 2)]
            columns.append((f[0] - 8 * f[1] + 8 * f[2] - f[3]) / (12 * step))
        return np.array(columns).T

    def metric(self, r, theta):
        """Returns g_ab for t, r, theta, phi of Boyer and Lindquist."""
        sine2, a, D, X = np.sin(theta)**2, self.a, self.D(r), self.X(r)
        S = X - a * a * sine2
        g = np.diag([-(D - a * a * sine2) / S, S / D, S, (X * X - D * a * a * sine2) * sine2 / S])
        g[0, 3] = g[3, 0] = (D - X) * a * sine2 / S
        return g

    def start(self, q, d):
        """Returns the coordinates and the momentum at the start of a ray."""
        point = self.spherical(q)
        J = self.jacobian(*point)
        rate = np.zeros(3, LD)
        for _ in range(3):  # Newton's corrections of a solution in double precision
            rate += np.linalg.solve(J.astype(float), (vector(d) - J @ rate).astype(float))
        rate[2] -= self.azimuth_shift(point[0]) * rate[0]
        g = self.metric(point[0], point[1])
        half, square = g[0, 3] * rate[2], g[1, 1] * rate[0]**2 + g[2, 2] * rate[1]**2 + g[3, 3] * rate[2]**2
        p = g @ np.array([(np.sqrt(half * half - g[0, 0] * square) - half) / g[0, 0], *rate])
        return point, p / p[0]

    def end(self, q, d, distance):
        """Returns the end of a ray at |q| = distance: Mino time, theta by the elliptic function cn."""
        (r0, theta0, phi0), p = self.start(q, d)
        a, L, turns = self.a, p[3], 1 if self.chart != "bl" else 0
        K = p[2]**2 + (L / np.sin(theta0) + a * np.sin(theta0))**2  # Carter's constant
        P = lambda r: self.X(r) + a * L
        R = lambda r: P(r)**2 - self.D(r) * K
        turning = first_zero(R, r0, self.horizon * LD(1.0001))
        integral = lambda f, end: sum(quad_from_root(lambda r: f(r) / np.sqrt(R(r)), turning, e) for e in (r0, end))
        # cos(theta) = amplitude cn(rate tau + phase, m)
        beta, gamma = 2 * a * a - K + 2 * a * L, K - 2 * a * L - L * L - a * a
        root = np.sqrt(beta * beta + 4 * a * a * gamma)
        plus, minus = (root + beta) / (2 * a * a), (root - beta) / (2 * a * a)
        m, rate, amplitude = plus / (plus + minus), a * np.sqrt(plus + minus), np.sqrt(plus)
        phase = np.arccos(np.clip(np.cos(theta0) / amplitude, -1, 1)) * (1 if p[2] > 0 else -1)
        phase = ellipkinc(float(phase), float(m))

        def cosine(tau):
            sn, cn, dn, _ = ellipj(np.asarray(phase + rate * tau, float), float(m))
            return amplitude * cn, -amplitude * rate * sn * dn
        r = LD(distance)
        for _ in range(30):
            tau = integral(lambda v: 1 + 0 * v, r)
            u, du = cosine(tau)
            if self.chart == "ks":
                r = bisect(lambda v: v * v + a * a * (1 - u * u) - LD(distance)**2, distance / 2, distance + 1)
        phi = phi0 + integral(lambda v: -a * P(v) / self.D(v), r) + a * tau
        phi += quad(lambda t: L / (1 - cosine(t)[0]**2), 0, tau)
        time = integral(lambda v: -self.X(v) * P(v) / self.D(v), r) + a * L * tau
        time += a * a * quad(lambda t: 1 - cosine(t)[0]**2, 0, tau)
        if turns:
            phi += quad(self.azimuth_shift, r0, r, 200)
            time += quad(self.time_shift, r0, r, 200)
        theta, radial = np.arccos(LD(u)), np.sqrt(R(r))
        azimuthal = L / np.sin(theta)**2 + a - a * P(r) / self.D(r) + self.azimuth_shift(r) * radial
        velocity = self.jacobian(r, theta, phi) @ vector([radial, -du / np.sin(theta), azimuthal])
        return {"end_position": self.cartesian(r, theta, phi), "end_direction": unit(velocity), "time": time}

    def critical(self, r):
        """Returns p_phi and K of the spherical photon orbit: R = R' = 0."""
        P = 2 * self.dX(r) * self.D(r) / self.dD(r)
        return (P - self.X(r)) / self.a, P * P / self.D(r)

    def direction(self, q, L, K, sign):
        """Returns the direction of the ray from q, inward, with p_phi = L; sign is that of p_theta."""
        r, theta, phi = self.spherical(q)
        P, sine = self.X(r) + self.a * L, np.sin(theta)
        radial = -np.sqrt(P * P - self.D(r) * K)
        polar = sign * np.sqrt(K - (L / sine + self.a * sine)**2)
        azimuthal = L / sine**2 + self.a - self.a * P / self.D(r) + self.azimuth_shift(r) * radial
        return unit(self.jacobian(r, theta, phi) @ vector([radial, polar, azimuthal]))


def rotating_holes():
    q, a, charge2, b = [-13, 0, 2], LD(7) / 10, LD(36) / 100, LD(3) / 10
    kerr_newman = (lambda r: r * r + a * a, lambda r: 2 * r, lambda r: r * r - 2 * r + a * a + charge2,
                   lambda r: 2 * r - 2, a, 1 + np.sqrt(1 - a * a - charge2))
    s = LD(6) / 10
    sen = (lambda r: r * (r + 2 * b) + s * s, lambda r: 2 * r + 2 * b, lambda r: r * (r + 2 * b) + s * s - 2 * r,
           lambda r: 2 * r + 2 * b - 2, s, 1 - b + np.sqrt((1 - b)**2 - s * s))
    w = lambda r: 2 * r - charge2
    for scene, space in (("kerr-newman-boyer-lindquist", Rotating(*kerr_newman)),
                         ("kerr-newman-kerr-schild", Rotating(*kerr_newman, "ks", w)),
                         ("kerr-newman-doran", Rotating(*kerr_newman, "doran", w)), ("kerr-sen", Rotating(*sen))):
        for d in ([1, 0.5, -0.1], [1, -0.55, 0.05], [1, 0.05, 0.45]):
            add(scene, f"ray in the direction {d}", "quadratures in Mino time with Carter's constant (Carter 1968)",
                position=q, direction=d, status="escaped", **space.end(q, d, 100), tolerance=1e-7)
        # Orbits in the equatorial plane have K = (p_phi + a)^2.
        excess = lambda r: space.critical(r)[1] - (space.critical(r)[0] + space.a)**2
        grid = np.linspace(space.horizon * LD(1.02), LD(5), 4001)
        sign = excess(grid) > 0
        orbits = [bisect(excess, grid[i], grid[i + 1]) for i in np.nonzero(sign[1:] != sign[:-1])[0]]
        for share in (0.35, 0.6):
            r = orbits[0] + (orbits[-1] - orbits[0]) * LD(share)
            L, K = space.critical(r)
            for upward in (1, -1):
                for change, status in ((1e-6, "escaped"), (-1e-6, "captured")):
                    add(scene, f"ray at p_phi = {float(L)!r}, K = {float(K)!r} (1 {change:+g})",
                        f"spherical photon orbit r = {float(r)!r}: P = 2 X' D/D', K = P^2/D (Teo 2003)", position=q,
                        direction=space.direction(q, L, K * (1 + LD(change)), upward), status=status)
    space = Rotating(*kerr_newman)
    add_redshift("kerr-newman-boyer-lindquist", "redshift of the sky, static camera", "1/sqrt(-g_tt)",
                 1 / np.sqrt(-space.metric(*space.spherical(q)[:2])[0, 0]))


def alcubierre():
    """p_t - v p_x is the frequency for the stars. On the axis, p_x is conserved there; p_x = 0 is conserved too."""
    scene, v = "alcubierre", LD(1) / 2
    for d, p in (([1, 0, 0], [1 / (1 + v), 0, 0]), ([-1, 0, 0], [-1 / (1 - v), 0, 0]), ([0, 1, 0], [0, 1, 0]),
                 ([0, 0.6, -0.8], [0, 0.6, -0.8])):
        add(scene, f"ray in the direction {d}", "conserved momentum", position=[0, 0, 0], direction=d,
            status="escaped", end_momentum=p, end_direction=unit(vector(p) + vector([v * (1 - v * p[0]), 0, 0])),
            tolerance=1e-9)
    for target, value, speed in (([1, 0, 0], 1.5, None), ([-1, 0, 0], 0.5, None), ([0, 1, 0], 1.0, None),
                                 ([1, 0, 0], 1.9, 0.9), ([1, 0, 0], 2.5, 1.5)):
        add_redshift(scene, f"redshift of the star in the direction {target}", "1 + v cos(angle) (Alcubierre 1994)",
                     value, {"camera.look_at": target}, speed and {"v": speed})


def cosmic_string():
    """A ray is a straight line of the cone around the string."""
    k, radius = LD(95) / 100, LD(10)
    for d in ([1, 0.2, 0.1], [1, -0.05, -0.2]):
        side = -1 if d[1] > 0 else 1  # sign of dphi
        across, speed = k * abs(LD(d[1])), np.sqrt(1 + (k * LD(d[1]))**2)
        length = np.sqrt(speed**2 + LD(d[2])**2)
        b, w, wz = radius * across / speed, speed / length, LD(d[2]) / length
        before = np.sqrt(radius**2 - b * b) / w
        after = bisect(lambda s: b * b + (w * s)**2 + (wz * (s + before))**2 - 3600, 0, 100)
        rho = np.sqrt(b * b + (w * after)**2)
        er, ephi = frame(PI + side * (PI - np.arcsin(b / radius) - np.arcsin(b / rho)) / k)
        sine = b / rho
        along = w * np.sqrt(1 - sine**2) * er + vector([0, 0, wz])
        add("cosmic-string", f"ray with the distance {float(b)!r} from the string",
            "straight line of the cone with the angle k phi (Vilenkin 1981)", position=[-10, 0, 0], direction=d,
            status="escaped", end_position=rho * er + vector([0, 0, wz * (before + after)]),
            end_direction=unit(along + side * w * sine / k * ephi), end_momentum=along + side * w * sine * k * ephi,
            tolerance=1e-9)


def goedel():
    """rho = 2a sqrt(c) sin(w lambda), phi by an arc tangent: Kajari et al. (2004)."""
    scene, a = "goedel", LD(2)
    for d, parameter in (([1, 0, 0], LD(3)), ([0.6, 0.3, 0.5], LD(3)), ([0.6, 0.3, 0.5], LD(17) / 4)):
        u = unit(d)
        c, w = (1 - u[2]**2) / (1 + u[2]**2), np.sqrt(1 + u[2]**2) / (2 * a)
        x, root = w * parameter, np.sqrt(1 + c)
        integral = (np.arctan(root * np.tan(x)) + (PI if x > PI / 2 else 0)) / (w * root)
        er, ephi = frame(np.arctan2(u[1], u[0]) - integral / (np.sqrt(LD(2)) * a))
        rho, along = 2 * a * np.sqrt(c) * np.sin(x), vector([0, 0, u[2]])
        rate = -1 / (np.sqrt(LD(2)) * a * (1 + c * np.sin(x)**2))
        add(scene, f"ray from the axis at lambda = {float(parameter)!r}", "closed form (Kajari et al. 2004)",
            position=[0, 0, 0], direction=d, parameter=parameter, status="step_limit",
            end_position=rho * er + along * parameter,
            end_direction=unit(2 * a * np.sqrt(c) * w * np.cos(x) * er + rho * rate * ephi + along),
            time=parameter - 2 * integral, tolerance=1e-9)
    add(scene, "ray that returns to its start", "lambda = 2 pi a, t = 2 pi a (sqrt(2) - 1) (Kajari et al. 2004)",
        position=[0, 0, 0], direction=[1, 0.5, 0], parameter=2 * PI * a, status="step_limit", end_position=[0, 0, 0],
        time=-2 * PI * a * (np.sqrt(LD(2)) - 1), tolerance=1e-8)


def plane_wave():
    """x is a hyperbolic sine, y a sine of lambda."""
    A, parameter = LD(3) / 100, LD(4)
    for d in ([0.3, 0.4, 1], [0.5, -0.2, -0.8], [1, 0.7, 0]):
        u = unit(d)
        total = 1 + u[2]  # p_t + p_z is conserved
        k = total * np.sqrt(A / 2)
        s = k * parameter
        x, y = u[0] / k * np.sinh(s), u[1] / k * np.sin(s)
        spread = (u[0] / k)**2 * (np.sinh(2 * s) / (2 * k) - parameter) / 2
        focus = (u[1] / k)**2 * (parameter - np.sin(2 * s) / (2 * k)) / 2
        p = vector([u[0] * np.cosh(s), u[1] * np.cos(s), u[2]])
        add("pp-wave", f"ray in the direction {d}", "closed form (Ehlers and Kundt 1962)", position=[0, 0, 0],
            direction=d, parameter=parameter, status="step_limit",
            end_position=[x, y, u[2] * parameter - total * A / 2 * (spread - focus)],
            end_direction=unit([p[0], p[1], u[2] - total * A / 2 * (x * x - y * y)]), end_momentum=p, tolerance=1e-9)


def balasin_grumiller():
    """Rays in the equatorial plane."""
    scene, V, r0, R, start, end = "balasin-grumiller", LD(2) / 10, LD(1), LD(10), LD(14), LD(60)
    N = lambda r: V * (R - r0) + V * (np.sqrt(r * r + r0 * r0) - np.sqrt(r * r + R * R))
    sources = ((r0, 1), (-r0, 1), (R, -1), (-R, -1))

    def nu(r):
        return -V * V / 8 * sum(c1 * c2 * np.log(np.sqrt((r * r + z1**2) * (r * r + z2**2)) + z1 * z2 + r * r)
                                for z1, c1 in sources for z2, c2 in sources)
    for slope in (0.5, -0.5):
        dphi = -LD(slope) / start
        proper = -np.sqrt((start * dphi)**2 + np.exp(nu(start)))  # dt - N dphi
        L = -(N(start) * proper + start**2 * dphi) / proper
        W = lambda r: (L + N(r)) / r
        turning = first_zero(lambda r: 1 - W(r)**2, start, 0.2)
        weight = lambda r: np.exp(nu(r) / 2) / np.sqrt(1 - W(r)**2)
        phi, time = (sum(quad_from_root(lambda r: f(r) * weight(r), turning, e) for e in (start, end))
                     for f in (lambda r: W(r) / r, lambda r: N(r) * W(r) / r - 1))
        er, ephi = frame(PI + phi)
        root, scale = np.sqrt(1 - W(end)**2), np.exp(nu(end) / 2)
        add(scene, f"ray in the equatorial plane with p_phi = {float(L)!r}", "quadratures of the printed line element",
            position=[-14, 0, 0], direction=[1, slope, 0], status="escaped", end_position=end * er,
            end_direction=unit(root / scale * er + W(end) * ephi), end_momentum=scale * root * er + L / end * ephi,
            time=time, tolerance=1e-8)
    add_redshift(scene, "redshift of the sky, static camera", "g_tt = -1 everywhere", 1.0)


def main():
    for compute in (schwarzschild, reissner_nordstrom, bounded_holes, regular_holes, wormholes, singular_fields,
                    rotating_holes, alcubierre, cosmic_string, goedel, plane_wave, balasin_grumiller):
        compute()
    text = "[\n" + ",\n".join(json.dumps(check) for check in CHECKS) + "\n]\n"
    (pathlib.Path(__file__).resolve().parent / "spacetimes_reference.json").write_text(text)


main()
