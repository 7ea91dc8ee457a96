// A dark sky with one great spiral galaxy in the direction +x, and a smaller one, seen from above, near −x.
#include "textures.h"

#include <algorithm>

namespace textures {

namespace {

constexpr std::uint64_t seed = 31;
constexpr double galaxy_radius = 27 * degree;   // of the disc, where it ends
constexpr double inclination = 58 * degree;     // 0 would be face on
constexpr double position_angle = 28 * degree;  // of the long axis, against the horizontal
constexpr double pitch = 21 * degree;           // of the arms

/// A point of the disc's plane, in disc radii, and in the arms' own coordinates.
struct DiscPoint {
    double x, y;  // along and across the long axis, the inclination taken out
    double radius;
    double phase;  // constant along an arm; two arms lie at 0 and pi
};

DiscPoint disc_point(double x, double y) {
    const double radius = std::max(std::hypot(x, y), 1e-6);
    return {x, y, radius, std::atan2(y, x) + std::log(radius) / std::tan(pitch)};
}

/// Where the point of the disc is on the sky.
Place place_on_sky(double x, double y) {
    const double across = y * std::cos(inclination);
    const double u = galaxy_radius * (x * std::cos(position_angle) - across * std::sin(position_angle));
    const double v = galaxy_radius * (x * std::sin(position_angle) + across * std::cos(position_angle));
    return place_of(Vec{1, u, v});
}

/// Noise drawn out along the arms: `along` and `across` say how fine it is.
Vec spiral_coordinates(const DiscPoint& p, double along, double across) {
    return {across * std::cos(p.phase), across * std::sin(p.phase), along * std::log(p.radius)};
}

double arm_strength(const DiscPoint& p) {
    const double wander = 0.55 * fractal(seed + 10, {3 * p.x, 3 * p.y, 0}, 3);
    const double main = std::pow(0.5 + 0.5 * std::cos(2 * (p.phase + wander)), 3.0);
    const double minor = std::pow(0.5 + 0.5 * std::cos(4 * (p.phase + wander) + 1.1), 3.0);
    return main + 0.16 * minor;
}

double dust_depth(const DiscPoint& p) {
    const double lane =
        std::pow(0.5 + 0.5 * std::cos(2 * (p.phase + 0.5 * fractal(seed + 10, {3 * p.x, 3 * p.y, 0}, 3)) + 1.0), 3.0);
    const double fibres = std::pow(threads(seed + 20, spiral_coordinates(p, 7, 3.2), 5), 3.0);
    const double clumps = std::max(0.0, 0.5 + fractal(seed + 30, {9 * p.x, 9 * p.y, 1}, 5));
    const double where = smooth(0.04, 0.2, p.radius) * (1 - smooth(0.45, 0.95, p.radius));
    // Dust lies in front of more light on the near side of the disc.
    return where * (1.7 * lane * clumps + 2.6 * fibres * clumps) * (p.y < 0 ? 1.25 : 0.8);
}

Color galaxy_light(double x, double y, double flat_y) {
    const DiscPoint p = disc_point(x, y);
    const double end = 1 - smooth(0.7, 1.35, p.radius + 0.12 * fractal(seed + 40, {4 * x, 4 * y, 0}, 4));
    const double clouds = std::max(0.0, 1 + 1.1 * fractal(seed + 50, spiral_coordinates(p, 9, 4), 6, 0.62));
    const double grain = 1 + 0.45 * fractal(seed + 60, {40 * x, 40 * y, 0}, 3, 0.7);
    const double arms = arm_strength(p) * clouds * grain * smooth(0.08, 0.35, p.radius);
    const Color old_disc = 0.85 * std::exp(-p.radius / 0.23) * Color{1.0, 0.78, 0.54};
    const Color young_arms = 3.2 * std::exp(-p.radius / 0.40) * arms * Color{0.50, 0.70, 1.0};
    const double bulge_radius = std::hypot(x, flat_y / 0.72);
    const Color bulge =
        (3.4 * std::exp(-bulge_radius / 0.035) + 0.8 * std::exp(-bulge_radius / 0.10)) * Color{1.0, 0.80, 0.55};
    return through_dust(dust_depth(p)) * (end * (old_disc + young_arms)) + through_dust(0.35 * dust_depth(p)) * bulge;
}

void add_galaxy(Picture& sky) {
    for (int y = 0; y < sky.height; ++y)
        for (int x = 0; x < sky.width; ++x) {
            const Vec d = direction_of(place_of(sky, x, y));
            if (d.x < 0.5) continue;
            const double u = d.y / d.x / galaxy_radius, v = d.z / d.x / galaxy_radius;
            const double along = u * std::cos(position_angle) + v * std::sin(position_angle);
            const double across = v * std::cos(position_angle) - u * std::sin(position_angle);
            if (std::hypot(along, across) > 1.6) continue;
            sky.at(x, y) = sky.at(x, y) + galaxy_light(along, across / std::cos(inclination), across);
        }
}

/// A neighbour on the other side of the sky, to be seen with one's back to the great one.
void add_neighbour(Picture& sky) {
    constexpr double radius = 44 * degree, tilt = 35 * degree;
    constexpr Place center{164 * degree, 6 * degree};
    const double c = std::cos(center.longitude), s = std::sin(center.longitude);
    const Vec middle = direction_of(center), side{-s, c, 0};
    const Vec up{-std::sin(center.latitude) * c, -std::sin(center.latitude) * s, std::cos(center.latitude)};
    for (int y = 0; y < sky.height; ++y)
        for (int x = 0; x < sky.width; ++x) {
            const Vec d = direction_of(place_of(sky, x, y));
            const double near = dot(d, middle);
            if (near < 0.5) continue;
            const double along = dot(d, side) / near / radius, across = dot(d, up) / near / radius;
            if (std::hypot(along, across) > 1.5) continue;
            sky.at(x, y) = sky.at(x, y) + 0.8 * galaxy_light(along, across / std::cos(tilt), across);
        }
}

/// Clusters of young stars, and the glowing hydrogen around some of them, along the arms.
void add_knots(Picture& sky) {
    Random random(seed + 70);
    for (int i = 0; i < 900; ++i) {
        const double radius = random.between(0.22, 1.12);
        const double phase = std::numbers::pi * std::floor(2 * random()) + 0.28 * random.normal();
        const double angle = phase - std::log(radius) / std::tan(pitch);
        const double x = radius * std::cos(angle), y = radius * std::sin(angle);
        const double wander = 0.55 * fractal(seed + 10, {3 * x, 3 * y, 0}, 3);
        const bool hydrogen = random() < 0.35;
        const Color light = hydrogen ? Color{1.0, 0.22, 0.38} : Color{0.5, 0.7, 1.0};
        const double strength = random.between(0.04, 0.16) * std::pow(1 - random(), -0.55);
        add_spot(sky, place_on_sky(radius * std::cos(angle - wander), radius * std::sin(angle - wander)),
                 random.between(0.12, 0.26) * degree, std::min(strength, 0.8) * light);
    }
}

/// Small neighbours, as M32 and M110 are to Andromeda, and galaxies far away.
void add_companions(Picture& sky) {
    add_spot(sky, place_on_sky(0.30, -0.95), 0.75 * degree, 0.75 * Color{1.0, 0.86, 0.68});
    add_spot(sky, place_on_sky(-0.62, 1.25), 1.1 * degree, 0.28 * Color{1.0, 0.88, 0.75});
    Random random(seed + 80);
    for (int i = 0; i < 60; ++i) {
        const Place place{random.between(-180, 180) * degree, std::asin(random.between(-1, 1))};
        add_spot(sky, place, random.between(0.2, 0.4) * degree, random.between(0.03, 0.12) * Color{1.0, 0.82, 0.62});
    }
}

/// The faint band of the galaxy one is in oneself: a great circle, tilted.
double band(const Vec& d) {
    const double height = dot(d, {0.35, 0.50, 0.79});
    const double clouds = std::max(0.0, 0.75 + 0.9 * fractal(seed + 90, 4.0 * d, 6, 0.6));
    const double rift = std::pow(threads(seed + 95, 3.0 * d, 5), 3.0) * std::exp(-height * height / 0.006);
    return clouds * std::exp(-std::abs(height) / 0.11) * std::exp(-2.5 * rift);
}

void add_band(Picture& sky) {
    for (int y = 0; y < sky.height; ++y)
        for (int x = 0; x < sky.width; ++x) {
            const double light = band(direction_of(place_of(sky, x, y)));
            sky.at(x, y) = sky.at(x, y) + light * Color{0.040, 0.044, 0.058} + Color{0.0010, 0.0012, 0.0022};
        }
}

void add_stars(Picture& sky) {
    Random random(seed);
    for (int i = 0; i < 9000;) {
        const Place place{random.between(-180, 180) * degree, std::asin(random.between(-1, 1))};
        if (random() > 0.45 + 2 * band(direction_of(place))) continue;
        add_star(sky, random, place, 0.030, 1.05);
        ++i;
    }
}

}  // namespace

Picture galaxy_sky() {
    Picture sky(2048, 1024);
    add_band(sky);
    add_galaxy(sky);
    add_neighbour(sky);
    add_knots(sky);
    add_companions(sky);
    add_stars(sky);
    develop(sky);
    return sky;
}

}  // namespace textures
