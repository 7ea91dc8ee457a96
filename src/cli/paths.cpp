#include "cli/paths.h"

#include "cli/output.h"
#include "cli/verb.h"
#include "plan/names.h"
#include "render/trace.h"
#include "report/csv/write_rays.h"

#include <ostream>

namespace kagero {
namespace {

/// Rays without a single step.
class Pathless {
public:
    /// Of the rays from number `first` on.
    void count(std::size_t first, const std::vector<RayEnd>& ends, const std::vector<PathPoint>& points) {
        std::vector<bool> without(ends.size(), true);
        for (const PathPoint& point : points) without[point.ray - first] = false;
        for (std::size_t i = 0; i < ends.size(); ++i) {
            if (!without[i] || ends[i].failure == Failure::untraced) continue;
            if (count_++ == 0) first_ = first + i, end_ = ends[i];
        }
    }
    void warn(const Terminal& terminal) const {
        if (count_ == 0) return;
        terminal.warning(std::to_string(count_) + (count_ == 1 ? " ray has" : " rays have") + " no path: ray " +
                         std::to_string(first_) + (count_ == 1 ? "" : ", the first of them,") + reason());
    }

private:
    std::string reason() const {
        if (end_.status == Status::failed) return " fails where it starts: " + std::string(describe(end_.failure));
        return std::string(" is ") + name_of(end_.status) + " where it starts";
    }
    std::size_t count_ = 0, first_ = 0;
    RayEnd end_{};
};

}  // namespace

void write_paths_of(const Plan& plan, const std::vector<RayStart>& starts, const std::string& output,
                    const Watch& watch, const Terminal& terminal) {
    constexpr std::size_t at_once = 4096;
    Pathless pathless;
    write_output(output, [&](std::ostream& out) {
        write_path_header(out);
        for (std::size_t first = 0; first < starts.size() && !*watch.stop; first += at_once) {
            const auto begin = starts.begin() + std::ptrdiff_t(first),
                       end = starts.begin() + std::ptrdiff_t(std::min(first + at_once, starts.size()));
            std::vector<RayEnd> ends;
            auto points = trace_paths(plan, {begin, end}, ends, watch);
            for (PathPoint& point : points) point.ray += first;
            write_paths(out, points);
            pathless.count(first, ends, points);
        }
    });
    pathless.warn(terminal);
}

}  // namespace kagero
