#include "python/columns.h"

#include "error.h"
#include "plan/names.h"
#include "python/arrays.h"
#include "render/threads.h"
#include "report/csv/write_rays.h"
#include "scene/reader.h"

#include <algorithm>
#include <atomic>
#include <functional>
#include <map>

namespace py = pybind11;

namespace kagero {
namespace {

/// A row of the table of ends.
struct EndRow {
    const RayEnd& end;
    const PathState& path;
    std::size_t index;
};

/// A column of numbers: its name, and the number of a row. The type of the number is that of the array.
template <class Row, class Number>
struct NumberColumn {
    const char* name;
    Number (*number)(const Row&);
};

// Columns of the table of ends.
constexpr NumberColumn<EndRow, double> doubles_of_ends[] = {
    {"x", [](const EndRow& row) { return row.end.q[0]; }},
    {"y", [](const EndRow& row) { return row.end.q[1]; }},
    {"z", [](const EndRow& row) { return row.end.q[2]; }},
    {"dx", [](const EndRow& row) { return row.end.v[0]; }},
    {"dy", [](const EndRow& row) { return row.end.v[1]; }},
    {"dz", [](const EndRow& row) { return row.end.v[2]; }},
    {"px", [](const EndRow& row) { return row.end.p[0]; }},
    {"py", [](const EndRow& row) { return row.end.p[1]; }},
    {"pz", [](const EndRow& row) { return row.end.p[2]; }},
    {"pt", [](const EndRow& row) { return row.end.pt; }},
    {"parameter", [](const EndRow& row) { return row.end.parameter; }},
    {"energy_error", [](const EndRow& row) { return row.end.energy_error; }},
    {"action", [](const EndRow& row) { return row.end.action; }},
    {"time", [](const EndRow& row) { return row.end.time; }},
    {"weight", [](const EndRow& row) { return mean_weight(row.path); }},
};
constexpr NumberColumn<EndRow, std::int64_t> counts_of_ends[] = {
    {"ray", [](const EndRow& row) { return std::int64_t(row.index); }},
    {"steps", [](const EndRow& row) { return std::int64_t(row.end.steps); }},
    {"gradients", [](const EndRow& row) { return std::int64_t(row.end.gradients); }},
    {"bounces", [](const EndRow& row) { return std::int64_t(row.path.bounces); }},
};
constexpr NumberColumn<EndRow, std::uint8_t> codes_of_ends[] = {
    {"status", [](const EndRow& row) { return std::uint8_t(row.end.status); }},
};

// Columns of the table of paths.
constexpr NumberColumn<PathPoint, double> doubles_of_points[] = {
    {"parameter", [](const PathPoint& point) { return point.parameter; }},
    {"x", [](const PathPoint& point) { return point.q[0]; }},
    {"y", [](const PathPoint& point) { return point.q[1]; }},
    {"z", [](const PathPoint& point) { return point.q[2]; }},
    {"dx", [](const PathPoint& point) { return point.v[0]; }},
    {"dy", [](const PathPoint& point) { return point.v[1]; }},
    {"dz", [](const PathPoint& point) { return point.v[2]; }},
    {"px", [](const PathPoint& point) { return point.p[0]; }},
    {"py", [](const PathPoint& point) { return point.p[1]; }},
    {"pz", [](const PathPoint& point) { return point.p[2]; }},
    {"pt", [](const PathPoint& point) { return point.pt; }},
    {"energy", [](const PathPoint& point) { return point.energy; }},
    {"action", [](const PathPoint& point) { return point.action; }},
    {"time", [](const PathPoint& point) { return point.time; }},
};
constexpr NumberColumn<PathPoint, std::int64_t> counts_of_points[] = {
    {"ray", [](const PathPoint& point) { return std::int64_t(point.ray); }},
    {"step", [](const PathPoint& point) { return std::int64_t(point.step); }},
    {"bounces", [](const PathPoint& point) { return std::int64_t(point.segment); }},
};

// The order of the columns in the CSV.
const std::vector<std::string> names_of_ends{"ray",   "status",    "object",       "x",     "y",  "z",  "dx",
                                             "dy",    "dz",        "px",           "py",    "pz", "pt", "parameter",
                                             "steps", "gradients", "energy_error", "reason"};
const std::vector<std::string> names_of_points{"ray", "step", "parameter", "x",  "y",  "z",  "dx",
                                               "dy",  "dz",   "px",        "py", "pz", "pt", "energy"};

bool contains(const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

/// Returns the chosen columns, or the standard ones and those that `request` adds. `of_bounces` are the columns of rays
/// that continue at surfaces.
std::vector<std::string> choose(const std::vector<std::string>& chosen, const std::vector<std::string>& standard,
                                const std::vector<std::string>& of_bounces, RayRequest& request) {
    std::vector<std::string> known = standard, names = standard;
    for (const auto* more : {&integral_names(), &of_bounces}) known.insert(known.end(), more->begin(), more->end());
    if (request.bounces) names.insert(names.end(), of_bounces.begin(), of_bounces.end());
    if (!chosen.empty()) names = chosen;
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (!contains(known, names[i]))
            throw InputError("columns: unknown column \"" + names[i] + "\"" + suggestion(names[i], known));
        if (std::count(names.begin(), names.begin() + std::ptrdiff_t(i), names[i]))
            throw InputError("columns: \"" + names[i] + "\" is listed twice");
    }
    request.columns.clear();
    for (const std::string& integral : integral_names())
        if (contains(names, integral)) request.columns.push_back(integral);
    return names;
}

/// The rows of the table of ends, or of a part of it.
struct EndTable {
    using Row = EndRow;
    const std::vector<RayEnd>& ends;
    const std::vector<PathState>& paths;  ///< Empty if no ray can continue at a surface.
    std::size_t first = 0;                ///< Index of the first row in the arrays.

