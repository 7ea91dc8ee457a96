/// A film's way to disk.
#pragma once

#include "film/film.h"

namespace kagero {

/// Name and value of one `kagero/*` attribute of the written file.
using Metadata = std::vector<std::pair<std::string, std::string>>;

/// Whether a picture of this name holds every layer, and metadata. Throws InputError when its extension is that of no
/// picture.
bool holds_layers(const std::string& path);
/// Throws InputError when `path` has no extension that can be written, no file can be put there, or the format cannot
/// hold so many pixels or the layers: those without layers need `color`. Called before rendering.
void check_writable(const std::string& path, const std::vector<std::string>& layers, std::uint32_t width,
                    std::uint32_t height);

/// Loads what write_film will need, which takes a moment that others may use. Throws RunError.
void prepare_to_write(const std::string& path);

/// Writes `.exr` with all layers (`layer.channel`), its place in the whole picture and metadata, other formats with the
/// color layer alone (8-bit formats sRGB-encoded). The file appears under its name only when it is complete. Throws
/// RunError.
void write_film(const Film& film, const std::string& path, const Metadata& metadata);

}  // namespace kagero
