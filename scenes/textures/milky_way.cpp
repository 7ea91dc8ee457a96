// A sky that resembles the one seen from the Earth, in galactic coordinates: the Milky Way is along the equator, and
// its centre is in the direction +x.
#include "textures.h"

#include <algorithm>

namespace textures {

namespace {

constexpr std::uint64_t seed = 7000;

/// Returns the angle above the middle of the band, in radians. Noise displaces the middle from the equator.
double height_above_plane(const Vec& d) {
    return std::asin(d.z) + 0.035 * fractal_noise(seed + 1, 2.0 * d, 3);
}

/// Returns 1 towards the centre of the galaxy, decreasing to about 0.2 in the opposite direction.
double center_weight(const Vec& d) {
    const double longitude = std::atan2(d.y, d.x);
    return 0.20 + 0.80 * std::exp(-longitude * longitude / 0.9);
}

/// Returns the brightness of the central bulge, 0 to 1.
double bulge_light(const Vec& d) {
    const double longitude = std::atan2(d.y, d.x) / (9.5 * degree), latitude = std::asin(d.z) / (5.5 * degree);
    return std::exp(-std::sqrt(longitude * longitude + latitude * latitude + 0.02));
}

/// Returns the brightness of the disc, with clouds of stars.
double star_clouds(const Vec& d) {
    const double height = std::abs(height_above_plane(d));
    const double clouds = std::max(0.05, 1 + 1.3 * fractal_noise(seed + 10, 6.0 * d, 7, 0.62));
    const double disc = 0.95 * std::exp(-height / (4.6 * degree)) + 0.24 * std::exp(-height / (11 * degree));
    return center_weight(d) * clouds * disc;
}

/// Returns the optical depth of dust in red.
double dust_depth(const Vec& d) {
    const double height = height_above_plane(d) - 1.2 * degree * std::sin(3 * std::atan2(d.y, d.x) + 0.6);
    const double lane = std::exp(-height * height / (2.4 * degree * 2.4 * degree));
    const double wide = std::exp(-height * height / (8.0 * degree * 8.0 * degree));
    const Vec stretched{d.x, d.y, 2.6 * d.z};
    const double clumps = smoothstep(0.15, 1.05, 0.55 + 1.0 * fractal_noise(seed + 20, 7.0 * stretched, 7, 0.66));
    const double fibres = std::pow(ridged_noise(seed + 30, 4.0 * stretched, 6, 0.6), 4.0);
    return 2.7 * lane * clumps + 4.5 * wide * fibres * (0.3 + clumps);
}

/// Returns the light of disc and bulge behind the dust, without single stars.
Color light(const Vec& d) {
    const double bulge = bulge_light(d), clouds = star_clouds(d);
    const double grain = 1 + 0.35 * fractal_noise(seed + 40, 90.0 * d, 2, 0.7);
    const Color disc = mix({0.66, 0.78, 1.0}, {1.0, 0.82, 0.60}, std::min(1.0, 0.25 * center_weight(d) + 1.3 * bulge));
    const Color stars = 0.46 * grain * clouds * disc + 1.1 * grain * bulge * Color{1.0, 0.80, 0.55};
    return dust_transmittance(dust_depth(d)) * stars + Color{0.0012, 0.0014, 0.0024};
}

/// Adds clouds of glowing hydrogen: small red spots in groups near the galactic plane.
void add_nebulae(Picture& sky) {
    Random random(seed + 50);
    for (int group = 0; group < 34; ++group) {
        const SkyPosition middle{75 * degree * random.normal(), 2.0 * degree * random.normal()};
        for (int i = 0; i < 7; ++i) {
            const SkyPosition position{middle.longitude + 0.8 * degree * random.normal(),
                                       middle.latitude + 0.5 * degree * random.normal()};
            add_spot(sky, position, random.between(0.15, 0.45) * degree,
                     random.between(0.01, 0.12) * Color{1.0, 0.20, 0.32});
        }
    }
}

/// Adds two small companion galaxies, similar to the Magellanic Clouds, with their stars.
void add_companions(Picture& sky) {
    Random random(seed + 60);
    const struct {
        SkyPosition position;
        double width, light;
    } companions[] = {{{-80 * degree, -33 * degree}, 2.6 * degree, 0.10},
                      {{-58 * degree, -44 * degree}, 1.5 * degree, 0.07}};
    for (const auto& one : companions) {
        add_spot(sky, one.position, one.width, one.light * Color{0.80, 0.86, 1.0});
        for (int i = 0; i < 140; ++i) {
            const SkyPosition position{one.position.longitude + 1.2 * one.width * random.normal(),
                                       one.position.latitude + 0.7 * one.width * random.normal()};
            add_spot(sky, position, random.between(0.12, 0.5) * degree,
                     random.between(0.005, 0.05) * Color{0.75, 0.84, 1.0});
        }
    }
}

/// Adds 17,000 stars, most of them in the band.
void add_stars(Picture& sky) {
    Random random(seed);
    for (int i = 0; i < 17000;) {
        const SkyPosition position{random.between(-180, 180) * degree, std::asin(random.between(-1, 1))};
        const Vec d = direction_of(position);
        const double density = 0.16 + (star_clouds(d) + bulge_light(d)) * std::exp(-dust_depth(d));
        if (random() > density) continue;
        add_star(sky, random, position, 0.028, 1.05);
        ++i;
    }
}

}  // namespace

Picture milky_way() {
    Picture sky(2048, 1024);
    for (int y = 0; y < sky.height; ++y)
        for (int x = 0; x < sky.width; ++x) sky.at(x, y) = light(direction_of(sky_position_of(sky, x, y)));
    add_nebulae(sky);
    add_companions(sky);
    add_stars(sky);
    tone_map(sky);
    return sky;
}

}  // namespace textures