    std::size_t size() const { return ends.size(); }
    EndRow operator[](std::size_t i) const {
        static const PathState without_bounces;
        return {ends[i], paths.empty() ? without_bounces : paths[i], first + i};
    }
};

/// Arrays for the chosen columns of a table, and the functions that write their elements.
template <class Table>
class Columns {
public:
    Columns(std::size_t size, const std::vector<std::string>& names) : size_(size), names_(names) {}

    /// Makes the arrays of the chosen columns among `known`.
    template <class Number, std::size_t count>
    void add(const NumberColumn<typename Table::Row, Number> (&known)[count]) {
        for (const auto& column : known) {
            if (!contains(names_, column.name)) continue;
            py::array_t<Number> array(static_cast<py::ssize_t>(size_));
            arrays_[column.name] = array;
            writers_.push_back([number = column.number, to = array.mutable_data()](const Table& table, auto begin,
                                                                                   auto end) {
                for (std::size_t i = begin; i < end; ++i) to[table.first + i] = number(table[i]);
            });
        }
    }
    /// Adds a column of texts if it is chosen. index(row) is the index of the text of a row.
    template <class Index>
    void add_texts(const std::string& name, const Index& index) {
        if (!contains(names_, name)) return;
        std::vector<std::uint32_t>& indices = indices_[name];
        indices.resize(size_);
        writers_.push_back([index, to = indices.data()](const Table& table, auto begin, auto end) {
            for (std::size_t i = begin; i < end; ++i) to[table.first + i] = index(table[i]);
        });
    }
    /// Returns the indices of a column of texts, one for each row; nullptr if the column is not chosen.
    std::uint32_t* indices(const std::string& name) {
        const auto found = indices_.find(name);
        return found == indices_.end() ? nullptr : found->second.data();
    }
    /// Writes the rows of a table: numbers and indices, with several threads. The interpreter lock is not needed.
    void write(const Table& table, unsigned threads) const {
        constexpr std::size_t block = 1024;  // rows whose ends stay in the cache while all columns are written
        const std::size_t blocks = (table.size() + block - 1) / block;
        std::atomic<std::size_t> next = 0;
        run_on_threads(static_cast<unsigned>(std::clamp<std::size_t>(blocks / 16, 1, threads)), [&](unsigned) {
            for (std::size_t i = next++; i < blocks; i = next++)
                for (const auto& writer : writers_) writer(table, i * block, std::min((i + 1) * block, table.size()));
        });
    }
    /// Makes the array of a column of texts, if it is chosen.
    void make_texts(const std::string& name, const std::vector<std::string>& texts) {
        if (contains(names_, name)) arrays_[name] = text_array(texts, indices_.at(name));
    }
    /// Returns the columns in their order.
    py::dict dict() const {
        py::dict columns;
        for (const std::string& name : names_) columns[py::str(name)] = arrays_.at(name);
        return columns;
    }

private:
    const std::size_t size_;
    const std::vector<std::string> names_;
    std::map<std::string, py::object> arrays_;
    std::map<std::string, std::vector<std::uint32_t>> indices_;  ///< Those of the columns of texts.
    std::vector<std::function<void(const Table&, std::size_t, std::size_t)>> writers_;
};

/// The rows of the table of paths.
struct PointTable {
    using Row = PathPoint;
    const std::vector<PathPoint>& points;
    static constexpr std::size_t first = 0;
    std::size_t size() const { return points.size(); }
    const PathPoint& operator[](std::size_t i) const { return points[i]; }
};

std::vector<std::string> names_of_media_with_space(const SceneDescription& scene) {
    std::vector<std::string> names;
    for (std::uint32_t i = 0; i <= scene.media.size(); ++i) names.push_back(name_of_medium(scene, i));
    return names;
}

/// The texts of the column `reason`. Equal reasons share one text.
struct Reasons {
    std::vector<std::string> texts{""};
    std::map<std::string, std::uint32_t> index_of;

