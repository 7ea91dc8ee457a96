/// Rendering of the frames of an animation.
#pragma once

#include "frames/frame_plans.h"
#include "frames/frame_range.h"
#include "parts/journals/journal.h"

#include <memory>

namespace kagero {

/// A finished frame.
struct RenderedFrame {
    std::uint32_t frame;
    Plan plan;
    Film film;
    RunReport report;
    std::unique_ptr<Journal> journal;  ///< Null unless the frame has one. The receiver removes it.
};

/// The callbacks of render_frames, and the conditions that end it.
struct FrameControl {
    /// Receives a finished frame. It is called from several threads at once, unless `in_order` is true.
    std::function<void(RenderedFrame&)> write = {};
    bool in_order = false;  ///< True: frames are written one after another, in the order of their numbers.
    /// Returns the path of the journal of a frame. Empty: frames have no journals. Frames that consist of sub-frames
    /// never have one, because their tiles are not finished before the last sub-frame.
    std::function<std::string(std::uint32_t)> journal_path = {};
    Properties identity = {};                                     ///< Identity of the animation, for journals.
    Progress progress = {};                                       ///< Receives the finished share of all frames.
    std::function<void(const std::string&)> note = {};            ///< Receives statements about journals. May be empty.
    const std::atomic<bool>* stop = nullptr;                      ///< The caller sets it to end the run; may be null.
    double time_limit = std::numeric_limits<double>::infinity();  ///< Seconds for all frames.
    unsigned in_flight = 2;                                       ///< Number of frames that are in memory at once.
};

/// The result of render_frames.
struct FramesReport {
    std::uint64_t written = 0;  ///< Number of frames that were passed to FrameControl::write.
    double seconds = 0;         ///< Time of the whole run, with loading and writing.
    bool interrupted = false;   ///< True if some frames were not finished.
    bool out_of_time = false;   ///< True if the time limit is the reason for this.
};

/// Returns the number of frames to keep in flight: more than one fills the processors while a frame is loaded, encoded
/// or nearly finished. Large films are rendered one after another.
unsigned frames_in_flight(const Plan& first);

/// Returns the identity of the journal of one frame.
Properties with_frame(Properties identity, std::uint32_t frame);

/// Renders the frames and passes each to FrameControl::write as soon as it is finished. The pixels of a frame do not
/// depend on the other frames.
FramesReport render_frames(FramePlans& plans, const std::vector<std::uint32_t>& frames, const FrameControl& control);

}  // namespace kagero
