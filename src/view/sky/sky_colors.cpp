#include "view/sky/sky_colors.h"

#include "film/image.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kagero {
namespace {

/// Returns the angle of the point (x, y), from −π to π, with an error of at most 2e-6 (a polynomial of degree 11 on
/// the octant next to an axis). It has no branches, so that the compiler can vectorize loops that call it.
inline float angle_of(float y, float x) {
    const float ax = std::abs(x), ay = std::abs(y), greater = std::max(std::max(ax, ay), 1e-30f),
                ratio = std::min(ax, ay) / greater, square = ratio * ratio;
    float angle =
        ratio *
        (0.99997726f +
         square * (-0.33262347f +
                   square * (0.19354346f + square * (-0.11643287f + square * (0.05265332f - square * 0.01172120f)))));
    const auto pi = std::numbers::pi_v<float>;
    angle = ay > ax ? pi / 2 - angle : angle;
    angle = x < 0 ? pi - angle : angle;
    return std::copysign(angle, y);
}

float dot_of(const Double3& axis, float x, float y, float z) {
    return float(axis[0]) * x + float(axis[1]) * y + float(axis[2]) * z;
}

/// Sets the coordinates of a row on the image of a sky.
void set_coordinates(SkyRow& row, const SkyAxes& axes) {
    const auto inverse_pi = std::numbers::inv_pi_v<float>;
    for (std::size_t i = 0; i < row.x.size(); ++i) {
        const float east = dot_of(axes.east, row.x[i], row.y[i], row.z[i]),
                    zero = dot_of(axes.zero, row.x[i], row.y[i], row.z[i]),
                    up = dot_of(axes.up, row.x[i], row.y[i], row.z[i]);
        row.u[i] = 0.5f - 0.5f * inverse_pi * angle_of(east, zero);
        row.v[i] = 0.5f + inverse_pi * angle_of(up, std::sqrt(east * east + zero * zero));
    }
}

/// Returns the copy of an image whose texels are nearest in size to a footprint: 0 for the image, i for coarser[i − 1].
std::size_t level_of(float texels, std::size_t levels) {
    if (!(texels > 1.41421356f)) return 0;
    return std::min(levels, std::size_t(1 + std::ilogb(texels * 0.70710678f)));
}

/// Sets the colours of those pixels of a row that reach a sky with an image.
void add_texture(const SkyRow& row, SkyEnd::Kind kind, const LoadedPaint& paint, std::vector<float>& colors) {
    const float inverse_texel = float(1 / texel_on_sphere(*paint.image));
    visit_texels(*paint.image, [&](const auto& texels) {
        for (std::size_t i = 0; i < row.kind.size(); ++i) {
            if (row.kind[i] != kind) continue;
            const std::size_t level = level_of(row.footprint[i] * inverse_texel, paint.coarser->size());
            const auto color =
                level == 0 ? texture_color(texels, row.u[i], row.v[i], repeat_along_u)
                           : texture_color(texels_of((*paint.coarser)[level - 1]), row.u[i], row.v[i], repeat_along_u);
            std::copy(color.begin(), color.end(), &colors[3 * i]);
        }
    });
}

/// Sets the colours of those pixels of a row that reach a sky without an image.
void add_paint(const SkyRow& row, SkyEnd::Kind kind, const Paint& paint, std::vector<float>& colors) {
    const auto inverse_pi = std::numbers::inv_pi_v<double>;
    const auto plain = plain_color(paint);
    for (std::size_t i = 0; i < row.kind.size(); ++i) {
        if (row.kind[i] != kind) continue;
        auto color = plain;
        if (paint.kind == Paint::Kind::checker) {
            const double height = std::numbers::pi * (row.v[i] - 0.5), size = row.footprint[i] * inverse_pi,
                         width = std::min(1.0, 0.5 * size / std::max(1e-3, std::cos(height)));
            color = checker_color(paint, row.u[i], row.v[i], {{width, 0}, {0, size}}, repeat_along_u);
        }
        std::copy(color.begin(), color.end(), &colors[3 * i]);
    }
}

}  // namespace

/// Encodes colours for a display. The curve `clip` is read from a table with half the error of 8 bits.
class SkyColors::Encoder {
public:
    explicit Encoder(const Tone& tone) : tone_(tone), factor_(float(size - 1) * float(std::exp2(tone.exposure))) {
        if (tone.curve != ToneCurve::clip) return;
        for (std::size_t i = 0; i < size; ++i) codes_.push_back(encode_srgb(float(i) / float(size - 1)));
    }
    void encode(const std::vector<float>& colors, unsigned char* rgb) const {
        if (codes_.empty()) {
            const std::vector<unsigned char> bytes = display_bytes(colors.data(), colors.size(), tone_);
            std::copy(bytes.begin(), bytes.end(), rgb);
            return;
        }
        for (std::size_t i = 0; i < colors.size(); ++i) {
            const float scaled = std::min(std::max(0.0f, colors[i] * factor_), float(size - 1));
            rgb[i] = codes_[std::size_t(scaled + 0.5f)];
        }
    }

private:
    static constexpr std::size_t size = 1 << 14;
    Tone tone_;
    float factor_;
    std::vector<unsigned char> codes_;
};

SkyColors::SkyColors(const Plan& plan)
    : plan_(plan), encoder_(std::make_unique<const Encoder>(plan.description().film.tone)) {}

SkyColors::~SkyColors() = default;

void SkyColors::add_colors(SkyRow& row, bool on_second_sheet, std::vector<float>& colors) const {
    const SkyEnd::Kind kind = on_second_sheet ? SkyEnd::Kind::second_sky : SkyEnd::Kind::first_sky;
    if (std::find(row.kind.begin(), row.kind.end(), kind) == row.kind.end()) return;
    const LoadedSky& sky = plan_.scene->paints->sky(on_second_sheet);
    if (has_pattern(sky.paint)) set_coordinates(row, sky.axes);
    if (sky.paint.image) add_texture(row, kind, sky.paint, colors);
    else add_paint(row, kind, sky.paint.paint, colors);
}

void SkyColors::shade(SkyRow& row, unsigned char* rgb) const {
    std::vector<float> colors(3 * row.kind.size());
    for (const bool on_second_sheet : {false, true}) add_colors(row, on_second_sheet, colors);
    encoder_->encode(colors, rgb);
}

}  // namespace kagero
