/// Renders of the frames of an animation: --frames.
#pragma once

#include "cli/terminal.h"
#include "frames/frame_plans.h"
#include "ranks/communicator.h"

namespace kagero {

/// Adds --frames.
void add_frame_options(CLI::App& verb, Arguments& arguments);

/// Throws InputError if the output of a single picture is a film, or, in an animated scene, contains the place of a
/// frame's number.
void check_picture_output(const Arguments& arguments, const SceneDescription& scene);

/// Makes the plans of frames. Shows the progress of trials that take more than a second, and their warnings.
std::unique_ptr<FramePlans> frame_plans_with_progress(const SceneDescription& scene, const Options& options,
                                                      const Terminal& terminal);

/// Renders the frames of --frames to pictures or to a film, and returns the exit status. `time_limit` is that of all
/// frames, in seconds. `ranks` is null without --mpi.
int render_frames_of(const Arguments& arguments, Options options, const SceneDescription& scene, double time_limit,
                     const Terminal& terminal, Communicator* ranks);

}  // namespace kagero
