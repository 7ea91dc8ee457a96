/// The manifest of rendered frames: a JSON file beside them that describes each frame.
#pragma once

#include "frames/render_frames.h"
#include "report/json.h"

#include <chrono>
#include <map>

namespace kagero {

/// The description of the finished frames of one animation. Several processes can render different frames to one
/// folder: each adds its frames to the manifest there.
class Manifest {
public:
    /// Reads the manifest at `path` if there is one. If it belongs to another animation, its frames are forgotten, or,
    /// if `must_continue` is true, InputError states the first difference. Throws InputError if `must_continue` is true
    /// and the file is not a manifest.
    Manifest(std::string path, Properties identity, bool must_continue);

    /// Returns true if the manifest contains the frame, and its file has the size and checksum of the manifest.
    bool has_complete(std::uint32_t frame, const std::string& file) const;
    /// Adds the description of a frame whose file is complete, and writes the manifest, unless writing it has become
    /// slow and the last time was recent. May be called from several threads. Returns the description with the keys of
    /// the file.
    Json add(Json description, const std::string& file);
    /// Writes the frames that have been added since the manifest was written.
    void complete();

    const std::string& path() const { return path_; }

private:
    void write();

    std::string path_;
    Properties identity_;
    std::map<std::uint32_t, Json> frames_;
    std::mutex adding_;
    bool is_written_ = true;  ///< False if frames were added since the manifest was written.
    std::chrono::steady_clock::time_point next_write_{};  ///< Earliest time to write the manifest again.
};

/// Returns the description of a frame: its number, the values that were set, and the counts and times of its run. The
/// key write_s is null until the frame is written.
Json frame_json(const RenderedFrame& frame);

/// Returns the JSON of `render` with --frames: the settings of frame 0, the totals, and the description of each frame.
/// `kept` is the number of frames that an earlier run has rendered.
std::string frames_json(const Plan& first, const FramesReport& report, std::uint64_t kept, std::vector<Json> frames);

}  // namespace kagero
