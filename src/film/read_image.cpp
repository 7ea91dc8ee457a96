#include "film/read_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <stdexcept>

namespace kagero {

namespace {

float linear_from_srgb(float s) {
    return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f);
}

/// Linear values of the 256 sRGB values of images with eight bits per channel.
class SrgbTable {
public:
    SrgbTable() {
        for (std::size_t i = 0; i < linear_.size(); ++i) linear_[i] = linear_from_srgb(static_cast<float>(i) / 255);
    }
    /// Returns the linear value; values between those of the table are computed.
    float linear(float value) const {
        const float scaled = value * 255;
        if (!(scaled >= 0 && scaled <= 255)) return linear_from_srgb(value);
        const auto index = static_cast<std::size_t>(scaled + 0.5f);
        return std::abs(scaled - static_cast<float>(index)) < 1e-4f ? linear_[index] : linear_from_srgb(value);
    }

private:
    std::array<float, 256> linear_;
};

/// Replaces sRGB-encoded values by linear values.
void decode_srgb(float* values, std::size_t count) {
    static const SrgbTable table;
    for (std::size_t i = 0; i < count; ++i)
        if (std::isfinite(values[i])) values[i] = table.linear(values[i]);
}

/// Returns components for an image of the file's size. They are 0 until they are read.
decltype(StoredImage::rgb) components_for(const ImageFile& file) {
    const std::size_t count = 3 * static_cast<std::size_t>(file.width) * static_cast<std::size_t>(file.height);
    if (file.type == ComponentType::float32) return std::vector<float>(count);
    std::vector<float> linear = file.values_of_codes();
    if (file.is_srgb) decode_srgb(linear.data(), linear.size());
    if (file.type == ComponentType::uint8)
        return CodedComponents<std::uint8_t>{std::vector<std::uint8_t>(count), std::move(linear)};
    return CodedComponents<std::uint16_t>{std::vector<std::uint16_t>(count), std::move(linear)};
}

/// Changes the grey values in the last third of an array to RGB in the whole array.
template <class Stored>
void expand_grey(Stored* rgb, std::size_t pixels) {
    for (std::size_t i = 0; i < pixels; ++i) {
        const Stored grey = rgb[2 * pixels + i];
        std::fill_n(rgb + 3 * i, 3, grey);
    }
}

/// Returns the first index from `begin` to `end` − 1 whose component is not finite, or `end` if all are finite.
template <class Stored>
std::size_t first_not_finite(const Texels<Stored>& texels, std::size_t begin, std::size_t end) {
    while (begin < end && std::isfinite(texels[begin])) ++begin;
    return begin;
}

}  // namespace

ImageReader::ImageReader(ImageSource source, const FileLocation& location)
    : source_(std::move(source)), location_(location) {
    const std::string reason = codec().open(source_.path, source_.bytes, file_);
    if (!reason.empty()) throw InputError(location, source_.name() + " " + reason);
    image_.width = file_->width;
    image_.height = file_->height;
    const auto refuse = [&] {
        throw InputError(location, source_.name() + " states a size of " + std::to_string(file_->width) + " x " +
                                       std::to_string(file_->height) +
                                       " pixels, which requires more memory than is available");
    };
    try {
        image_.rgb = components_for(*file_);
    } catch (const std::bad_alloc&) {
        refuse();
    } catch (const std::length_error&) {
        refuse();
    }
}

void ImageReader::refuse_pixel(std::size_t index) const {
    const std::size_t pixel = index / 3, width = static_cast<std::size_t>(image_.width);
    throw InputError(location_, source_.name() + " has a value that is not finite in pixel (" +
                                    std::to_string(pixel % width) + ", " + std::to_string(pixel / width) +
                                    "), counted from the upper left; correct the image");
}

template <class Stored>
void ImageReader::read_strip(Stored* components, int end) {
    const auto width = static_cast<std::size_t>(image_.width);
    const std::size_t begin = 3 * width * static_cast<std::size_t>(rows_read_),
                      pixels = width * static_cast<std::size_t>(end - rows_read_);
    Stored* const strip = components + begin;
    const bool is_grey = file_->channels == 1;
    const std::string reason = file_->read(rows_read_, end, is_grey ? strip + 2 * pixels : strip);
    if (!reason.empty()) throw InputError(location_, source_.name() + " " + reason);
    if (is_grey) expand_grey(strip, pixels);
    if constexpr (std::is_same_v<Stored, float>)
        if (file_->is_srgb) decode_srgb(strip, 3 * pixels);
    if (file_->type == ComponentType::half || file_->type == ComponentType::float32)
        visit_texels(image_, [&](const auto& texels) {
            const std::size_t end_index = begin + 3 * pixels, index = first_not_finite(texels, begin, end_index);
            if (index < end_index) refuse_pixel(index);
        });
    rows_read_ = end;
}

void ImageReader::read_strip() {
    const int end = std::min(image_.height, rows_read_ + file_->strip_height);
    if (auto* const floats = std::get_if<0>(&image_.rgb)) read_strip(floats->data(), end);
    if (auto* const bytes = std::get_if<1>(&image_.rgb)) read_strip(bytes->codes.data(), end);
    if (auto* const words = std::get_if<2>(&image_.rgb)) read_strip(words->codes.data(), end);
}

StoredImage read_image(const ImageSource& source, const FileLocation& location) {
    ImageReader reader(source, location);
    while (!reader.is_done()) reader.read_strip();
    return reader.take_image();
}

}  // namespace kagero
