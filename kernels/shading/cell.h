/// Shading of cells of pixels.
#pragma once

#include "kernels/shading/checker_filter.h"
#include "kernels/shading/image_filter.h"

namespace kagero::shading {

/// Computes the colours of a cell, packet by packet.
template <class V>
class CellColors {
public:
    explicit CellColors(const ShadedCell& cell)
        : cell_(cell), pixels_(cell.edge), x_(cell.x), y_(cell.y), sine_(cell.sine), cosine_(cell.cosine),
          lights_{CellFunction<V>(cell.light[0]), CellFunction<V>(cell.light[1]), CellFunction<V>(cell.light[2])} {}

    void write() const {
        for (std::uint32_t i = 0; i < pixels_.count(); i += lanes) {
            if (i / cell_.edge >= cell_.y1 || (i + lanes - 1) / cell_.edge < cell_.y0) continue;
            const CellPosition<V> at = pixels_.position(i);
            float colors[lanes][3];
            if (cell_.image.count > 0) filter_image(cell_.image, stripes(at), colors);
            else set_colors(at, colors);
            multiply_by_lights(at, colors);
            store(i, colors);
        }
    }

private:
    static constexpr int lanes = lane_count<V>;

    /// Returns the difference of a function between neighbouring pixels to the right, or down.
    V right(const CellFunction<V>& f, const CellPosition<V>& at) const { return f.by_x(at) * V(pixels_.scale()); }
    V below(const CellFunction<V>& f, const CellPosition<V>& at) const { return f.by_y(at) * V(pixels_.scale()); }

    /// Returns the stripes of an image that the pixels cover.
    Stripes<V> stripes(const CellPosition<V>& at) const {
        const V zero(0.0f), one(1.0f);
        const bool on_sphere = cell_.sphere_texel > 0;
        // Lengths in texels of the filter.
        V unit_x = one, unit_y = one;
        const V cosine = on_sphere ? max(cosine_.value(at), V(1e-6f)) : one;
        if (on_sphere) {
            unit_x = cosine * V(float(cell_.sphere_texel_x / cell_.sphere_texel));
            unit_y = V(float(cell_.sphere_texel_y / cell_.sphere_texel));
        }
        const PrincipalSides<V> sides(right(x_, at) * unit_x, right(y_, at) * unit_y, below(x_, at) * unit_x,
                                      below(y_, at) * unit_y);
        Stripes<V> stripes{V(float(cell_.base[0])), V(float(cell_.base[1])), x_.value(at), y_.value(at),
                           sides.major_x / unit_x,  sides.major_y / unit_y,  zero,         zero,
                           zero,                    one};
        const V step = max(max(sides.minor_length, sides.major_length * V(1.0f / 16)), one),
                parts = sides.major_length / step * V(1 - 1e-6f);
        stripes.level = max(log(step) * V(1.44269504f), zero);
        stripes.probes = one + select(sides.major_length > step, floor_of(parts), zero);
        if (on_sphere) bend(at, cosine, stripes);
        return stripes;
    }
    /// Sets the second derivatives of a stripe on a great circle. With the longitude a and the latitude b, these are
    /// a″ = 2 tan b a′ b′ and b″ = −sin b cos b a′². Rows are counted from the top.
    void bend(const CellPosition<V>& at, const V& cosine, Stripes<V>& stripes) const {
        const V sine = sine_.value(at), size_y(float(cell_.sphere_texel_y)),
                longitude = stripes.along_x * V(float(cell_.sphere_texel_x)), latitude = -(stripes.along_y * size_y);
        stripes.curve_x = V(2.0f) * (sine / cosine) * latitude * stripes.along_x;
        stripes.curve_y = sine * cosine * longitude * longitude * V(float(1 / cell_.sphere_texel_y));
    }
    /// Sets the colours of a checker, or of a surface without a pattern.
    void set_colors(const CellPosition<V>& at, float (&colors)[lanes][3]) const {
        V brightness(1.0f);
        if (cell_.has_checker) {
            const V half(0.5f), right_x = right(x_, at), right_y = right(y_, at), below_x = below(x_, at),
                    below_y = below(y_, at);
            brightness = checker_brightness(cell_.checker, cell_.base, x_.value(at), y_.value(at),
                                            PrincipalSides<V>(right_x, right_y, below_x, below_y),
                                            half * (abs(right_x) + abs(below_x)), half * (abs(right_y) + abs(below_y)));
        }
        float values[lanes];
        to_floats(brightness, values);
        for (int c = 0; c < 3; ++c)
            for (int i = 0; i < lanes; ++i) colors[i][c] = values[i] * float(cell_.color[c]);
    }
    void multiply_by_lights(const CellPosition<V>& at, float (&colors)[lanes][3]) const {
        float values[lanes];
        for (std::uint32_t c = 0; c < 3 && cell_.lights > 0; ++c) {
            if (c < cell_.lights) to_floats(max(lights_[c].value(at), V(0.0f)), values);
            for (int i = 0; i < lanes; ++i) colors[i][c] *= values[i];
        }
    }
    void store(std::uint32_t first, const float (&colors)[lanes][3]) const {
        for (std::uint32_t i = 0; i < lanes; ++i) {
            const std::uint32_t x = (first + i) % cell_.edge, y = (first + i) / cell_.edge;
            if (x < cell_.x0 || x >= cell_.x1 || y < cell_.y0 || y >= cell_.y1) continue;
            float* const to = cell_.colors + (y - cell_.y0) * cell_.row_length + 3 * (x - cell_.x0);
            for (int c = 0; c < 3; ++c) to[c] = colors[i][c];
        }
    }

    const ShadedCell& cell_;
    CellPixels<V> pixels_;
    CellFunction<V> x_, y_, sine_, cosine_;
    CellFunction<V> lights_[3];
};

}  // namespace kagero::shading
