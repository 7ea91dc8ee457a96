// Tests of the positions of the rays in a pixel: they form a (0,2)-sequence, and differ between pixels and seeds.
#include "rays/sampler.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <vector>

namespace kagero {
namespace {

TEST(SamplePosition, IsTheCentreForOneSample) {
    for (std::uint32_t seed = 0; seed < 5; ++seed) {
        EXPECT_EQ(sample_position(3, 7, 0, 1, seed), (std::array<double, 2>{0.5, 0.5}));
    }
}

// In a (0,2)-sequence, the points m 2^k to (m + 1) 2^k − 1 have one point in each cell of every grid of 2^i × 2^(k−i)
// cells. `block` is m.
TEST(SamplePosition, FillsEachCellOfABinaryGridOnce) {
    for (const std::uint32_t pixel : {0u, 1u, 77u, 65535u})
        for (std::uint32_t k = 0; k <= 10; ++k)
            for (std::uint32_t block = 0; block < 2; ++block)
                for (std::uint32_t i = 0; i <= k; ++i) {
                    std::set<std::uint32_t> cells;
                    for (std::uint32_t n = block << k; n < (block + 1) << k; ++n) {
                        const auto [u, v] = sample_position(pixel, 2 * pixel, n, 4096, 12);
                        ASSERT_TRUE(u >= 0 && u < 1 && v >= 0 && v < 1);
                        const auto column = static_cast<std::uint32_t>(u * (1u << i));
                        const auto row = static_cast<std::uint32_t>(v * (1u << (k - i)));
                        cells.insert((row << i) + column);
                    }
                    ASSERT_EQ(cells.size(), std::size_t{1} << k) << "pixel " << pixel << " grid " << i << "," << k - i;
                }
}

TEST(SamplePosition, DiffersForEveryPixelAndSeed) {
    std::set<std::array<double, 2>> all;
    for (std::uint32_t y = 0; y < 16; ++y)
        for (std::uint32_t x = 0; x < 16; ++x)
            for (std::uint32_t seed = 0; seed < 4; ++seed) all.insert(sample_position(x, y, 0, 4, seed));
    EXPECT_EQ(all.size(), 16u * 16 * 4);
}

// Some layers use only the first sample of a pixel. Over all pixels, its position must be uniform. For 64 cells, χ² has
// the mean 63 and the standard deviation √126; the tolerance is 5 standard deviations.
TEST(SamplePosition, IsUniformOverPixelsForTheFirstSample) {
    std::vector<double> counts(64);
    constexpr std::uint32_t width = 128;
    for (std::uint32_t y = 0; y < width; ++y)
        for (std::uint32_t x = 0; x < width; ++x) {
            const auto [u, v] = sample_position(x, y, 0, 16, 0);
            ++counts[static_cast<std::size_t>(v * 8) * 8 + static_cast<std::size_t>(u * 8)];
        }
    const double expected = width * width / 64.0;
    double chi2 = 0;
    for (const double n : counts) chi2 += (n - expected) * (n - expected) / expected;
    EXPECT_NEAR(chi2, 63, 5 * std::sqrt(126.0));
}

}  // namespace
}  // namespace kagero
