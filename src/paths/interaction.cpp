#include "paths/interaction.h"

#include "media/regions.h"
#include "scene/vector3.h"
#include "spaces/charts.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kagero {
namespace {

Double3 vector_of(const double (&v)[3]) { return {v[0], v[1], v[2]}; }

/// Returns true if a ray comes from the side of a surface to which the unit normal does not point. At a small angle to
/// the surface, rounding and the tolerance of hits decide on the direction across it, so the position of the segment
/// decides instead: the middle between its ends.
bool comes_from_back(const Scene& scene, const RayAtSurface& hit, const Double3& position, const Double3& normal) {
    constexpr double small_angle = 0.02;
    const double cosine = dot(normal, vector_of(hit.end->v));
    if (std::abs(cosine) > small_angle) return cosine > 0;
    const Double3 middle = scaled(add(hit.start, position), 0.5);
    const ObjectGeometry& object = scene.geometry->objects()[hit.end->surface];
    const double height = object.shape == Shape::sphere
                              ? length(subtract(middle, object.center)) - length(subtract(position, object.center))
                              : dot(normal, subtract(middle, position));
    return height != 0 ? height < 0 : cosine > 0;
}

/// Returns the point of a surface that is nearest to q, and the unit normal there.
std::pair<Double3, Double3> on_surface(const Scene& scene, const RayEnd& end) {
    const ObjectGeometry& object = scene.geometry->objects()[end.surface];
    const Double3 q = vector_of(end.q);
    if (object.shape == Shape::sphere) {
        const Double3 normal = unit(subtract(q, object.center));
        return {add(object.center, scaled(normal, scene.description.objects[end.surface].radius)), normal};
    }
    const double* plane = &object.planes[4 * std::size_t{end.primitive}];
    const Double3 normal{plane[0], plane[1], plane[2]};
    return {add(q, scaled(normal, plane[3] - dot(normal, q))), normal};
}

/// Returns the ray beyond the surface, with the momentum of the incident ray in the coordinates of the medium there.
/// The sign of the momentum changes if the rays of both spaces have p_t of different signs.
SurfaceRay transmitted_ray(const Scene& source, const Scene& target, const SurfaceRay& incident) {
    const double source_sign = null_ray_sign(source), target_sign = null_ray_sign(target);
    const Double3 to_target = subtract(source.description.space.center, target.description.space.center);
    SurfaceRay ray = incident;
    ray.may_keep_value = false;
    for (std::size_t k = 0; k < 3; ++k) {
        ray.q[k] += to_target[k];
        ray.normal[k] = -ray.normal[k];
        if ((source_sign < 0) != (target_sign < 0)) ray.p[k] = -ray.p[k];
    }
    const auto& formula = target.description.space.formula;
    if (target_sign != 0) ray.pt = source_sign != 0 ? std::copysign(ray.pt, target_sign) : target_sign;
    else ray.pt = formula ? formula->parsed.pt : 0;
    return ray;
}

/// Returns the index and the angle of a ray at a surface, in the rest frame of the surface. There, the frequency ω of a
/// null ray is given by ω² = v · (p − tilt) with v = ∂H/∂p.
OpticalSide optical_side(bool is_null, const double (&normal)[3], const double (&p)[3],
                         const Continuation& continuation, const double (&tilt)[3]) {
    const Double3 momentum = vector_of(p), n = vector_of(normal);
    if (!is_null) return {length(momentum), std::min(std::abs(dot(momentum, n)) / length(momentum), 1.0)};
    const Double3 v = vector_of(continuation.velocity), rest = subtract(vector_of(continuation.p), vector_of(tilt));
    return {1, std::min(std::abs(dot(v, n)) / std::sqrt(dot(v, rest) * continuation.curvature), 1.0)};
}

}  // namespace

const Branch* SurfaceInteraction::stronger() const {
    if (!reflected || !transmitted) return reflected ? &*reflected : transmitted ? &*transmitted : nullptr;
    return reflected->share > transmitted->share ? &*reflected : &*transmitted;
}

