/// Rendering of pictures of scenes.
#pragma once

#include <kagero/options.h>

#include <cstdint>
#include <memory>

namespace kagero {

class LoadedScene;

/// Summary of the layer "standard_error" over all components of the colour. Numbers that are not known are NaN.
struct StandardError {
    double rms;       ///< Root mean square.
    double max;       ///< Greatest value.
    double relative;  ///< Root mean square divided by the mean colour.
};

/// A rendered picture: layers of floats, row by row from the top, channels interleaved.
class KAGERO_PUBLIC Picture {
public:
    std::uint32_t width() const;
    std::uint32_t height() const;
    /// Returns the names of the layers; "color" is first if the scene requests it.
    std::vector<std::string> layers() const;
    /// Returns 3 for "color", 1 for other layers, and 0 for a layer that the picture does not have.
    std::uint32_t channels(const std::string& layer) const;
    /// Returns a pointer to height × width × channels floats; null for a layer that the picture does not have. Colours
    /// are linear.
    const float* pixels(const std::string& layer) const;
    const RunChoices& choices() const;
    bool interrupted() const;    ///< Returns true if some pixels were not rendered.
    std::uint64_t rays() const;  ///< Returns the number of traced rays.
    double seconds() const;      ///< Returns the time of tracing and shading.
    /// Returns the summary of the layer "standard_error", which a scene with several rays per pixel can request.
    StandardError standard_error() const;

    /// Writes an `.exr` file with all layers and the metadata of the run, or an image of the colours (`.png`, `.jpg`,
    /// `.pfm` and other formats). The file appears when it is complete. Throws InputError if the extension is not
    /// supported, and RunError if the file cannot be written.
    void write(const std::string& path) const;

    Picture(Picture&&) noexcept;
    Picture& operator=(Picture&&) noexcept;
    ~Picture();

private:
    struct Content;
    explicit Picture(std::unique_ptr<Content> content);
    friend class LoadedScene;
    std::unique_ptr<Content> content_;
};

/// Renders a scene. Every `auto` is resolved as in `kagero render`. The energy error is measured along every ray.
/// `progress` goes from 0 to 1 for the trial, if there is one, and again for the picture. `stop` ends the rendering and
/// the trial. Throws InputError if the scene or an option is invalid; InputError::location is the position in the scene
/// file. Throws RunError if the run fails, and Interrupted if it ends before there is any result, as in the trial.
KAGERO_PUBLIC Picture render_scene(const SceneSource& source, const RunOptions& options = {});

}  // namespace kagero
