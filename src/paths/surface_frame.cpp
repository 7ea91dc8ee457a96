#include "paths/surface_frame.h"

#include "geometry/shapes.h"
#include "scene/vector3.h"
#include "spaces/charts.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

/// Returns the solution c of Σ_b columns[b] c_b = n, by Cramer's rule.
Double3 solve_columns(const std::array<Double3, 3>& columns, const Double3& n) {
    const auto& [a, b, c] = columns;
    const double inverse = 1 / dot(a, cross(b, c));
    return {inverse * dot(n, cross(b, c)), inverse * dot(a, cross(n, c)), inverse * dot(a, cross(b, n))};
}

/// Returns the components, in the axes E_b of a rest frame, of the conormal (n, 0) of a surface that is at rest in the
/// frame. The columns of the map are the covectors E_b. They span all covectors that vanish on the 4-velocity, and the
/// conormal is one of these.
Double3 normal_in_frame(const StartMap& map, const Double3& n) {
    std::array<Double3, 3> columns;
    for (std::size_t b = 0; b < 3; ++b) columns[b] = {map.matrix[0][b], map.matrix[1][b], map.matrix[2][b]};
    return unit(solve_columns(columns, n));
}

/// Returns a ray along the normal of a point, without a momentum.
SurfaceRay ray_along_normal(const DiffusePoint& point) {
    SurfaceRay ray{};
    std::copy_n(point.position.begin(), 3, ray.q);
    std::copy_n(point.normal.begin(), 3, ray.normal);
    ray.pt = point.pt;
    return ray;
}

}  // namespace

void SurfaceFrame::begin(const Scene& scene, const DiffusePoint& point) {
    scene_ = &scene;
    point_ = point;
    normal_ = point.normal;
    exists_ = true;
    has_covectors_ = false;
    map_.reset();
}

// H is quadratic in the momentum: ∂H/∂p = γ (p − c) with the spatial block γ of the inverse metric and the vector c of
// Module::time_tilts. A surface at rest sees the light with the momentum p − c, whose length in γ is the frequency.
// Three rays with the same frequency determine the frame: p − c of the first is along the conormal, and the covectors
// of the other axes follow by orthogonalization in γ.
void SurfaceFrame::make_test_rays(const double (&tilt)[3], std::span<SurfaceRay, test_rays> rays) {
    constexpr double tangential_share = 0.1;
    const auto [e1, e2] = axes_around(point_.normal);
    axes_ = {point_.normal, e1, e2};
    offset_ = {tilt[0], tilt[1], tilt[2]};
    for (SurfaceRay& ray : rays) {
        ray = ray_along_normal(point_);
        std::copy_n(offset_.begin(), 3, ray.p);
    }
    for (std::size_t k = 0; k < 3; ++k) {
        rays[1].p[k] += tangential_share * e1[k];
        rays[2].p[k] += tangential_share * e2[k];
    }
}

bool SurfaceFrame::set_from_rays(std::span<const Continuation, test_rays> rays) {
    std::array<Double3, test_rays> vectors;  // γ times each of the covectors
    double square = 0;                       // square of the frequency
    for (std::size_t i = 0; i < test_rays; ++i) {
        const Continuation& ray = rays[i];
        if (!ray.exists) return false;
        Double3 covector = subtract({ray.p[0], ray.p[1], ray.p[2]}, offset_);
        Double3 vector{ray.velocity[0], ray.velocity[1], ray.velocity[2]};
        if (i == 0) square = dot(covector, vector);
        for (std::size_t k = 0; k < i; ++k) {
            const double share = dot(covector, vectors[k]) / square;
            covector = subtract(covector, scaled(covectors_[k], share));
            vector = subtract(vector, scaled(vectors[k], share));
        }
        const double length2 = dot(covector, vector), scale = std::sqrt(square / length2);
        if (!(length2 > 0) || !std::isfinite(scale)) return false;
        covectors_[i] = scaled(covector, scale);
        vectors[i] = scaled(vector, scale);
    }
    has_covectors_ = true;
    return true;
}