const Branch* SurfaceInteraction::sampled(double number) const {
    if (!reflected || !transmitted) return stronger();
    return number < reflected->share ? &*reflected : &*transmitted;
}

InteractionSolver::InteractionSolver(const Plan& plan) : plan_(plan), spaces_(plan.media.size() + 1) {}

double InteractionSolver::time_sign(std::uint32_t medium) const { return null_ray_sign(*plan_.medium(medium).scene); }

std::span<const SurfaceInteraction> InteractionSolver::solve(std::span<const RayAtSurface> hits) {
    for (SpaceRays& space : spaces_) space.rays.clear();
    crossings_.resize(hits.size());
    reflected_.resize(hits.size());
    interactions_.resize(hits.size());
    bool has_boundaries = false;
    for (std::size_t i = 0; i < hits.size(); ++i) {
        crossings_[i] = {};
        reflected_[i] = locate(hits[i], crossings_[i]);
        has_boundaries |= crossings_[i].is_boundary;
    }
    if (has_boundaries) {
        add_branches(hits, true);
        compute_tilts();
        convert_momenta(hits);
    }
    add_branches(hits, false);
    compute_continuations();
    for (std::size_t i = 0; i < hits.size(); ++i) {
        interactions_[i].reset();
        interactions_[i].frequency = crossings_[i].scale;
        const SurfaceRay& ray = reflected_[i];
        if (!crossings_[i].is_diffuse) set_interaction(hits[i], crossings_[i], interactions_[i]);
        else interactions_[i].diffuse = diffuse_point(hits[i], ray);
    }
    return interactions_;
}

DiffusePoint InteractionSolver::diffuse_point(const RayAtSurface& hit, const SurfaceRay& ray) const {
    DiffusePoint point{hit.medium,
                       hit.end->surface,
                       hit.end->primitive,
                       vector_of(ray.q),
                       vector_of(ray.normal),
                       vector_of(ray.normal),
                       ray.pt};
    const TriangleMesh& mesh = plan_.medium(hit.medium).scene->geometry->objects()[point.surface].mesh;
    if (mesh.normals.empty()) return point;
    const Double3 normal = unit(interpolated_normal(mesh, point.primitive, point.position));
    point.shading_normal = scaled(normal, dot(normal, point.normal) < 0 ? -1 : 1);
    return point;
}

SurfaceRay InteractionSolver::locate(const RayAtSurface& hit, Crossing& crossing) const {
    const Scene& scene = *plan_.medium(hit.medium).scene;
    if (null_ray_sign(scene) != 0 && hit.end->pt != 0) crossing.scale = 1 / std::abs(hit.end->pt);
    const auto [position, normal] = on_surface(scene, *hit.end);
    const bool is_on_back = comes_from_back(scene, hit, position, normal);
    SurfaceRay ray;
    for (std::size_t k = 0; k < 3; ++k) {
        ray.q[k] = position[k];
        ray.p[k] = hit.end->p[k] * crossing.scale;
        ray.normal[k] = is_on_back ? -normal[k] : normal[k];
    }
    ray.pt = hit.end->pt * crossing.scale;
    ray.may_keep_value = true;
    const Material material = scene.description.objects[hit.end->surface].material;
    crossing.is_boundary = material == Material::boundary;
    crossing.is_diffuse = material == Material::diffuse;
    if (crossing.is_boundary)
        set_media(hit, ray, is_on_back != (plan_.scene->regions->outward_sign(hit.end->surface) > 0), crossing);
    return ray;
}

