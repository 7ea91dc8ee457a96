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

/// A ray at a surface, with the data that both branches need.
struct Crossing {
    Double3 position{}, momentum{};  ///< Scaled to |p_t| = 1, in the coordinates of the ray's medium.
    double pt = 0, scale = 1;
    Double3 normal{};              ///< Unit normal on the side of the ray.
    std::uint32_t other_side = 0;  ///< The medium beyond the surface.
    bool is_boundary = false, in_medium = true;
    bool passes_edge = false;  ///< The ray passes the edge of a boundary on the outside, by less than its rounding.
};

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

/// Sets the media of a boundary that a ray crosses. `q` is the point of the crossing in the space of the scene.
void set_media(const Plan& plan, const RayAtSurface& hit, const Double3& q, bool is_outside, Crossing& crossing) {
    const Regions& regions = *plan.scene->regions;
    const std::uint32_t surface = hit.end->surface;
    if (regions.is_contact(surface, hit.end->primitive, q, crossing.normal)) {
        crossing.other_side = regions.medium_beside(surface, q, scaled(crossing.normal, -1));
        crossing.in_medium = hit.medium == regions.medium_beside(surface, q, crossing.normal);
        return;
    }
    const ObjectDescription& object = plan.description().objects[surface];
    crossing.other_side = is_outside ? object.interior : object.exterior;
    crossing.in_medium = hit.medium == (is_outside ? object.exterior : object.interior);
    if (crossing.in_medium || crossing.other_side != hit.medium) return;
    // Rays of float kernels can miss a boundary close to an edge, and bent rays can leave it by less than the tolerance
    // of chords. They have then been beyond it only for a short way, or at a small distance.
    constexpr double small_share = 1e-4, chord_tolerances = 4;
    const double tolerance = std::max(small_share * regions.size_of(surface),
                                      chord_tolerances * plan.medium(hit.medium).run.chord_tolerance),
                 height = 0.5 * dot(crossing.normal, subtract(hit.start, crossing.position));
    crossing.passes_edge = std::abs(height) <= tolerance ||
                           hit.medium == regions.medium_at(subtract(q, scaled(vector_of(hit.end->v), tolerance)));
}

Crossing crossing_of(const Plan& plan, const RayAtSurface& hit) {
    const Scene& scene = *plan.medium(hit.medium).scene;
    Crossing crossing;
    if (null_ray_sign(scene) != 0 && hit.end->pt != 0) crossing.scale = 1 / std::abs(hit.end->pt);
    crossing.momentum = scaled(vector_of(hit.end->p), crossing.scale);
    crossing.pt = hit.end->pt * crossing.scale;
    const auto [position, normal] = on_surface(scene, *hit.end);
    crossing.position = position;
    const bool is_on_back = comes_from_back(scene, hit, position, normal);
    crossing.normal = is_on_back ? scaled(normal, -1) : normal;
    crossing.is_boundary = scene.description.objects[hit.end->surface].material == Material::boundary;
    if (!crossing.is_boundary) return crossing;
    const Double3 q = add(position, subtract(scene.description.space.center, plan.description().space.center));
    const bool is_outside = is_on_back != (plan.scene->regions->outward_sign(hit.end->surface) > 0);
    set_media(plan, hit, q, is_outside, crossing);
    return crossing;
}

/// Returns the input of Module::continue_rays for the reflected branch.
SurfaceRay reflected_ray(const Crossing& crossing) {
    SurfaceRay ray{};
    std::copy(crossing.position.begin(), crossing.position.end(), ray.q);
    std::copy(crossing.normal.begin(), crossing.normal.end(), ray.normal);
    std::copy(crossing.momentum.begin(), crossing.momentum.end(), ray.p);
    ray.pt = crossing.pt;
    ray.may_keep_value = true;
    return ray;
}

