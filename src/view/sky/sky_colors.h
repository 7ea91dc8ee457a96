/// Colours of the sky for rows of pixels, with one lookup per pixel.
#pragma once

#include "view/sky/sky_ends.h"

#include <memory>

namespace kagero {

/// Where the rays of a row of pixels reach the sky.
struct SkyRow {
    std::vector<float> x, y, z;      ///< Direction on the sky; its length does not matter.
    std::vector<float> footprint;    ///< Size of the pixel on the sky, in radians.
    std::vector<SkyEnd::Kind> kind;  ///< Pixels that reach no sky are black.

    void resize(std::size_t count) {
        for (auto* numbers : {&x, &y, &z, &footprint, &u, &v}) numbers->resize(count);
        kind.resize(count);
    }
    void set(std::size_t i, const std::array<float, 3>& direction, float size, SkyEnd::Kind end) {
        x[i] = direction[0];
        y[i] = direction[1];
        z[i] = direction[2];
        footprint[i] = size;
        kind[i] = end;
    }

    std::vector<float> u, v;  ///< Scratch memory: coordinates on the image of the sky.
};

/// The skies of a scene and the tone of its film.
class SkyColors {
public:
    explicit SkyColors(const Plan& plan);
    ~SkyColors();
    /// Writes the 8-bit sRGB colours of a row to `rgb`, three bytes for each pixel.
    void shade(SkyRow& row, unsigned char* rgb) const;

private:
    class Encoder;
    void add_colors(SkyRow& row, bool on_second_sheet, std::vector<float>& colors) const;

    const Plan& plan_;
    std::unique_ptr<const Encoder> encoder_;
};

}  // namespace kagero
