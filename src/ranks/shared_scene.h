/// Distribution of a scene from rank 0 to the other ranks.
#pragma once

#include "ranks/communicator.h"
#include "scene/description.h"

namespace kagero {

/// A folder that is removed with the object.
struct TemporaryFolder {
    TemporaryFolder();
    ~TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    std::string path;
};

/// The scene as another rank has received it.
class ReceivedScene {
public:
    /// Collective: receives the scene that share_scene sends. Files that are sent are written to a temporary folder.
    explicit ReceivedScene(Communicator& ranks);

    const std::string& text() const { return text_; }
    /// Returns the path of the scene file, which need not exist on this rank. Paths in the scene are relative to it.
    const std::string& path() const { return path_; }
    /// Throws InputError if files were sent, and the scene names one of them by an absolute path.
    void check_paths(const SceneDescription& scene) const;

private:
    std::string text_, path_;
    std::unique_ptr<TemporaryFolder> folder_;  ///< Null if no files are sent.
};

/// Collective: sends the text of the scene to the other ranks, and all files that it names if `sends_files` is true.
void share_scene(Communicator& ranks, const SceneDescription& scene, bool sends_files);

}  // namespace kagero
