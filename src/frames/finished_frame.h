/// A finished frame without the plan that made it, so that another process can write it.
#pragma once

#include "film/write_film.h"
#include "frames/render_frames.h"
#include "report/warnings.h"

namespace kagero {

/// The picture of a frame, with all texts that its files and messages need.
struct FinishedFrame {
    std::uint32_t frame = 0;
    Film film;
    Metadata metadata;                 ///< Attributes of the picture file.
    Json description;                  ///< See frame_json.
    std::vector<std::string> remarks;  ///< Statements about the scene of the frame.
    std::vector<Warning> warnings;
    bool misses_bound = false;     ///< See misses_stated_bound.
    double rays = 0, seconds = 0;  ///< Number of rays, and the time for them.
};

/// Returns the frame without its plan. The film is moved.
FinishedFrame finish_frame(RenderedFrame& frame);

/// Returns the frame as bytes, and the frame of such bytes. Throws InputError if the bytes are too short.
std::string encode_frame(const FinishedFrame& frame);
FinishedFrame decode_frame(std::string_view bytes);

}  // namespace kagero
