#include "cli/paths.h"

#include "cli/output.h"
#include "cli/verb.h"
#include "plan/names.h"
#include "render/trace.h"
#include "report/csv/write_rays.h"

#include <ostream>

namespace kagero {
namespace {

/// The number of rays whose path has no point, and the index and end of the first such ray.
class RaysWithoutPath {
public:
    /// Counts such rays in one batch. `first` is the index, in the whole list, of the first ray of the batch.
    void count(std::size_t first, const std::vector<RayEnd>& ends, const std::vector<PathPoint>& points) {
        std::vector<bool> has_path(ends.size(), false);
        for (const PathPoint& point : points) has_path[point.ray - first] = true;
        for (std::size_t i = 0; i < ends.size(); ++i) {
            if (has_path[i] || ends[i].failure == Failure::untraced) continue;
            if (count_++ == 0) {
                first_ = first + i;
                end_ = ends[i];
            }
        }
    }
    void warn(const Terminal& terminal) const {
        if (count_ == 0) return;
        terminal.warning(std::to_string(count_) + (count_ == 1 ? " ray has" : " rays have") + " no path: ray " +
                         std::to_string(first_) + (count_ == 1 ? "" : ", the first of them,") + reason());
    }

private:
    std::string reason() const {
        if (end_.status == Status::failed) return " failed at its start: " + std::string(describe(end_.failure));
        return std::string(" is ") + name_of(end_.status) + " at its start";
    }
    std::size_t count_ = 0, first_ = 0;
    RayEnd end_{};
};

}  // namespace

void write_paths_of(const Plan& plan, const std::vector<RayStart>& starts, bool with_bounces, const std::string& output,
                    const RunControl& control, const Terminal& terminal) {
    // Rays whose points are in memory at once. Points at even intervals can be much more than the steps.
    const std::size_t batch_size = plan.run.path_interval > 0 ? 256 : 4096;
    if (!check_path_points(plan, starts, batch_size, control)) return;
    RaysWithoutPath without_path;
    write_output(output, [&](std::ostream& out) {
        write_path_header(out, plan, with_bounces);
        for (std::size_t first = 0; first < starts.size() && !*control.stop; first += batch_size) {
            const auto begin = starts.begin() + std::ptrdiff_t(first),
                       end = starts.begin() + std::ptrdiff_t(std::min(first + batch_size, starts.size()));
            std::vector<RayEnd> ends;
            auto points = trace_paths(plan, {begin, end}, ends, control);
            for (PathPoint& point : points) point.ray += first;
            write_paths(out, plan, points, with_bounces);
            without_path.count(first, ends, points);
        }
    });
    without_path.warn(terminal);
}

}  // namespace kagero
