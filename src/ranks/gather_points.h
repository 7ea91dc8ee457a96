/// Error studies whose points are measured by all ranks.
#pragma once

#include "ranks/rank_link.h"
#include "study/error_study.h"

#include <map>

namespace kagero {

/// Finished points of a study by their names.
using NamedPoints = std::map<std::string, PointContent>;

/// Collective: sends the finished points of a study from rank 0 to the other ranks, and returns them on all ranks.
NamedPoints share_points(Communicator& ranks, const NamedPoints& finished);

/// Runs a study on rank 0. All ranks measure the errors of its points, each rank those of some methods. Rank 0 alone
/// measures times, because times of different processes are not comparable. `finished` must be the same on all ranks.
/// Rank 0 passes new points to `keep`, one at a time. For the exceptions, see JointWork::run. The result of the other
/// ranks is empty.
ErrorStudy study_on_ranks(Communicator& ranks, const Plan& plan, StudyOptions options, const NamedPoints& finished,
                          const std::function<void(const std::string&, const PointContent&)>& keep,
                          const Progress& progress, const std::atomic<bool>* stop, LinkTimes times = {});

}  // namespace kagero
