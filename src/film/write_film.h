/// Writes films to picture files.
#pragma once

#include "film/film.h"

namespace kagero {

/// Names and values of attributes. In an EXR file, "kagero/" is added before each name.
using Metadata = std::vector<std::pair<std::string, std::string>>;

/// Returns true if a picture with this name stores all layers and metadata. Throws InputError if its extension is not
/// that of a supported picture format.
bool stores_all_layers(const std::string& path);
/// Throws InputError if the extension of `path` is not supported, if no file can be written there, or if the format
/// cannot store the picture. `.npy` and `.pfm` store one layer; other formats than these and EXR require the layer
/// `color`, and some limit the width and height.
/// This function is called before rendering, so that no finished picture is lost.
void check_writable(const std::string& path, const std::vector<std::string>& layers, std::uint32_t width,
                    std::uint32_t height);

/// Loads the image module if write_film needs it for this path. A separate thread may call this function, because
/// loading takes some time. Throws RunError if the module cannot be loaded.
void prepare_to_write(const std::string& path);

/// Returns the file of a film in a format that encode_film supports: ".exr" or a format with 8 bits per channel, with
/// the content that write_film describes. Throws RunError if encoding fails.
std::vector<unsigned char> encode_film(const Film& film, const std::string& extension, const Metadata& metadata);

/// Writes a film to a file. `.exr` stores all layers (`layer.channel`), the position of a crop, and metadata. `.npy`
/// and `.pfm` store the floats of one layer. Other formats store only the layer `color`; formats with 8 bits per
/// channel are sRGB-encoded, with the film's tone. The file appears under its name only when it is complete. Throws
/// RunError if it cannot be written.
void write_film(const Film& film, const std::string& path, const Metadata& metadata);

}  // namespace kagero