void InteractionSolver::set_media(const RayAtSurface& hit, const SurfaceRay& ray, bool is_outside,
                                  Crossing& crossing) const {
    const Regions& regions = *plan_.scene->regions;
    const std::uint32_t surface = hit.end->surface;
    const Double3 normal = vector_of(ray.normal), position = vector_of(ray.q),
                  to_scene =
                      subtract(plan_.medium(hit.medium).description().space.center, plan_.description().space.center),
                  q = add(position, to_scene);
    if (regions.is_contact(surface, hit.end->primitive, q, normal)) {
        crossing.other_side = regions.medium_beside(surface, q, scaled(normal, -1));
        crossing.in_medium = hit.medium == regions.medium_beside(surface, q, normal);
        crossing.exit =
            regions.close_surfaces()
                .meet({surface, hit.end->primitive, q}, vector_of(hit.end->v), length(subtract(position, hit.start)))
                .last;
        crossing.to_exit = subtract(crossing.exit->position, q);
        return;
    }
    const ObjectDescription& object = plan_.description().objects[surface];
    crossing.other_side = is_outside ? object.interior : object.exterior;
    crossing.in_medium = hit.medium == (is_outside ? object.exterior : object.interior);
    if (crossing.in_medium || crossing.other_side != hit.medium) return;
    // Rays of float kernels can miss a boundary close to an edge, and bent rays can leave it by less than the tolerance
    // of chords. They have then been beyond it only for a short way, or at a small distance.
    constexpr double small_share = 1e-4, chord_tolerances = 4;
    const double tolerance = std::max(small_share * regions.size_of(surface),
                                      chord_tolerances * plan_.medium(hit.medium).run.chord_tolerance),
                 height = 0.5 * dot(normal, subtract(hit.start, position));
    crossing.passes_edge = std::abs(height) <= tolerance ||
                           hit.medium == regions.medium_at(subtract(q, scaled(vector_of(hit.end->v), tolerance)));
}

std::uint32_t InteractionSolver::add_branch(std::uint32_t medium, const SurfaceRay& ray) {
    std::vector<SurfaceRay>& rays = spaces_[medium].rays;
    rays.push_back(ray);
    return static_cast<std::uint32_t>(rays.size() - 1);
}

void InteractionSolver::add_branches(std::span<const RayAtSurface> hits, bool at_boundaries) {
    for (std::size_t i = 0; i < hits.size(); ++i) {
        Crossing& crossing = crossings_[i];
        if (crossing.is_boundary != at_boundaries || crossing.is_diffuse) continue;
        crossing.reflected = add_branch(hits[i].medium, reflected_[i]);
        if (!at_boundaries) continue;
        const Scene &source = *plan_.medium(hits[i].medium).scene, &target = *plan_.medium(crossing.other_side).scene;
        crossing.transmitted = add_branch(crossing.other_side, transmitted_ray(source, target, reflected_[i]));
    }
}

void InteractionSolver::compute_tilts() {
    for (std::uint32_t medium = 0; medium < spaces_.size(); ++medium) {
        SpaceRays& branches = spaces_[medium];
        branches.tilts.assign(branches.rays.size(), TimeTilt{});
        if (time_sign(medium) == 0 || branches.rays.empty()) continue;
        const Space& space = plan_.medium(medium).scene->space;
        space.module->time_tilts(space.hamiltonian, space.parameters.data(), branches.rays.data(),
                                 static_cast<std::uint32_t>(branches.rays.size()), &branches.tilts.data()->vector);
    }
}

void InteractionSolver::convert_momenta(std::span<const RayAtSurface> hits) {
    for (std::size_t i = 0; i < hits.size(); ++i) {
        const Crossing& crossing = crossings_[i];
        if (!crossing.is_boundary) continue;
        const double near_sign = time_sign(hits[i].medium), far_sign = time_sign(crossing.other_side);
        if ((near_sign != 0) == (far_sign != 0)) continue;
        SpaceRays &near = spaces_[hits[i].medium], &far = spaces_[crossing.other_side];
        for (std::size_t k = 0; k < 3; ++k)
            far.rays[crossing.transmitted].p[k] += far.tilts[crossing.transmitted].vector[k] -
                                                   (near_sign < 0 ? -1 : 1) * near.tilts[crossing.reflected].vector[k];
    }
}

void InteractionSolver::compute_continuations() {
    for (std::uint32_t medium = 0; medium < spaces_.size(); ++medium) {
        SpaceRays& branches = spaces_[medium];
        branches.continuations.resize(branches.rays.size());
        if (branches.rays.empty()) continue;
        const Space& space = plan_.medium(medium).scene->space;
        space.module->continue_rays(space.hamiltonian, space.parameters.data(), branches.rays.data(),
                                    static_cast<std::uint32_t>(branches.rays.size()), branches.continuations.data());
    }
}

