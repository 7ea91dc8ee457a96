// A summer sky for a horizontal plane above the camera. The left edge, overhead, is deep blue; the right edge has the
// haze of the horizon. The texture is periodic from top to bottom.
#include "textures.h"

#include <algorithm>

namespace textures {

namespace {

constexpr std::uint64_t seed = 90;

/// Returns a point on a cylinder whose circumference is v, so that noise there is periodic in v. `fineness` is the
/// number of noise cells across the picture.
Vec on_cylinder(double u, double v, double fineness) {
    const double angle = 2 * std::numbers::pi * v, around = fineness / (2 * std::numbers::pi);
    return {fineness * u, around * std::cos(angle), around * std::sin(angle)};
}

Color sky_color(double u, double v) {
    const Color blue = mix(mix({0.055, 0.17, 0.50}, {0.22, 0.44, 0.80}, smoothstep(0, 0.45, u)), {0.70, 0.80, 0.90},
                           smoothstep(0.3, 0.95, u));
    const Vec p = on_cylinder(u, v, 9);
    const Vec bent =
        p + 0.5 * Vec{fractal_noise(seed + 1, p, 3), fractal_noise(seed + 2, p, 3), fractal_noise(seed + 3, p, 3)};
    const double cloud = smoothstep(0.08, 0.50, fractal_noise(seed + 10, bent, 7, 0.55));
    const double shade = smoothstep(-0.1, 0.6, fractal_noise(seed + 10, bent + Vec{0.25, 0.1, 0.1}, 5, 0.55));
    return mix(blue, mix({0.92, 0.93, 0.95}, {0.62, 0.66, 0.74}, shade), cloud * (1 - 0.75 * smoothstep(0.5, 1.0, u)));
}

}  // namespace

Picture clouds() {
    Picture picture(1024, 512);
    for (int y = 0; y < picture.height; ++y)
        for (int x = 0; x < picture.width; ++x)
            picture.at(x, y) = sky_color((x + 0.5) / picture.width, (y + 0.5) / picture.height);
    return picture;
}

}  // namespace textures
