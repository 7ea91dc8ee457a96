/// Reading of image files.
#pragma once

#include "error.h"
#include "film/codec.h"
#include "film/image.h"

#include <string>

namespace kagero {

/// An image to read: a file, or bytes that another file contains.
struct ImageSource {
    std::string path;                    ///< Path of the file, or the name of the bytes for messages.
    const std::string* bytes = nullptr;  ///< Bytes of the image; null for a file.
    std::string user{};                  ///< For messages: what uses the image; empty if its location suffices.

    ImageSource(std::string p, const std::string* b = nullptr, std::string u = {})
        : path(std::move(p)), bytes(b), user(std::move(u)) {}
    /// Returns the name of the image for messages.
    std::string name() const { return '"' + path + '"' + (user.empty() ? "" : " (the image of " + user + ")"); }
};

/// Reads an image file of any format that OpenImageIO supports, in strips of rows from the top. sRGB-encoded images are
/// decoded to linear values; EXR and other float images are linear. Grey becomes RGB, and alpha is ignored. At no time
/// does memory contain a copy of the whole image in another precision.
class ImageReader {
public:
    /// Opens a file. Throws InputError at `location` if the file is missing or unreadable, or does not fit into memory.
    ImageReader(ImageSource source, const FileLocation& location);
    /// Returns the image, of which the first `rows_read` rows are complete. The addresses of its pixels do not change.
    const StoredImage& image() const { return image_; }
    int rows_read() const { return rows_read_; }
    bool is_done() const { return rows_read_ == image_.height; }
    /// Reads the next strip of rows. Throws InputError if the file is unreadable, or if a value is not finite.
    void read_strip();
    /// Returns the image, which this object does not have afterwards.
    StoredImage take_image() { return std::move(image_); }

private:
    template <class Stored>
    void read_strip(Stored* components, int end);
    /// Throws InputError with the position of a pixel that is not finite.
    [[noreturn]] void refuse_pixel(std::size_t index) const;

    ImageSource source_;
    FileLocation location_;
    std::unique_ptr<ImageFile> file_;
    StoredImage image_;
    int rows_read_ = 0;
};

/// Reads a whole image file with an ImageReader.
StoredImage read_image(const ImageSource& source, const FileLocation& location);

}  // namespace kagero
