#include "appearance/lights/sky_distribution.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kagero {
namespace {

constexpr int greatest_width = 512;  ///< Cells along a row: fine enough for a sun, small enough for the cache.

double luminance_of_texel(const Image& image, std::size_t texel) {
    const float* rgb = &image.rgb[3 * texel];
    return 0.2126 * double(rgb[0]) + 0.7152 * double(rgb[1]) + 0.0722 * double(rgb[2]);
}

/// Returns the finest copy of the image of a paint that has at most `greatest_width` columns; the coarsest if none has.
const Image& level_of(const LoadedPaint& paint) {
    const auto narrow = std::find_if(paint.coarser->begin(), paint.coarser->end(),
                                     [](const Image& image) { return image.width <= greatest_width; });
    return narrow == paint.coarser->end() ? paint.coarser->back() : *narrow;
}

/// Returns the position of a number between the sums before and after an element, and the index of that element.
std::pair<std::size_t, double> find_in_sums(const double* sums, std::size_t count, double fraction) {
    const double target = fraction * sums[count - 1];
    const auto index =
        std::min(static_cast<std::size_t>(std::upper_bound(sums, sums + count, target) - sums), count - 1);
    const double before = index == 0 ? 0 : sums[index - 1], width = sums[index] - before;
    return {index, width > 0 ? std::clamp((target - before) / width, 0.0, 1.0) : 0.5};
}

}  // namespace

std::optional<SkyDistribution> SkyDistribution::of(const LoadedSky& sky) {
    constexpr double least_contrast = 4;  // a directed ray costs as much as one in the cosine distribution
    if (!sky.paint.image || !sky.paint.coarser || sky.paint.coarser->empty()) return {};
    SkyDistribution distribution(sky);
    const double mean = distribution.mean_luminance_;
    if (!(mean > 0) || !std::isfinite(mean) || distribution.greatest_luminance_ < least_contrast * mean) return {};
    return distribution;
}

SkyDistribution::SkyDistribution(const LoadedSky& sky) : axes_(sky.axes) {
    const Image& image = level_of(sky.paint);
    width_ = static_cast<std::size_t>(image.width);
    height_ = static_cast<std::size_t>(image.height);
    std::vector<double> luminances(width_ * height_);
    for (std::size_t i = 0; i < luminances.size(); ++i) {
        luminances[i] = luminance_of_texel(image, i);
        greatest_luminance_ = std::max(greatest_luminance_, luminances[i]);
    }
    double total = 0;
    for (std::size_t row = 0; row < height_; ++row) {
        const double area = (sine_above(row) - sine_above(row + 1)) / 2 / double(width_);  // share of the sphere
        double sum = 0;
        for (std::size_t column = 0; column < width_; ++column) {
            mean_luminance_ += area * luminances[row * width_ + column];
            sum += area * widened_luminance(luminances, row, column);
            cell_sums_.push_back(sum);
        }
        row_sums_.push_back(total += sum);
    }
}

double SkyDistribution::widened_luminance(const std::vector<double>& luminances, std::size_t row,
                                          std::size_t column) const {
    constexpr double share = 0.25;
    double widened = luminances[row * width_ + column];
    for (std::size_t r = row == 0 ? 0 : row - 1; r <= std::min(row + 1, height_ - 1); ++r)
        for (const std::size_t shift : {width_ - 1, std::size_t{0}, std::size_t{1}})
            widened = std::max(widened, share * luminances[r * width_ + (column + shift) % width_]);
    return widened;
}

double SkyDistribution::sine_above(std::size_t row) const {
    return std::cos(std::numbers::pi * double(row) / double(height_));
}

Double3 SkyDistribution::direction(const std::array<double, 2>& point) const {
    const auto [row, down] = find_in_sums(row_sums_.data(), height_, point[0]);
    const auto [column, right] = find_in_sums(&cell_sums_[row * width_], width_, point[1]);
    const double sine = sine_above(row) + down * (sine_above(row + 1) - sine_above(row)),
                 cosine = std::sqrt(std::max(0.0, 1 - sine * sine)),
                 longitude = (0.5 - (double(column) + right) / double(width_)) * 2 * std::numbers::pi;
    return add(add(scaled(axes_.zero, cosine * std::cos(longitude)), scaled(axes_.east, cosine * std::sin(longitude))),
               scaled(axes_.up, sine));
}

double SkyDistribution::cell_density(std::size_t row, std::size_t column) const {
    const double* sums = &cell_sums_[row * width_];
    const double weight = sums[column] - (column == 0 ? 0 : sums[column - 1]),
                 solid_angle = (sine_above(row) - sine_above(row + 1)) * 2 * std::numbers::pi / double(width_);
    return weight / (row_sums_.back() * solid_angle);
}

double SkyDistribution::density(const Double3& direction) const {
    const auto [u, v] = sky_coordinates(direction, axes_);
    const auto cell = [](double position, std::size_t count) {
        return static_cast<std::size_t>(std::clamp(std::floor(position * double(count)), 0.0, double(count - 1)));
    };
    return cell_density(cell(1 - v, height_), cell(u - std::floor(u), width_));
}

}  // namespace kagero
