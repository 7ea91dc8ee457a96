#include "view/encoder.h"

#include "error.h"
#include "film/codec.h"
#include "film/map.h"

namespace kagero {
namespace {

EncodedPicture encode_bytes(const std::vector<unsigned char>& rgb, std::uint32_t width, std::uint32_t height,
                            bool is_moving) {
    PictureToEncode picture{static_cast<int>(width), static_cast<int>(height), 3, PictureToEncode::Samples::bytes,
                            rgb.data()};
    picture.attributes = {{"oiio:ColorSpace", "sRGB"}, {"DateTime", ""}};
    if (is_moving) {
        picture.quality = 85;
        picture.attributes.emplace_back("jpeg:subsampling", "4:2:0");
    } else {
        picture.attributes.emplace_back("png:compressionLevel", "1");
    }
    EncodedPicture encoded{is_moving ? "image/jpeg" : "image/png", {}};
    const std::string reason = encode_picture(is_moving ? ".jpg" : ".png", picture, encoded.bytes);
    if (!reason.empty()) throw RunError("encoding a picture failed: " + reason);
    return encoded;
}

}  // namespace

EncodedPicture encode_moving(const std::vector<unsigned char>& rgb, std::uint32_t width, std::uint32_t height) {
    return encode_bytes(rgb, width, height, true);
}

EncodedPicture encode_layer(const Film& film, const std::string& layer, bool is_moving) {
    const float* plane = film.plane(layer);
    const std::size_t pixels = std::size_t{film.width()} * film.height();
    if (layer == "color")
        return encode_bytes(display_bytes(plane, 3 * pixels, film.tone()), film.width(), film.height(), is_moving);
    for (const LayerInfo* info : film.layers()) {
        if (info->name != layer) continue;
        const FalseColors map = false_colors_of(plane, pixels, *info);
        EncodedPicture encoded = encode_bytes(map.rgb, film.width(), film.height(), is_moving);
        encoded.least = map.least;
        encoded.greatest = map.greatest;
        return encoded;
    }
    throw RunError("the film has no layer " + layer);
}

}  // namespace kagero
