/// Means of images over stripes, for a packet of pixels.
#pragma once

#include "kernels/shading/cell_function.h"
#include "kernels/simd/integers.h"

namespace kagero::shading {

/// Stripes on an image, one in each lane; see src/appearance/pyramid.h. Lengths are in texels of level 0.
template <class V>
struct Stripes {
    V base_x, base_y;    ///< Integers.
    V x, y;              ///< Middle of the stripe minus `base`.
    V along_x, along_y;  ///< Long axis.
    V curve_x, curve_y;  ///< Second derivative of the position with respect to the fraction of the long axis.
    V level, probes;     ///< As in Probes.
};

/// The level of an image that each lane reads, with the conversion of positions from level 0.
template <class V>
struct LaneLevels {
    static constexpr int lanes = lane_count<V>;
    const void* texels[lanes];
    std::int32_t row[lanes];  ///< Number of components of a row.
    V width, height;
    V scale_x, scale_y, offset_x, offset_y;  ///< The position in the level is scale · position + offset,
    V whole_x, whole_y;                      ///< plus these integers.

    /// `index` contains the level of each lane.
    LaneLevels(const ImageLevels& image, const Stripes<V>& stripes, const std::int32_t (&index)[lanes]) {
        double sizes[2][lanes];
        for (int i = 0; i < lanes; ++i) {
            const ImageLevel& level = image.levels[index[i]];
            texels[i] = level.texels;
            row[i] = 3 * level.width;
            sizes[0][i] = level.width;
            sizes[1][i] = level.height;
        }
        width = lanes_of<V>(sizes[0]);
        height = lanes_of<V>(sizes[1]);
        scale_x = width * V(1 / float(image.levels[0].width));
        scale_y = height * V(1 / float(image.levels[0].height));
        // Positions count from the middle of the first texel. In level 0, integers remain separate, so that they cost
        // no precision.
        const V zero(0.0f), half(0.5f);
        const auto is_image_x = width >= V(float(image.levels[0].width)),
                   is_image_y = height >= V(float(image.levels[0].height));
        const auto is_image = is_image_x & is_image_y;
        offset_x = select(is_image, zero, fms(stripes.base_x + half, scale_x, half));
        offset_y = select(is_image, zero, fms(stripes.base_y + half, scale_y, half));
        whole_x = select(is_image, stripes.base_x, zero);
        whole_y = select(is_image, stripes.base_y, zero);
        scale_x = select(is_image, V(1.0f), scale_x);
        scale_y = select(is_image, V(1.0f), scale_y);
    }
};

/// Indices of the columns or rows next to a position, and the weight of the second one.
template <class V>
struct Adjacent {
    std::int32_t first[lane_count<V>], second[lane_count<V>];
    float weight[lane_count<V>];

    /// Sets the members for the position `whole` + `part` in a row or column with `size` texels.
    void set(const V& whole, const V& part, const V& size, bool repeats) {
        const V below = floor_of(part);
        to_floats(part - below, weight);
        to_integers(inside(whole + below, size, repeats), first);
        to_integers(inside(whole + below + V(1.0f), size, repeats), second);
    }

private:
    static V inside(const V& index, const V& size, bool repeats) {
        const V zero(0.0f), last = size - V(1.0f);
        if (!any(!((index >= zero) & (index <= last)))) return index;
        const V wrapped = repeats ? fnma(floor_of(index / size), size, index) : index;
        return min(max(wrapped, zero), last);
    }
};

/// Adds `weight` times the bilinear interpolation of a level in one lane.
template <class Texel, class V>
KAGERO_INLINE void add_texels(const Texel* texels, std::int32_t row, const float* linear, const Adjacent<V>& columns,
                              const Adjacent<V>& rows, int lane, float weight, float (&sum)[3]) {
    const auto at = [&](std::int32_t r, std::int32_t c) { return texels + (std::ptrdiff_t{r} * row + 3 * c); };
    const Texel* const corners[4] = {at(rows.first[lane], columns.first[lane]),
                                     at(rows.first[lane], columns.second[lane]),
                                     at(rows.second[lane], columns.first[lane]),
                                     at(rows.second[lane], columns.second[lane])};
    const float right = weight * columns.weight[lane], left = weight - right, down = rows.weight[lane],
                lower_right = right * down, lower_left = left * down;
    const float weights[4] = {left - lower_left, right - lower_right, lower_left, lower_right};
    float local[3] = {sum[0], sum[1], sum[2]};  // remains in registers, because nothing else refers to it
    for (int k = 0; k < 4; ++k)
        for (int c = 0; c < 3; ++c) {
            if constexpr (std::is_same_v<Texel, float>) local[c] = fma(weights[k], corners[k][c], local[c]);
            else local[c] = fma(weights[k], linear[corners[k][c]], local[c]);
        }
    for (int c = 0; c < 3; ++c) sum[c] = local[c];
}

/// The levels that the lanes read: a finer one, and the next one with its weight.
template <class V>
struct LevelChoice {
    static constexpr int lanes = lane_count<V>;
    std::int32_t fine[lanes], next[lanes], probes[lanes];
    float next_weight[lanes];
    std::int32_t max_probes = 1;
    bool reads_next = false;

