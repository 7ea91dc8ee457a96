#include "report/csv/write_rays.h"

#include "plan/names.h"
#include "report/text/numbers.h"

#include <ostream>

namespace kagero {

namespace {

constexpr std::size_t flush_size = 1 << 16;  ///< Number of bytes that are collected before they are written.

void append_vector(std::string& row, const double (&v)[3]) {
    for (const double x : v) {
        row += ',';
        append_exact(row, x);
    }
}

void append_number(std::string& row, double x) {
    row += ',';
    append_exact(row, x);
}

std::string object_name(const Plan& plan, const RayEnd& end) {
    if (end.status != Status::hit || plan.description().objects.empty()) return "";
    return csv_text(plan.description().objects.at(end.surface).name);
}

/// Returns the header of the columns that are written only if they are requested, each after a comma.
std::string header_of_integrals(const Plan& plan) {
    return std::string(plan.run.outputs & output_action ? ",action" : "") +
           (plan.run.outputs & output_time ? ",time" : "");
}

/// Appends the columns of header_of_integrals. `Point` is RayEnd or PathPoint.
template <class Point>
void append_integrals(std::string& row, const Plan& plan, const Point& point) {
    if (plan.run.outputs & output_action) append_number(row, point.action);
    if (plan.run.outputs & output_time) append_number(row, point.time);
}

void append_path_state(std::string& row, const Plan& plan, const PathState& path) {
    row += ',' + std::to_string(path.bounces) + ',' + csv_text(name_of_medium(plan.description(), path.medium));
    append_number(row, mean_weight(path));
}

void append_point(std::string& row, const Plan& plan, const PathPoint& point, bool with_bounces) {
    row += std::to_string(point.ray) + ',' + std::to_string(point.step);
    append_number(row, point.parameter);
    append_vector(row, point.q);
    append_vector(row, point.v);
    append_vector(row, point.p);
    append_number(row, point.pt);
    append_number(row, point.energy);
    append_integrals(row, plan, point);
    if (with_bounces)
        row += ',' + std::to_string(point.segment) + ',' + csv_text(name_of_medium(plan.description(), point.medium));
    row += '\n';
}

void flush(std::ostream& out, std::string& rows) {
    out.write(rows.data(), static_cast<std::streamsize>(rows.size()));
    rows.clear();
}

}  // namespace

std::string csv_text(const std::string& text) {
    if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
    std::string quoted = "\"";
    for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
    return quoted + '"';
}

std::string reason_of(const Plan& plan, const RayEnd& end) {
    if (end.status == Status::failed) return why_failed(*plan.scene, plan.run.kernel->precision, end);
    if (end.status != Status::step_limit) return "";
    if (end.cut_off) return "bounces";
    if (end.steps >= plan.run.max_steps)
        return "the ray did not end within integrator.max_steps = " + std::to_string(plan.run.max_steps);
    return "the ray reached the value of --parameter";
}

double mean_weight(const PathState& path) { return (path.weight[0] + path.weight[1] + path.weight[2]) / 3; }

std::string header_of_ends(const Plan& plan, bool with_paths) {
    return "ray,status,object,x,y,z,dx,dy,dz,px,py,pz,pt,parameter,steps,gradients,energy_error,reason" +
           header_of_integrals(plan) + (with_paths ? ",bounces,medium,weight" : "") + '\n';
}

void append_end(std::string& row, const Plan& plan, std::size_t ray, const RayEnd& end, const PathState* path) {
    row += std::to_string(ray) + ',' + name_of(end.status) + ',' + object_name(plan, end);
    append_vector(row, end.q);
    append_vector(row, end.v);
    append_vector(row, end.p);
    append_number(row, end.pt);
    append_number(row, end.parameter);
    row += ',' + std::to_string(end.steps) + ',' + std::to_string(end.gradients);
    append_number(row, end.energy_error);
    row += ',' + csv_text(reason_of(plan, end));
    append_integrals(row, plan, end);
    if (path) append_path_state(row, plan, *path);
    row += '\n';
}

void write_ends(std::ostream& out, const Plan& plan, const std::vector<RayEnd>& ends,
                const std::vector<PathState>* paths) {
    std::string rows = header_of_ends(plan, paths != nullptr);
    for (std::size_t i = 0; i < ends.size(); ++i) {
        append_end(rows, plan, i, ends[i], paths ? &(*paths)[i] : nullptr);
        if (rows.size() > flush_size) flush(out, rows);
    }
    flush(out, rows);
}

void write_path_header(std::ostream& out, const Plan& plan, bool with_bounces) {
    out << "ray,step,parameter,x,y,z,dx,dy,dz,px,py,pz,pt,energy" << header_of_integrals(plan)
        << (with_bounces ? ",bounces,medium" : "") << '\n';
}

void write_paths(std::ostream& out, const Plan& plan, const std::vector<PathPoint>& points, bool with_bounces) {
    std::string rows;
    for (const PathPoint& point : points) {
        append_point(rows, plan, point, with_bounces);
        if (rows.size() > flush_size) flush(out, rows);
    }
    flush(out, rows);
}

}  // namespace kagero
