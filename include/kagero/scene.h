/// Scenes that are loaded once and used several times.
#pragma once

#include <kagero/picture.h>
#include <kagero/rays.h>

namespace kagero {

class ScenePlans;

/// A scene. It does not change, copies share it, and several threads may use it at once. It keeps the last few plans
/// that it has made, so that a second picture or list of rays with the same options needs no second trial, and reads
/// no mesh or image again.
class KAGERO_PUBLIC LoadedScene {
public:
    /// Returns the file, its text, and the overrides.
    const SceneSource& source() const;
    /// Returns the scene with further overrides, each "key.path=value" as with -D on the command line. Throws
    /// InputError if the result is invalid.
    LoadedScene override(const std::vector<std::string>& overrides) const;
    /// Renders the scene as render_scene does. `layers` replaces film.layers unless it is empty.
    Picture render(const RunOptions& options = {}, const std::vector<std::string>& layers = {}) const;
    /// Traces rays as trace_rays does.
    std::vector<TracedRay> trace(const std::vector<Ray>& rays, const TraceOptions& request = {},
                                 const RunOptions& options = {}) const;
    /// Returns the text of `kagero explain`: every decision with its reason.
    std::string explain(const RunOptions& options = {}) const;

private:
    explicit LoadedScene(std::shared_ptr<const ScenePlans> plans) : plans_(std::move(plans)) {}
    friend KAGERO_PUBLIC LoadedScene load(const SceneSource&);
    std::shared_ptr<const ScenePlans> plans_;
};

/// Loads a scene. Throws InputError if the file or an override is invalid. The camera is checked by `render`, because
/// `trace` needs none.
KAGERO_PUBLIC LoadedScene load(const SceneSource& source);
/// Loads a scene file and applies overrides.
inline LoadedScene load(const std::string& file, const std::vector<std::string>& overrides = {}) {
    return load(SceneSource{file, overrides});
}

}  // namespace kagero