    LevelChoice(const ImageLevels& image, const Stripes<V>& stripes) {
        const V last(float(image.count - 1));
        const V level = min(max(stripes.level, V(0.0f)), last), whole = floor_of(level);
        to_integers(whole, fine);
        to_integers(min(whole + V(1.0f), last), next);
        to_integers(stripes.probes, probes);
        to_floats(level - whole, next_weight);
        for (int i = 0; i < lanes; ++i) {
            max_probes = probes[i] > max_probes ? probes[i] : max_probes;
            reads_next |= next_weight[i] > 0;
        }
    }
};

/// Sets `colors` to the mean colours of an image over stripes. `Texel` is the type of the components of level 0.
template <class Texel, class V>
void filter_image(const ImageLevels& image, const Stripes<V>& stripes, float (&colors)[lane_count<V>][3]) {
    constexpr int lanes = lane_count<V>;
    const LevelChoice<V> choice(image, stripes);
    const LaneLevels<V> fine(image, stripes, choice.fine), next(image, stripes, choice.next);
    const V spacing = V(1.0f) / stripes.probes;
    float share[lanes];
    to_floats(spacing, share);
    for (auto& color : colors) color[0] = color[1] = color[2] = 0;
    for (std::int32_t probe = 0; probe < choice.max_probes; ++probe) {
        const V t = fms(V(float(probe) + 0.5f), spacing, V(0.5f)), half_t = V(0.5f) * t;
        const V x = fma(t, fma(half_t, stripes.curve_x, stripes.along_x), stripes.x),
                y = fma(t, fma(half_t, stripes.curve_y, stripes.along_y), stripes.y);
        Adjacent<V> columns, rows;
        columns.set(fine.whole_x, fma(x, fine.scale_x, fine.offset_x), fine.width, image.repeats_x);
        rows.set(fine.whole_y, fma(y, fine.scale_y, fine.offset_y), fine.height, image.repeats_y);
        for (int i = 0; i < lanes; ++i) {
            if (probe >= choice.probes[i]) continue;
            const float weight = share[i] * (1 - choice.next_weight[i]);
            if (choice.fine[i] == 0)
                add_texels(static_cast<const Texel*>(fine.texels[i]), fine.row[i], image.linear, columns, rows, i,
                           weight, colors[i]);
            else
                add_texels(static_cast<const float*>(fine.texels[i]), fine.row[i], image.linear, columns, rows, i,
                           weight, colors[i]);
        }
        if (!choice.reads_next) continue;
        columns.set(next.whole_x, fma(x, next.scale_x, next.offset_x), next.width, image.repeats_x);
        rows.set(next.whole_y, fma(y, next.scale_y, next.offset_y), next.height, image.repeats_y);
        for (int i = 0; i < lanes; ++i)
            if (probe < choice.probes[i] && choice.next_weight[i] > 0)
                add_texels(static_cast<const float*>(next.texels[i]), next.row[i], image.linear, columns, rows, i,
                           share[i] * choice.next_weight[i], colors[i]);
    }
}

template <class V>
void filter_image(const ImageLevels& image, const Stripes<V>& stripes, float (&colors)[lane_count<V>][3]) {
    switch (image.components) {
        case ImageLevels::Components::floats: return filter_image<float>(image, stripes, colors);
        case ImageLevels::Components::bytes: return filter_image<std::uint8_t>(image, stripes, colors);
        case ImageLevels::Components::words: return filter_image<std::uint16_t>(image, stripes, colors);
    }
}

}  // namespace kagero::shading