    /// Replaces the indices of rows with a reason, which are 1, by those of their texts.
    void find(const Plan& plan, const std::vector<RayEnd>& ends, std::uint32_t* indices) {
        for (std::size_t i = 0; i < ends.size(); ++i) {
            if (indices[i] == 0) continue;
            const std::string reason = reason_of(plan, ends[i]);
            const auto [found, is_new] = index_of.emplace(reason, std::uint32_t(texts.size()));
            if (is_new) texts.push_back(reason);
            indices[i] = found->second;
        }
    }
};

}  // namespace

struct EndArrays::State {
    Columns<EndTable> columns;
    Reasons reasons;
};

EndArrays::EndArrays(std::size_t rays, const std::vector<std::string>& names)
    : state_(new State{{rays, names}, {}}) {
    Columns<EndTable>& columns = state_->columns;
    columns.add(doubles_of_ends);
    columns.add(counts_of_ends);
    columns.add(codes_of_ends);
    columns.add_texts("object",
                      [](const EndRow& row) { return row.end.status == Status::hit ? row.end.surface + 1 : 0; });
    columns.add_texts("medium", [](const EndRow& row) { return row.path.medium; });
    columns.add_texts("reason", [](const EndRow& row) {
        return std::uint32_t(row.end.status == Status::failed || row.end.status == Status::step_limit);
    });
}

EndArrays::~EndArrays() = default;

void EndArrays::write(const Plan& plan, const std::vector<RayEnd>& ends, const std::vector<PathState>& paths,
                      std::size_t first) {
    state_->columns.write({ends, paths, first}, plan.run.threads);
    if (std::uint32_t* const indices = state_->columns.indices("reason"))
        state_->reasons.find(plan, ends, indices + first);
}

py::dict EndArrays::columns(const Plan& plan) {
    std::vector<std::string> objects{""};
    for (const ObjectDescription& object : plan.description().objects) objects.push_back(object.name);
    state_->columns.make_texts("object", objects);
    state_->columns.make_texts("medium", names_of_media_with_space(plan.description()));
    state_->columns.make_texts("reason", state_->reasons.texts);
    return state_->columns.dict();
}

std::vector<std::string> choose_columns_of_ends(const std::vector<std::string>& chosen, RayRequest& request) {
    const auto names = choose(chosen, names_of_ends, {"bounces", "medium", "weight"}, request);
    request.energy_error = contains(names, "energy_error");
    request.end_parameter = contains(names, "parameter");
    return names;
}

std::vector<std::string> choose_columns_of_paths(const std::vector<std::string>& chosen, RayRequest& request) {
    return choose(chosen, names_of_points, {"bounces", "medium"}, request);
}

py::dict columns_of_ends(const Plan& plan, const std::vector<RayEnd>& ends, const std::vector<PathState>& paths,
                         const std::vector<std::string>& names) {
    EndArrays arrays(ends.size(), names);
    {
        const py::gil_scoped_release release;
        arrays.write(plan, ends, paths, 0);
    }
    return arrays.columns(plan);
}

py::dict columns_of_points(const Plan& plan, const std::vector<PathPoint>& points,
                           const std::vector<std::string>& names) {
    Columns<PointTable> columns(points.size(), names);
    columns.add(doubles_of_points);
    columns.add(counts_of_points);
    columns.add_texts("medium", [](const PathPoint& point) { return point.medium; });
    {
        const py::gil_scoped_release release;
        columns.write({points}, plan.run.threads);
    }
    columns.make_texts("medium", names_of_media_with_space(plan.description()));
    return columns.dict();
}

}  // namespace kagero