/// Returns the ray beyond the surface, with the momentum of the incident ray in the coordinates of the medium there.
/// The sign of the momentum changes if the rays of both spaces have p_t of different signs.
SurfaceRay transmitted_ray(const Scene& source, const Scene& target, const Crossing& crossing) {
    const double source_sign = null_ray_sign(source), target_sign = null_ray_sign(target);
    const Double3 to_target = subtract(source.description.space.center, target.description.space.center);
    SurfaceRay ray = reflected_ray(crossing);
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

/// A momentum vector p_t g_ti/g_tt (Module::time_tilts); zero in a medium without p_t.
struct TimeTilt {
    double vector[3] = {0, 0, 0};
};

/// Returns the index and the angle of a ray at a surface, in the rest frame of the surface. There, the frequency ω of a
/// null ray is given by ω² = v · (p − tilt) with v = ∂H/∂p.
OpticalSide optical_side(bool is_null, const SurfaceRay& ray, const double (&p)[3], const Continuation& continuation,
                         const TimeTilt& tilt) {
    const Double3 momentum = vector_of(p), normal = vector_of(ray.normal);
    if (!is_null) return {length(momentum), std::min(std::abs(dot(momentum, normal)) / length(momentum), 1.0)};
    const Double3 v = vector_of(continuation.velocity),
                  rest = subtract(vector_of(continuation.p), vector_of(tilt.vector));
    return {1, std::min(std::abs(dot(v, normal)) / std::sqrt(dot(v, rest) * continuation.curvature), 1.0)};
}

/// A list of rays for each space, for functions of the kernel module that compute in packets.
template <class Result>
class Batches {
public:
    explicit Batches(const Plan& plan) : plan_(plan), batches_(plan.media.size() + 1) {}

    /// Adds a ray in a medium; `result` receives its result.
    void add(std::uint32_t medium, const SurfaceRay& ray, Result& result) {
        batches_[medium].rays.push_back(ray);
        batches_[medium].results.push_back(&result);
    }
    /// Calls compute(space, rays, count, results) for each space, and stores the results.
    template <class Compute>
    void compute(const Compute& compute) {
        std::vector<Result> computed;
        for (std::uint32_t medium = 0; medium < batches_.size(); ++medium) {
            const Batch& batch = batches_[medium];
            computed.resize(batch.rays.size());
            if (batch.rays.empty()) continue;
            compute(plan_.medium(medium).scene->space, batch.rays.data(), static_cast<std::uint32_t>(batch.rays.size()),
                    computed.data());
            for (std::size_t i = 0; i < computed.size(); ++i) *batch.results[i] = computed[i];
        }
    }

private:
    struct Batch {
        std::vector<SurfaceRay> rays;
        std::vector<Result*> results;
    };
    const Plan& plan_;
    std::vector<Batch> batches_;
};

/// Both branches of a ray at a surface, before their shares are known.
struct Branches {
    Crossing crossing;
    SurfaceRay reflected{}, transmitted{};  ///< With the momentum of the incident ray.
    TimeTilt near_tilt, far_tilt;           ///< On both sides of the surface.
    Continuation reflection{}, transmission{};
};

Branch branch_of(std::uint32_t medium, const RayEnd& hit, const SurfaceRay& ray, const Continuation& continuation) {
    return {medium, vector_of(ray.q), vector_of(continuation.p), ray.pt, hit.surface, hit.primitive, 1, 1};
}

/// Sets the shares and radiances of the branches at a boundary.
void divide_light(const Plan& plan, std::uint32_t medium, const Branches& branches, Fresnel fresnel,
                  SurfaceInteraction& interaction) {
    const bool near_is_null = null_ray_sign(*plan.medium(medium).scene) != 0,
               far_is_null = null_ray_sign(*plan.medium(branches.crossing.other_side).scene) != 0;
    // H is quadratic in a spacetime, so that the angles of incidence and reflection are equal.
    const OpticalSide incident = optical_side(near_is_null, branches.reflected, branches.reflected.p,
                                              branches.reflection, branches.near_tilt),
                      transmitted = optical_side(far_is_null, branches.transmitted, branches.transmission.p,
                                                 branches.transmission, branches.far_tilt);
    const double reflected = fresnel == Fresnel::automatic ? reflectance(incident, transmitted) : 0;
    const double ratio = incident.index / transmitted.index;
    interaction.transmitted->share = 1 - reflected;
    interaction.transmitted->radiance = ratio * ratio;
    if (!(reflected > 0)) interaction.reflected.reset();
    if (interaction.reflected) interaction.reflected->share = reflected;
}

/// Returns the branch of a ray that continues unchanged.
Branch passing_branch(const RayAtSurface& hit, const Branches& branches) {
    Continuation unchanged{};
    std::copy_n(branches.reflected.p, 3, unchanged.p);
    return branch_of(hit.medium, *hit.end, branches.reflected, unchanged);
}

SurfaceInteraction interaction_of(const Plan& plan, const RayAtSurface& hit, const Branches& branches) {
    SurfaceInteraction interaction;
    interaction.frequency = branches.crossing.scale;
    if (branches.crossing.passes_edge) {
        interaction.transmitted = passing_branch(hit, branches);
        return interaction;
    }
    interaction.leaves_medium = !branches.crossing.in_medium;
    if (branches.reflection.exists)
        interaction.reflected = branch_of(hit.medium, *hit.end, branches.reflected, branches.reflection);
    if (!branches.crossing.is_boundary || !branches.transmission.exists) return interaction;
    interaction.transmitted =
        branch_of(branches.crossing.other_side, *hit.end, branches.transmitted, branches.transmission);
    divide_light(plan, hit.medium, branches, plan.description().objects[hit.end->surface].fresnel, interaction);
    return interaction;
}

/// Sets the crossings and the rays on both sides. Between a spacetime and a medium without p_t, the momentum is that in
/// the rest frame of the surface, which does not depend on the time coordinate of the spacetime.
void prepare_branches(const Plan& plan, std::span<const RayAtSurface> hits, std::vector<Branches>& branches) {
    Batches<TimeTilt> tilts(plan);
    for (std::size_t i = 0; i < hits.size(); ++i) {
        Branches& b = branches[i];
        const Scene& source = *plan.medium(hits[i].medium).scene;
        b.crossing = crossing_of(plan, hits[i]);
        b.reflected = reflected_ray(b.crossing);
        if (!b.crossing.is_boundary) continue;
        const Scene& target = *plan.medium(b.crossing.other_side).scene;
        b.transmitted = transmitted_ray(source, target, b.crossing);
        if (null_ray_sign(source) != 0) tilts.add(hits[i].medium, b.reflected, b.near_tilt);
        if (null_ray_sign(target) != 0) tilts.add(b.crossing.other_side, b.transmitted, b.far_tilt);
    }
    tilts.compute([](const Space& space, const SurfaceRay* rays, std::uint32_t count, TimeTilt* out) {
        space.module->time_tilts(space.hamiltonian, space.parameters.data(), rays, count, &out->vector);
    });
    for (std::size_t i = 0; i < hits.size(); ++i) {
        Branches& b = branches[i];
        if (!b.crossing.is_boundary) continue;
        const double near_sign = null_ray_sign(*plan.medium(hits[i].medium).scene),
                     far_sign = null_ray_sign(*plan.medium(b.crossing.other_side).scene);
        if ((near_sign != 0) == (far_sign != 0)) continue;
        for (std::size_t k = 0; k < 3; ++k)
            b.transmitted.p[k] += b.far_tilt.vector[k] - (near_sign < 0 ? -1 : 1) * b.near_tilt.vector[k];
    }
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

std::vector<SurfaceInteraction> interactions_of(const Plan& plan, std::span<const RayAtSurface> hits) {
    std::vector<Branches> branches(hits.size());
    prepare_branches(plan, hits, branches);
    Batches<Continuation> continuations(plan);
    for (std::size_t i = 0; i < hits.size(); ++i) {
        Branches& b = branches[i];
        continuations.add(hits[i].medium, b.reflected, b.reflection);
        if (b.crossing.is_boundary) continuations.add(b.crossing.other_side, b.transmitted, b.transmission);
    }
    continuations.compute([](const Space& space, const SurfaceRay* rays, std::uint32_t count, Continuation* out) {
        space.module->continue_rays(space.hamiltonian, space.parameters.data(), rays, count, out);
    });
    std::vector<SurfaceInteraction> interactions;
    interactions.reserve(hits.size());
    for (std::size_t i = 0; i < hits.size(); ++i) interactions.push_back(interaction_of(plan, hits[i], branches[i]));
    return interactions;
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
