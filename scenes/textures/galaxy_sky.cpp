// A dark sky with a large spiral galaxy in the direction +x, and a second galaxy near −x that is tilted less.
#include "textures.h"

#include <algorithm>

namespace textures {

namespace {

constexpr std::uint64_t seed = 31;
constexpr double galaxy_radius = 27 * degree;   // Angular radius of the disc.
constexpr double inclination = 58 * degree;     // Angle between the disc and the plane of the sky; 0 is face-on.
constexpr double position_angle = 28 * degree;  // Angle of the long axis to the horizontal.
constexpr double pitch = 21 * degree;           // Pitch angle of the logarithmic spiral arms.

/// A point in the plane of the disc, in units of the disc radius, and in coordinates that follow the arms.
struct DiscPoint {
    double x, y;  // Along and across the long axis, without the foreshortening by the inclination.
    double radius;
    double phase;  // Constant along an arm, in radians. The two main arms are at 0 and pi.
};

DiscPoint disc_point(double x, double y) {
    const double radius = std::max(std::hypot(x, y), 1e-6);
    return {x, y, radius, std::atan2(y, x) + std::log(radius) / std::tan(pitch)};
}

/// Returns the direction of a point (x, y) of the disc.
SkyPosition position_on_sky(double x, double y) {
    const double across = y * std::cos(inclination);
    const double u = galaxy_radius * (x * std::cos(position_angle) - across * std::sin(position_angle));
    const double v = galaxy_radius * (x * std::sin(position_angle) + across * std::cos(position_angle));
    return sky_position_of(Vec{1, u, v});
}

/// Returns coordinates for noise that is stretched along the arms. `along` and `across` are the frequencies of the
/// noise in these two directions.
Vec spiral_coordinates(const DiscPoint& p, double along, double across) {
    return {across * std::cos(p.phase), across * std::sin(p.phase), along * std::log(p.radius)};
}

/// Returns the brightness of the two main arms and of four minor arms, 0 to 1.16.
double arm_strength(const DiscPoint& p) {
    const double phase_offset = 0.55 * fractal_noise(seed + 10, {3 * p.x, 3 * p.y, 0}, 3);
    const double main = std::pow(0.5 + 0.5 * std::cos(2 * (p.phase + phase_offset)), 3.0);
    const double minor = std::pow(0.5 + 0.5 * std::cos(4 * (p.phase + phase_offset) + 1.1), 3.0);
    return main + 0.16 * minor;
}

/// Returns the optical depth of dust in red.
double dust_depth(const DiscPoint& p) {
    const double lane =
        std::pow(0.5 + 0.5 * std::cos(2 * (p.phase + 0.5 * fractal_noise(seed + 10, {3 * p.x, 3 * p.y, 0}, 3)) + 1.0),
                 3.0);
    const double fibres = std::pow(ridged_noise(seed + 20, spiral_coordinates(p, 7, 3.2), 5), 3.0);
    const double clumps = std::max(0.0, 0.5 + fractal_noise(seed + 30, {9 * p.x, 9 * p.y, 1}, 5));
    const double radial_weight = smoothstep(0.04, 0.2, p.radius) * (1 - smoothstep(0.45, 0.95, p.radius));
    // On the near side of the disc, dust absorbs more light because more of the disc is behind it.
    return radial_weight * (1.7 * lane * clumps + 2.6 * fibres * clumps) * (p.y < 0 ? 1.25 : 0.8);
}

/// Returns the light of a galaxy at a point (x, y) of its disc; `flat_y` is y with the foreshortening by the
/// inclination.
Color galaxy_light(double x, double y, double flat_y) {
    const DiscPoint p = disc_point(x, y);
    const double edge_fade =
        1 - smoothstep(0.7, 1.35, p.radius + 0.12 * fractal_noise(seed + 40, {4 * x, 4 * y, 0}, 4));
    const double clouds = std::max(0.0, 1 + 1.1 * fractal_noise(seed + 50, spiral_coordinates(p, 9, 4), 6, 0.62));
    const double grain = 1 + 0.45 * fractal_noise(seed + 60, {40 * x, 40 * y, 0}, 3, 0.7);
    const double arms = arm_strength(p) * clouds * grain * smoothstep(0.08, 0.35, p.radius);
    const Color old_disc = 0.85 * std::exp(-p.radius / 0.23) * Color{1.0, 0.78, 0.54};
    const Color young_arms = 3.2 * std::exp(-p.radius / 0.40) * arms * Color{0.50, 0.70, 1.0};
    const double bulge_radius = std::hypot(x, flat_y / 0.72);
    const Color bulge =
        (3.4 * std::exp(-bulge_radius / 0.035) + 0.8 * std::exp(-bulge_radius / 0.10)) * Color{1.0, 0.80, 0.55};
    return dust_transmittance(dust_depth(p)) * (edge_fade * (old_disc + young_arms)) +
           dust_transmittance(0.35 * dust_depth(p)) * bulge;
}

void add_galaxy(Picture& sky) {
    for (int y = 0; y < sky.height; ++y)
        for (int x = 0; x < sky.width; ++x) {
            const Vec d = direction_of(sky_position_of(sky, x, y));
            if (d.x < 0.5) continue;
            const double u = d.y / d.x / galaxy_radius, v = d.z / d.x / galaxy_radius;
            const double along = u * std::cos(position_angle) + v * std::sin(position_angle);
            const double across = v * std::cos(position_angle) - u * std::sin(position_angle);
            if (std::hypot(along, across) > 1.6) continue;
            sky.at(x, y) = sky.at(x, y) + galaxy_light(along, across / std::cos(inclination), across);
        }
}

/// Adds the second galaxy, on the other side of the sky. It is visible if the camera looks away from the first.
void add_second_galaxy(Picture& sky) {
    constexpr double radius = 44 * degree, tilt = 35 * degree;
    constexpr SkyPosition center{164 * degree, 6 * degree};
    const double c = std::cos(center.longitude), s = std::sin(center.longitude);
    const Vec middle = direction_of(center), side{-s, c, 0};
    const Vec up{-std::sin(center.latitude) * c, -std::sin(center.latitude) * s, std::cos(center.latitude)};
    for (int y = 0; y < sky.height; ++y)
        for (int x = 0; x < sky.width; ++x) {
            const Vec d = direction_of(sky_position_of(sky, x, y));
            const double near = dot(d, middle);
            if (near < 0.5) continue;
            const double along = dot(d, side) / near / radius, across = dot(d, up) / near / radius;
            if (std::hypot(along, across) > 1.5) continue;
            sky.at(x, y) = sky.at(x, y) + 0.8 * galaxy_light(along, across / std::cos(tilt), across);
        }
}

/// Adds clusters of young stars along the arms, and glowing hydrogen around some of them.
void add_star_clusters(Picture& sky) {
    Random random(seed + 70);
    for (int i = 0; i < 900; ++i) {
        const double radius = random.between(0.22, 1.12);
        const double phase = std::numbers::pi * std::floor(2 * random()) + 0.28 * random.normal();
        const double angle = phase - std::log(radius) / std::tan(pitch);
        const double x = radius * std::cos(angle), y = radius * std::sin(angle);
        const double phase_offset = 0.55 * fractal_noise(seed + 10, {3 * x, 3 * y, 0}, 3);
        const bool hydrogen = random() < 0.35;
        const Color light = hydrogen ? Color{1.0, 0.22, 0.38} : Color{0.5, 0.7, 1.0};
        const double strength = random.between(0.04, 0.16) * std::pow(1 - random(), -0.55);
        add_spot(sky, position_on_sky(radius * std::cos(angle - phase_offset), radius * std::sin(angle - phase_offset)),
                 random.between(0.12, 0.26) * degree, std::min(strength, 0.8) * light);
    }
}

/// Adds two small companions, similar to M32 and M110 near Andromeda, and 60 distant galaxies.
void add_companions(Picture& sky) {
    add_spot(sky, position_on_sky(0.30, -0.95), 0.75 * degree, 0.75 * Color{1.0, 0.86, 0.68});
    add_spot(sky, position_on_sky(-0.62, 1.25), 1.1 * degree, 0.28 * Color{1.0, 0.88, 0.75});
    Random random(seed + 80);
    for (int i = 0; i < 60; ++i) {
        const SkyPosition position{random.between(-180, 180) * degree, std::asin(random.between(-1, 1))};
        add_spot(sky, position, random.between(0.2, 0.4) * degree, random.between(0.03, 0.12) * Color{1.0, 0.82, 0.62});
    }
}

/// Returns the brightness of the observer's own galaxy, a faint band along a tilted great circle.
double band(const Vec& d) {
    const double height = dot(d, {0.35, 0.50, 0.79});
    const double clouds = std::max(0.0, 0.75 + 0.9 * fractal_noise(seed + 90, 4.0 * d, 6, 0.6));
    const double rift = std::pow(ridged_noise(seed + 95, 3.0 * d, 5), 3.0) * std::exp(-height * height / 0.006);
    return clouds * std::exp(-std::abs(height) / 0.11) * std::exp(-2.5 * rift);
}

void add_band(Picture& sky) {
    for (int y = 0; y < sky.height; ++y)
        for (int x = 0; x < sky.width; ++x) {
            const double light = band(direction_of(sky_position_of(sky, x, y)));
            sky.at(x, y) = sky.at(x, y) + light * Color{0.040, 0.044, 0.058} + Color{0.0010, 0.0012, 0.0022};
        }
}

void add_stars(Picture& sky) {
    Random random(seed);
    for (int i = 0; i < 9000;) {
        const SkyPosition position{random.between(-180, 180) * degree, std::asin(random.between(-1, 1))};
        if (random() > 0.45 + 2 * band(direction_of(position))) continue;
        add_star(sky, random, position, 0.030, 1.05);
        ++i;
    }
}

}  // namespace

Picture galaxy_sky() {
    Picture sky(2048, 1024);
    add_band(sky);
    add_galaxy(sky);
    add_second_galaxy(sky);
    add_star_clusters(sky);
    add_companions(sky);
    add_stars(sky);
    tone_map(sky);
    return sky;
}

}  // namespace textures
