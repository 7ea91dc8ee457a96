// A sky like the one seen from the Earth, in galactic coordinates: the Milky Way along the equator, its middle in the
// direction +x.
#include "textures.h"

#include <algorithm>

namespace textures {

namespace {

constexpr std::uint64_t seed = 7000;

/// Height above the galactic plane in radians, as the band wavers.
double height_above_plane(const Vec& d) {
    return std::asin(d.z) + 0.035 * fractal(seed + 1, 2.0 * d, 3);
}

/// 1 towards the middle of the galaxy, falling to a floor behind.
double towards_middle(const Vec& d) {
    const double longitude = std::atan2(d.y, d.x);
    return 0.20 + 0.80 * std::exp(-longitude * longitude / 0.9);
}

double bulge_light(const Vec& d) {
    const double longitude = std::atan2(d.y, d.x) / (9.5 * degree), latitude = std::asin(d.z) / (5.5 * degree);
    return std::exp(-std::sqrt(longitude * longitude + latitude * latitude + 0.02));
}

double star_clouds(const Vec& d) {
    const double height = std::abs(height_above_plane(d));
    const double clouds = std::max(0.05, 1 + 1.3 * fractal(seed + 10, 6.0 * d, 7, 0.62));
    const double disc = 0.95 * std::exp(-height / (4.6 * degree)) + 0.24 * std::exp(-height / (11 * degree));
    return towards_middle(d) * clouds * disc;
}

double dust_depth(const Vec& d) {
    const double height = height_above_plane(d) - 1.2 * degree * std::sin(3 * std::atan2(d.y, d.x) + 0.6);
    const double lane = std::exp(-height * height / (2.4 * degree * 2.4 * degree));
    const double wide = std::exp(-height * height / (8.0 * degree * 8.0 * degree));
    const Vec stretched{d.x, d.y, 2.6 * d.z};
    const double clumps = smooth(0.15, 1.05, 0.55 + 1.0 * fractal(seed + 20, 7.0 * stretched, 7, 0.66));
    const double fibres = std::pow(threads(seed + 30, 4.0 * stretched, 6, 0.6), 4.0);
    return 2.7 * lane * clumps + 4.5 * wide * fibres * (0.3 + clumps);
}

Color light(const Vec& d) {
    const double bulge = bulge_light(d), clouds = star_clouds(d);
    const double grain = 1 + 0.35 * fractal(seed + 40, 90.0 * d, 2, 0.7);
    const Color disc =
        mixed({0.66, 0.78, 1.0}, {1.0, 0.82, 0.60}, std::min(1.0, 0.25 * towards_middle(d) + 1.3 * bulge));
    const Color stars = 0.46 * grain * clouds * disc + 1.1 * grain * bulge * Color{1.0, 0.80, 0.55};
    return through_dust(dust_depth(d)) * stars + Color{0.0012, 0.0014, 0.0024};
}

/// Glowing hydrogen: small and red, in groups, close to the plane.
void add_nebulae(Picture& sky) {
    Random random(seed + 50);
    for (int group = 0; group < 34; ++group) {
        const Place middle{75 * degree * random.normal(), 2.0 * degree * random.normal()};
        for (int i = 0; i < 7; ++i) {
            const Place place{middle.longitude + 0.8 * degree * random.normal(),
                              middle.latitude + 0.5 * degree * random.normal()};
            add_spot(sky, place, random.between(0.15, 0.45) * degree,
                     random.between(0.01, 0.12) * Color{1.0, 0.20, 0.32});
        }
    }
}

/// Two small companions, as the Clouds of Magellan are, and their own stars.
void add_companions(Picture& sky) {
    Random random(seed + 60);
    const struct {
        Place place;
        double width, light;
    } companions[] = {{{-80 * degree, -33 * degree}, 2.6 * degree, 0.10},
                      {{-58 * degree, -44 * degree}, 1.5 * degree, 0.07}};
    for (const auto& one : companions) {
        add_spot(sky, one.place, one.width, one.light * Color{0.80, 0.86, 1.0});
        for (int i = 0; i < 140; ++i) {
            const Place place{one.place.longitude + 1.2 * one.width * random.normal(),
                              one.place.latitude + 0.7 * one.width * random.normal()};
            add_spot(sky, place, random.between(0.12, 0.5) * degree,
                     random.between(0.005, 0.05) * Color{0.75, 0.84, 1.0});
        }
    }
}

/// Most stars lie where the band is.
void add_stars(Picture& sky) {
    Random random(seed);
    for (int i = 0; i < 17000;) {
        const Place place{random.between(-180, 180) * degree, std::asin(random.between(-1, 1))};
        const Vec d = direction_of(place);
        const double density = 0.16 + (star_clouds(d) + bulge_light(d)) * std::exp(-dust_depth(d));
        if (random() > density) continue;
        add_star(sky, random, place, 0.028, 1.05);
        ++i;
    }
}

}  // namespace

Picture milky_way() {
    Picture sky(2048, 1024);
    for (int y = 0; y < sky.height; ++y)
        for (int x = 0; x < sky.width; ++x) sky.at(x, y) = light(direction_of(place_of(sky, x, y)));
    add_nebulae(sky);
    add_companions(sky);
    add_stars(sky);
    develop(sky);
    return sky;
}

}  // namespace textures
