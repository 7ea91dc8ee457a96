#include "adaptive/ray_nodes.h"

#include <algorithm>

namespace kagero {

void RayNodes::begin(const Plan& plan, const Job& job, std::uint32_t x0, std::uint32_t y0, std::uint32_t edge) {
    plan_ = &plan;
    job_ = job;
    x0_ = x0;
    y0_ = y0;
    edge_ = edge;
    index_.assign(std::size_t{edge + 1} * (edge + 1), is_absent);
    ends_.clear();
    for (Requests* requests : {&without_path_, &with_path_}) {
        requests->rays.starts.clear();
        requests->places.clear();
    }
    vertices_.clear();
    first_vertex_.assign(1, 0);
    const double turn = std::min(2 * pixel_size(plan.description(), 1), 0.01);
    cosine_of_turn_ = 1 - 0.5 * turn * turn;
}

void RayNodes::add(NodePosition at, Requests& requests) {
    index_[place(at)] = is_requested;
    requests.rays.starts.push_back(camera_ray_start(*plan_, x0_ + at.x + 0.5, y0_ + at.y + 0.5));
    requests.places.push_back(place(at));
}

void RayNodes::request(NodePosition at) {
    if (index_[place(at)] == is_absent) add(at, without_path_);
}

void RayNodes::request_with_path(NodePosition at) {
    const std::uint32_t index = index_[place(at)];
    if (index == is_absent || (index != is_requested && path(at).empty())) add(at, with_path_);
}

void RayNodes::trace(Requests& requests, const Job& job, Counters& counters) {
    trace_tile(*plan_->run.kernel, job, {}, requests.rays, new_ends_, counters);
    for (std::size_t i = 0; i < new_ends_.size(); ++i)
        index_[requests.places[i]] = static_cast<std::uint32_t>(ends_.size() + i);
    ends_.insert(ends_.end(), new_ends_.begin(), new_ends_.end());
    requests.rays.starts.clear();
    requests.places.clear();
}

void RayNodes::trace(Counters& counters) {
    if (!with_path_.places.empty()) trace_paths(counters);
    if (without_path_.places.empty()) return;
    trace(without_path_, job_, counters);
    first_vertex_.resize(ends_.size() + 1, vertices_.size());
}

void RayNodes::trace_paths(Counters& counters) {
    const std::size_t first_ray = ends_.size(), rays = with_path_.places.size();
    Job job = job_;
    job.path_interval = 0;
    job.path_user = this;
    job.path_sink = [](void* user, const PathPoint* point) { static_cast<RayNodes*>(user)->report(*point); };
    reported_.clear();
    last_points_.assign(rays, {});
    last_directions_.resize(rays);
    trace(with_path_, job, counters);
    add_vertices(first_ray);
}

/// Adds a point to the path of its ray. It becomes a vertex if it is the first one, or if the direction has changed by
/// more than two pixels since the last vertex. Between vertices, the path is then within a quarter of a pixel of the
/// Hermite curve.
void RayNodes::report(const PathPoint& point) {
    PathVertex& last = last_points_[point.ray];
    last = {{point.q[0], point.q[1], point.q[2]}, {point.v[0], point.v[1], point.v[2]}, 0};
    Double3& direction = last_directions_[point.ray];
    if (point.step != 0 && dot(direction, last.direction) > cosine_of_turn_) return;
    direction = last.direction;
    reported_.push_back({point.ray, last});
}

/// Sorts the reported vertices by their rays, and adds the last point of each ray. The vertices of one ray are reported
/// in their order on the path.
void RayNodes::add_vertices(std::size_t first_ray) {
    const std::size_t rays = last_points_.size();
    next_vertex_.assign(rays + 1, 1);
    next_vertex_[0] = vertices_.size();
    for (const ReportedVertex& reported : reported_) ++next_vertex_[reported.ray + 1];
    for (std::size_t i = 0; i < rays; ++i) {
        next_vertex_[i + 1] += next_vertex_[i];
        first_vertex_.push_back(next_vertex_[i + 1]);
    }
    vertices_.resize(next_vertex_[rays]);
    const auto add_vertex = [&](std::size_t ray, const PathVertex& point) {
        const std::size_t i = next_vertex_[ray]++;
        PathVertex& vertex = vertices_[i] = point;
        if (i > first_vertex_[first_ray + ray])
            vertex.length = vertices_[i - 1].length + length(subtract(vertex.position, vertices_[i - 1].position));
    };
    for (const ReportedVertex& reported : reported_) add_vertex(reported.ray, reported.vertex);
    for (std::size_t ray = 0; ray < rays; ++ray) add_vertex(ray, last_points_[ray]);
}

std::span<const PathVertex> RayNodes::path(NodePosition at) const {
    const std::size_t ray = index_[place(at)];
    return std::span(vertices_).subspan(first_vertex_[ray], first_vertex_[ray + 1] - first_vertex_[ray]);
}

}  // namespace kagero