bool SurfaceFrame::set_from_observer() {
    const double q[3] = {point_.position[0], point_.position[1], point_.position[2]};
    StartMap map{};
    const Failure failure = scene_->space.observe(ObserverKind::static_, q, false, map);
    if (failure == Failure::no_rest_frame) return true;  // directions are those of dq/dλ
    if (failure != Failure::none || map.ingoing) return false;
    normal_ = normal_in_frame(map, point_.normal);
    map_ = map;
    return true;
}

RayStart SurfaceFrame::start_along(const Double3& direction) const {
    const double q[3] = {point_.position[0], point_.position[1], point_.position[2]};
    RayStart start{};
    if (has_covectors_) {
        for (std::size_t k = 0; k < 3; ++k) {
            start.p[k] = offset_[k];
            for (std::size_t b = 0; b < 3; ++b) start.p[k] += dot(direction, axes_[b]) * covectors_[b][k];
        }
        start.pt = point_.pt;
    } else start = map_ ? ray_in_frame(*map_, direction).start : scene_->space.start(q, direction);
    if (map_ && start.pt != 0) {  // null rays have |p_t| = 1 at surfaces
        const double scale = 1 / std::abs(start.pt);
        for (double& component : start.p) component *= scale;
        start.pt *= scale;
    }
    std::copy_n(q, 3, start.q);
    start.captured = start.escaped = false;
    start.surface = point_.surface;
    start.primitive = point_.primitive;
    if (start.failure == Failure::none &&
        starts_ingoing(scene_->space, scene_->limits.chart_radius, std::nullopt, start.q)) {
        const Hole hole = scene_->space.hole();
        scene_->module().to_ingoing(&hole, &start);
    }
    return start;
}

void SurfaceFrame::set_shading_normal() {
    shading_normal_ = normal_;
    if (point_.shading_normal == point_.normal) return;
    if (map_) shading_normal_ = normal_in_frame(*map_, point_.shading_normal);
    else if (!has_covectors_) shading_normal_ = point_.shading_normal;
    else {
        const Double3 components = solve_columns(covectors_, point_.shading_normal);
        shading_normal_ = {};
        for (std::size_t b = 0; b < 3; ++b) shading_normal_ = add(shading_normal_, scaled(axes_[b], components[b]));
        shading_normal_ = unit(shading_normal_);
    }
}

std::span<const SurfaceFrame> SurfaceFrames::at(std::span<const DiffusePoint> points) {
    if (frames_.size() < points.size()) frames_.resize(points.size());
    for (std::size_t begin = 0, end; begin < points.size(); begin = end) {
        for (end = begin + 1; end < points.size() && points[end].medium == points[begin].medium;) ++end;
        set_frames(*plan_.medium(points[begin].medium).scene, points.subspan(begin, end - begin), &frames_[begin]);
    }
    return std::span(frames_).first(points.size());
}

void SurfaceFrames::set_frames(const Scene& scene, std::span<const DiffusePoint> points, SurfaceFrame* frames) {
    constexpr std::size_t test_rays = SurfaceFrame::test_rays;
    const std::size_t count = points.size();
    for (std::size_t i = 0; i < count; ++i) frames[i].begin(scene, points[i]);
    if (null_ray_sign(scene) != 0) {
        const Space& space = scene.space;
        normals_.clear();
        for (const DiffusePoint& point : points) normals_.push_back(ray_along_normal(point));
        tilts_.resize(count);
        space.module->time_tilts(space.hamiltonian, space.parameters.data(), normals_.data(),
                                 static_cast<std::uint32_t>(count), &tilts_.data()->vector);
        rays_.resize(count * test_rays);
        for (std::size_t i = 0; i < count; ++i)
            frames[i].make_test_rays(tilts_[i].vector,
                                     std::span<SurfaceRay, test_rays>(&rays_[i * test_rays], test_rays));
        continuations_.resize(rays_.size());
        space.module->continue_rays(space.hamiltonian, space.parameters.data(), rays_.data(),
                                    static_cast<std::uint32_t>(rays_.size()), continuations_.data());
        for (std::size_t i = 0; i < count; ++i) {
            const std::span<const Continuation, test_rays> rays(&continuations_[i * test_rays], test_rays);
            frames[i].exists_ = frames[i].set_from_rays(rays) || frames[i].set_from_observer();
        }
    }
    for (std::size_t i = 0; i < count; ++i) frames[i].set_shading_normal();
}

}  // namespace kagero
