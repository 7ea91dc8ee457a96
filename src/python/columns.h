/// The columns of the tables of `trace` as NumPy arrays.
#pragma once

#include "library/scene_plans.h"
#include "render/trace.h"

#include <pybind11/pybind11.h>

#include <memory>
#include <string>
#include <vector>

namespace kagero {

/// Returns the columns of a table of ends or of paths: the standard ones, and those that `request` adds. If `chosen` is
/// not empty, returns it. Removes "action" and "time" from request.columns and adds those that are chosen; sets the
/// outputs that the columns need. Throws InputError for an unknown name.
std::vector<std::string> choose_columns_of_ends(const std::vector<std::string>& chosen, RayRequest& request);
std::vector<std::string> choose_columns_of_paths(const std::vector<std::string>& chosen, RayRequest& request);

/// Arrays with one element per ray for the ends of rays, which are written in batches.
class EndArrays {
public:
    /// Makes the arrays of the columns `names`. The interpreter lock must be held.
    EndArrays(std::size_t rays, const std::vector<std::string>& names);
    ~EndArrays();
    /// Writes the ends of consecutive rays, of which the first has the index `first`. Several threads write. The
    /// interpreter lock is not needed.
    void write(const Plan& plan, const std::vector<RayEnd>& ends, const std::vector<PathState>& paths,
               std::size_t first);
    /// Returns a dictionary of the arrays. The interpreter lock must be held.
    pybind11::dict columns(const Plan& plan);

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Returns a dictionary of arrays with one element per ray. The interpreter lock must be held; it is released while
/// numbers are written.
pybind11::dict columns_of_ends(const Plan& plan, const std::vector<RayEnd>& ends, const std::vector<PathState>& paths,
                               const std::vector<std::string>& names);
/// Returns a dictionary of arrays with one element per point.
pybind11::dict columns_of_points(const Plan& plan, const std::vector<PathPoint>& points,
                                 const std::vector<std::string>& names);

}  // namespace kagero
