// The encoder of .exr files. It uses OpenEXR itself, because OpenImageIO loads many libraries that are not needed.
// The content is the one that OpenImageIO would write.
#include "film/codec.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <half.h>

#include <algorithm>
#include <cstring>
#include <thread>

namespace kagero {
namespace {

/// A stream of OpenEXR that appends to bytes in memory.
class MemoryStream final : public Imf::OStream {
public:
    explicit MemoryStream(std::vector<unsigned char>& bytes) : OStream("picture.exr"), bytes_(bytes) {}

    void write(const char* text, int count) override {
        const std::size_t end = position_ + static_cast<std::size_t>(count);
        if (end > bytes_.size()) bytes_.resize(end);
        std::memcpy(bytes_.data() + position_, text, static_cast<std::size_t>(count));
        position_ = end;
    }
    std::uint64_t tellp() override { return position_; }
    void seekp(std::uint64_t position) override { position_ = position; }

private:
    std::vector<unsigned char>& bytes_;
    std::size_t position_ = 0;
};

Imath::Box2i box_of(int x, int y, int width, int height) { return {{x, y}, {x + width - 1, y + height - 1}}; }

/// Returns true for an attribute that controls how OpenImageIO encodes, and is not stored.
bool is_instruction(const std::string& name) { return name == "compression" || name.starts_with("oiio:"); }

Imf::Header header_of(const PictureToEncode& picture) {
    const Imath::Box2i data = box_of(picture.x, picture.y, picture.width, picture.height);
    const bool is_crop = picture.whole_width > 0;
    Imf::Header header(is_crop ? box_of(0, 0, picture.whole_width, picture.whole_height) : data, data);
    header.compression() = Imf::ZIP_COMPRESSION;
    for (std::size_t i = 0; i < picture.names.size(); ++i)
        header.channels().insert(picture.names[i], Imf::Channel(picture.half[i] ? Imf::HALF : Imf::FLOAT));
    for (const auto& [name, value] : picture.attributes) {
        if (is_instruction(name)) continue;
        header.insert(name == "DateTime" ? "capDate" : name, Imf::StringAttribute(value));
    }
    return header;
}

/// The samples of one channel: 16-bit floats, or 32-bit ones.
struct Plane {
    std::vector<half> halves;
    std::vector<float> floats;
};

Plane plane_of(const PictureToEncode& picture, std::size_t channel) {
    const std::size_t pixels = std::size_t(picture.width) * std::size_t(picture.height),
                      stride = std::size_t(picture.channels);
    const float* from = static_cast<const float*>(picture.pixels) + channel;
    Plane plane;
    if (picture.half[channel]) {
        plane.halves.resize(pixels);
        for (std::size_t i = 0; i < pixels; ++i) plane.halves[i] = from[i * stride];
    } else {
        plane.floats.resize(pixels);
        for (std::size_t i = 0; i < pixels; ++i) plane.floats[i] = from[i * stride];
    }
    return plane;
}

/// Returns the place of a plane for OpenEXR, which addresses samples by their position in the whole picture.
template <class Sample>
Imf::Slice slice_of(const PictureToEncode& picture, std::vector<Sample>& samples, Imf::PixelType type) {
    return Imf::Slice::Make(type, samples.data(), {picture.x, picture.y}, picture.width, picture.height,
                            sizeof(Sample), sizeof(Sample) * std::size_t(picture.width));
}

std::string encode(const std::string&, const PictureToEncode& picture, std::vector<unsigned char>& file) try {
    std::vector<Plane> planes;
    for (std::size_t i = 0; i < picture.names.size(); ++i) planes.push_back(plane_of(picture, i));
    Imf::FrameBuffer pixels;
    for (std::size_t i = 0; i < planes.size(); ++i)
        pixels.insert(picture.names[i], picture.half[i] ? slice_of(picture, planes[i].halves, Imf::HALF)
                                                        : slice_of(picture, planes[i].floats, Imf::FLOAT));
    MemoryStream stream(file);
    const int threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    Imf::setGlobalThreadCount(threads);
    Imf::OutputFile out(stream, header_of(picture), threads);
    out.setFrameBuffer(pixels);
    out.writePixels(picture.height);
    return {};
} catch (const std::exception& error) {
    return error.what();
}

constexpr Encoder openexr_encoder{codec_abi, encode};

}  // namespace
}  // namespace kagero

extern "C" __attribute__((visibility("default"))) const kagero::Encoder* kagero_encoder() {
    return &kagero::openexr_encoder;
}
