/// Rendering of the frames of an animation by all ranks.
#pragma once

#include "frames/finished_frame.h"
#include "ranks/rank_link.h"

namespace kagero {

/// Renders the frames, which must be the same on all ranks, and passes each to `write` on rank 0. Each rank renders
/// every K-th frame, where K is the number of ranks. `write` is called from several threads at once. The members
/// `write` and `journal_path` of the control are not used. For the exceptions, see JointWork::run. The report of rank 0
/// counts the frames of all ranks.
FramesReport render_frames_on_ranks(Communicator& ranks, FramePlans& plans, const std::vector<std::uint32_t>& frames,
                                    FrameControl control, const std::function<void(FinishedFrame&)>& write,
                                    LinkTimes times = {});

/// Collective: sends the numbers of the frames that are rendered from rank 0 to the other ranks, and returns them.
/// Throws InputError on a rank whose animation differs from that of rank 0.
std::vector<std::uint32_t> share_frames(Communicator& ranks, const FramePlans& plans, const Options& options,
                                        const std::vector<std::uint32_t>& frames);

}  // namespace kagero
