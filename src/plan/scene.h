/// A loaded scene: its space, surfaces and paints. It is immutable, so threads and plans may share it.
#pragma once

#include "appearance/lights/light_proposals.h"
#include "appearance/paints.h"
#include "appearance/redshift.h"
#include "geometry/geometry.h"
#include "media/regions.h"
#include "modules/space.h"
#include "plan/options.h"
#include "spaces/integrated_hamiltonian.h"

#include <memory>

namespace kagero {

/// Bounds at which rays that hit no surface end. Radii are measured from the centre of the space, in Scene::unit.
struct RayLimits {
    double escape_radius = 0;        ///< A ray that leaves this sphere has escaped.
    double inner_escape_radius = 0;  ///< A ray that enters this sphere escapes into the second sheet; 0: no such sheet.
    /// An inward ray that cannot return is captured where |(x, y, capture_stretch·z)| is less than capture_radius,
    /// because no surface lies farther inward.
    double capture_radius = std::numeric_limits<double>::infinity(), capture_stretch = 1;
    double chart_radius = 0;  ///< Radius |q| inside which rays may be in ingoing coordinates (spaces/charts.h).
};

/// Returns the bounds for rays that hit no surface. `escape_radius` is integrator.escape_radius. In a wormhole, the
/// second sheet is the image of the first sheet under inversion in the throat, and `escape_radius` is the proper
/// distance |l| from the throat on both sheets. The rays of a ray list are always integrated to just above a horizon
/// (`to_horizon`), except those of a falling observer, which reach no horizon.
RayLimits ray_limits(const Space& space, const SceneGeometry& geometry, double escape_radius, bool to_horizon);

/// A loaded scene.
struct Scene {
    SceneDescription description;  ///< Lengths are in `unit`, except the step, whose unit depends on the method.
    Space space;
    IntegratedHamiltonian integrated;
    std::string form_remark;       ///< Remark on the form of a formula (spaces/formula_form.h); empty if there is none.
    double unit = 1;               ///< Unit of length of the kernels, in units of the scene file; a power of two.
    bool straight = false;         ///< True if every ray is a straight line, so that no method is needed.
    RayLimits limits;
    std::shared_ptr<const SceneGeometry> geometry;  ///< Relative to the centre of the space; media may share it.
    std::unique_ptr<const Regions> regions;         ///< Null if the scene has no boundaries of media.
    std::shared_ptr<const Paints> paints;           ///< Contains pointers into `geometry`.
    /// Texts that determine `geometry` and `paints`: scenes with equal texts can share them.
    std::string geometry_inputs, paint_inputs;
    std::unique_ptr<const LightProposals> lights;  ///< Null unless diffuse surfaces scatter the rays of a picture.
    Sources sources;  ///< Contains pointers to other members.
    /// The spaces of the media, each with the objects of the scene in the coordinates of its space.
    std::vector<std::shared_ptr<const Scene>> media;

    const Module& module() const { return *space.module; }
    /// Returns the index, in Module::hamiltonians, of the integrated Hamiltonian.
    std::uint32_t integrated_hamiltonian() const;
    /// Returns the parameters or programs of the integrated Hamiltonian.
    const double* integrated_parameters() const {
        return integrated.is_of_space() ? space.parameters.data() : integrated.programs.data();
    }
};

/// Returns the names that scenes may use: the Hamiltonians and integrators of the module for `isa`, and the layers.
Catalogue catalogue(const std::string& isa);

/// Loads the kernel module and the meshes, compiles formulas, and for pictures loads images. Throws InputError if any
/// of them is invalid. `earlier`, if not null, is the scene of another frame of the same animation, made with the same
/// options. Its geometry and paints are used again if they would be the same; otherwise its images, and the meshes of
/// objects that have not changed.
std::shared_ptr<const Scene> make_scene(SceneDescription description, const Options& options, Purpose purpose,
                                        const Scene* earlier = nullptr);

/// Returns the diagonal of the bounding box of all objects, or the escape radius if there are none, in lengths of the
/// scene file.
double scene_size(const Scene& scene);

/// Returns |p| of the ray along the axis of the scene's camera; 1 if this ray cannot start.
double typical_momentum(const Scene& scene);

/// Returns |dq/dλ| of the same ray of a formula; 1 for other spaces, or if the ray cannot start.
double typical_speed(const Scene& scene);

/// Returns the sign of p_t of the rays in a spacetime, which can be scaled: H = 0 on them, and H is homogeneous in p
/// and p_t. Returns 0 in a medium.
double null_ray_sign(const Scene& scene);

/// Returns true if the surface of an object sends light on, so that rays continue there.
inline bool sends_light_on(const ObjectDescription& object) { return object.material != Material::surface; }

/// Returns true if the surface of any object sends light on. Rays then start on surfaces, in all directions.
bool has_rays_from_surfaces(const SceneDescription& scene);

/// Returns true if the scene states an expression for Ω and its rays bend. Then Ω(H − H0) is always integrated.
bool states_rescaling(const Scene& scene);

/// Returns the key of a formula that ends rays at q because its value is not greater than 0 there, "space.domain" or
/// "space.capture"; nullptr if there is none. q is relative to the centre of the space.
const char* key_that_ends_rays(const Scene& scene, const double (&q)[3]);

/// Returns true if no ray can start at q because the scene states an Ω that is not greater than 0 there. q is relative
/// to the centre of the space.
bool has_invalid_time_rescaling(const Scene& scene, const double (&q)[3]);

/// Returns true if no ray can start at q because a formula's domain, capture or length_scale is NaN there, or
/// length_scale is not greater than 0. Returns false where domain or capture is 0 or less, because rays end there. q is
/// relative to the centre of the space.
bool has_invalid_bounds(const Scene& scene, const double (&q)[3]);

/// Returns the unit in which the step of a method is measured, with or without time rescaling.
StepKind step_kind(const Scene& scene, std::uint32_t integrator, bool rescaled);

/// Returns null if a method supports the scene's space, else the reason. `rescaled` is ignored if the scene states a
/// formula or Ω, because these contain the rescaling.
const char* refusal_of(const Scene& scene, std::uint32_t integrator, bool rescaled);

/// Returns the name of the first method that supports the space and integrates the separated motion, or else the motion
/// in the orbit plane; null if there is none.
const char* supported_angular_method(const Scene& scene, bool separated);

/// Returns the reason why a ray failed, with the keys of this scene that may be the cause.
std::string why_failed(const Scene& scene, Precision precision, Failure failure);
/// Returns the reason why this ray failed. It contains the values of H at a jump.
std::string why_failed(const Scene& scene, Precision precision, const RayEnd& end);

}  // namespace kagero
