#include "film/image.h"

#include <array>
#include <bit>
#include <cmath>
#include <limits>

namespace kagero {
namespace {

/// Returns the code of a number from 0 to 1, by the formula of sRGB (IEC 61966-2-1).
long srgb_code(double x) {
    const double encoded = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055;
    return std::lround(255.0 * encoded);
}

/// The codes of all floats from 0 to 1. The floats are divided into cells with the same exponent and the same upper
/// bits of the mantissa. Each cell is narrower than the numbers of one code, so it has at most two codes.
class SrgbCodes {
public:
    SrgbCodes() {
        for (std::size_t code = 1; code < 256; ++code) least_[code] = least_with(static_cast<long>(code));
        least_[256] = std::numeric_limits<float>::infinity();
        for (std::uint32_t i = 0; i < cells; ++i) first_[i] = static_cast<unsigned char>(srgb_code(begin_of(i)));
    }
    /// Returns the code of a number greater than 0 and less than 1.
    unsigned char operator()(float x) const {
        if (!(x >= begin_of(0))) return 0;
        const unsigned char first = first_[(std::bit_cast<std::uint32_t>(x) >> shift) - origin];
        return static_cast<unsigned char>(first + (x >= least_[first + 1u]));
    }

private:
    static constexpr std::uint32_t shift = 16, origin = (127 - 13) << 7, cells = 13 << 7;  // from 2^-13, 128 per octave

    static float begin_of(std::uint32_t cell) { return std::bit_cast<float>((cell + origin) << shift); }
    /// Returns the least float whose code is at least `code`, by bisection over the bits of floats.
    static float least_with(long code) {
        std::uint32_t below = 0, above = std::bit_cast<std::uint32_t>(1.0f);
        while (above - below > 1) {
            const std::uint32_t middle = below + (above - below) / 2;
            (srgb_code(static_cast<double>(std::bit_cast<float>(middle))) < code ? below : above) = middle;
        }
        return std::bit_cast<float>(above);
    }

    std::array<unsigned char, cells> first_{};  ///< Code of the least number of each cell.
    std::array<float, 257> least_{};            ///< Least number of each code; infinity after the last code.
};

}  // namespace

unsigned char encode_srgb(float linear) {
    static const SrgbCodes codes;
    if (!(linear > 0.0f)) return 0;  // also if `linear` is NaN
    return linear < 1.0f ? codes(linear) : 255;
}

}  // namespace kagero