Branch InteractionSolver::branch_of(std::uint32_t medium, std::uint32_t index, const RayEnd& hit) const {
    const SpaceRays& branches = spaces_[medium];
    const SurfaceRay& ray = branches.rays[index];
    return {medium, vector_of(ray.q), vector_of(branches.continuations[index].p), ray.pt, hit.surface, hit.primitive, 1,
            1};
}

void InteractionSolver::set_interaction(const RayAtSurface& hit, const Crossing& crossing,
                                        SurfaceInteraction& interaction) const {
    interaction.leaves_medium = !crossing.in_medium && !crossing.passes_edge;
    const SpaceRays &near = spaces_[hit.medium], &far = spaces_[crossing.other_side];
    if (crossing.passes_edge) {  // the ray continues unchanged
        interaction.transmitted = branch_of(hit.medium, crossing.reflected, *hit.end);
        interaction.transmitted->momentum = vector_of(near.rays[crossing.reflected].p);
        return;
    }
    if (near.continuations[crossing.reflected].exists)
        interaction.reflected = branch_of(hit.medium, crossing.reflected, *hit.end);
    if (!crossing.is_boundary || !far.continuations[crossing.transmitted].exists) return;
    Branch& transmitted =
        interaction.transmitted.emplace(branch_of(crossing.other_side, crossing.transmitted, *hit.end));
    if (crossing.exit) {
        transmitted.surface = crossing.exit->surface;
        transmitted.primitive = crossing.exit->primitive;
        transmitted.position = add(transmitted.position, crossing.to_exit);
    }
    divide_light(hit.medium, crossing, plan_.description().objects[hit.end->surface].fresnel, interaction);
}

void InteractionSolver::divide_light(std::uint32_t medium, const Crossing& crossing, Fresnel fresnel,
                                     SurfaceInteraction& interaction) const {
    const SpaceRays &near = spaces_[medium], &far = spaces_[crossing.other_side];
    const SurfaceRay &incident_ray = near.rays[crossing.reflected], &transmitted_ray = far.rays[crossing.transmitted];
    const Continuation &reflection = near.continuations[crossing.reflected],
                       &transmission = far.continuations[crossing.transmitted];
    // H is quadratic in a spacetime, so that the angles of incidence and reflection are equal.
    const OpticalSide incident = optical_side(time_sign(medium) != 0, incident_ray.normal, incident_ray.p, reflection,
                                              near.tilts[crossing.reflected].vector),
                      transmitted = optical_side(time_sign(crossing.other_side) != 0, transmitted_ray.normal,
                                                 transmission.p, transmission, far.tilts[crossing.transmitted].vector);
    const double reflected = fresnel == Fresnel::automatic ? reflectance(incident, transmitted) : 0;
    const double ratio = incident.index / transmitted.index;
    interaction.transmitted->share = 1 - reflected;
    interaction.transmitted->radiance = ratio * ratio;
    interaction.index = incident.index;
    interaction.transmitted_index = transmitted.index;
    if (!(reflected > 0)) interaction.reflected.reset();
    if (interaction.reflected) interaction.reflected->share = reflected;
}

RayStart start_of(const Plan& plan, const Branch& branch) {
    const Scene& scene = *plan.medium(branch.medium).scene;
    RayStart start{};
    std::copy(branch.position.begin(), branch.position.end(), start.q);
    std::copy(branch.momentum.begin(), branch.momentum.end(), start.p);
    start.pt = branch.pt;
    start.surface = branch.surface;
    start.primitive = branch.primitive;
    if (starts_ingoing(scene.space, scene.limits.chart_radius, std::nullopt, start.q)) {
        const Hole hole = scene.space.hole();
        scene.module().to_ingoing(&hole, &start);
    }
    return start;
}

}  // namespace kagero
