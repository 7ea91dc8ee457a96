/// Films: the pictures of an animation in one video file, which ffmpeg encodes.
#pragma once

#include "film/film.h"
#include "film/partial_file.h"

#include <string>
#include <vector>

#include <sys/types.h>

namespace kagero {

/// Returns true if the extension of a path is that of a video format: .mp4, .webm or .mkv.
bool is_video(const std::string& path);

/// Throws InputError if no film of pictures of this size can be written to `path`: the path is not writable, ffmpeg is
/// not installed, or the width or height is odd. A film stores the colour of blocks of 2 × 2 pixels.
void check_video(const std::string& path, const std::vector<std::string>& layers, std::uint32_t width,
                 std::uint32_t height);

/// A process of ffmpeg that encodes a film. While the object exists, SIGPIPE is ignored.
class VideoEncoder {
public:
    /// Starts ffmpeg. Throws RunError if this fails.
    VideoEncoder(const std::string& path, std::uint32_t width, std::uint32_t height, double fps);
    /// Stops ffmpeg and removes the film, unless it is complete.
    ~VideoEncoder();
    VideoEncoder(const VideoEncoder&) = delete;
    VideoEncoder& operator=(const VideoEncoder&) = delete;

    /// Appends the layer `color` of a film as the next picture. Throws RunError with the message of ffmpeg if it has
    /// ended.
    void write(const Film& film);
    /// Waits until ffmpeg has encoded all pictures. The film then appears at its path. Throws RunError if ffmpeg fails.
    void finish();

private:
    [[noreturn]] void refuse_failure();
    int wait_for_end();

    PartialFile file_;
    std::string path_;
    pid_t process_ = -1;
    int pictures_ = -1;  ///< Pipe to the standard input of ffmpeg.
    int messages_ = -1;  ///< File that contains the standard error output of ffmpeg.
    void (*previous_handler_)(int) = nullptr;
};

}  // namespace kagero
