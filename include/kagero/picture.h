/// Pictures of scenes.
#pragma once

#include <kagero/options.h>

#include <cstdint>
#include <memory>

namespace kagero {

/// A rendered picture: layers of floats, row by row from the top, channels interleaved.
class KAGERO_PUBLIC Picture {
public:
    std::uint32_t width() const;
    std::uint32_t height() const;
    /// The names of the layers, "color" first unless the scene leaves it out.
    std::vector<std::string> layers() const;
    /// 3 for "color", else 1; 0 for a layer that the picture does not have.
    std::uint32_t channels(const std::string& layer) const;
    /// width × height × channels floats; null for a layer that the picture does not have. Colours are linear.
    const float* pixels(const std::string& layer) const;
    const RunChoices& choices() const;
    bool interrupted() const;       ///< some pixels were never traced
    std::uint64_t rays() const;
    double seconds() const;         ///< of tracing and shading

    /// `.exr` with all layers and attributes, or an image of the colours (`.png`, `.jpg`, `.pfm` …). The file appears
    /// when it is complete. Throws InputError for an extension that cannot be written, RunError.
    void write(const std::string& path) const;

    Picture(Picture&&) noexcept;
    Picture& operator=(Picture&&) noexcept;
    ~Picture();

private:
    struct Content;
    explicit Picture(std::unique_ptr<Content> content);
    friend KAGERO_PUBLIC Picture render_scene(const SceneSource&, const RunOptions&);
    std::unique_ptr<Content> content_;
};

/// Renders a scene with every `auto` resolved as `kagero render` resolves it. Throws InputError for a scene or an
/// option that cannot be used (file, line and column in `place`), RunError, Interrupted. The error of H is measured
/// along every ray, as for an EXR of the program. `progress` runs from 0 to 1 for trial rays, if there are any, and
/// again for the picture; `stop` ends the picture, not the trial.
KAGERO_PUBLIC Picture render_scene(const SceneSource& source, const RunOptions& options = {});

}  // namespace kagero
