/// A loaded scene: its space, surfaces and paints. Nothing changes it after it is made, so any number of threads and
/// plans may share it.
#pragma once

#include "appearance/paints.h"
#include "geometry/geometry.h"
#include "modules/space.h"
#include "plan/options.h"

#include <memory>

namespace kagero {

/// Where rays end that meet no surface; distances from the space's origin.
struct RayLimits {
    double escape_radius = 0;        ///< rays that leave this sphere are escaped
    double inner_escape_radius =
        0;  ///< rays that enter this sphere are escaped into a wormhole's other universe; 0: there is none
    /// A ray that falls inward and cannot come out is captured within this |(x, y, stretch z)|, where nothing can be
    /// met further in.
    double capture_within = std::numeric_limits<double>::infinity(), capture_stretch = 1;
};

struct Scene {
    SceneDescription description;  ///< lengths in `unit`
    Space space;
    std::vector<double> programs;  ///< of Ω(H − H0), which is integrated where the scene rescales a compiled H by an
                                   ///< expression; else empty
    double unit = 1;               ///< in lengths of the scene as written; a power of two
    bool straight = false;         ///< every ray is a straight line: no integrator runs
    RayLimits limits;
    std::unique_ptr<const SceneGeometry> geometry;
    std::unique_ptr<const Paints> paints;

    const Module& module() const { return *space.module; }
    /// The Hamiltonian that is integrated: that of the space, or the formula that rescales it.
    std::uint32_t integrated_hamiltonian() const;
    const double* integrated_parameters() const { return programs.empty() ? space.parameters.data() : programs.data(); }
};

/// The names that scenes may use, from the module for `isa`.
Catalogue catalogue(const std::string& isa);

/// Loads the module, compiles formulas, and loads meshes and (for pictures) images. Throws InputError for what cannot
/// be used.
std::shared_ptr<const Scene> make_scene(SceneDescription description, const Options& options, Purpose purpose);

/// The diagonal of its objects, or the radius of the escape sphere where there are none, in lengths of the scene as
/// written.
double scene_size(const Scene& scene);

/// Whether the scene states by which expression H is rescaled; the rescaled H is then always integrated.
bool states_rescaling(const Scene& scene);

/// Whether Ω, where the scene states it, is not greater than 0 at q, relative to the centre: no ray can start there.
bool lacks_pace(const Scene& scene, const double (&q)[3]);

/// Whether a formula's domain, capture or length_scale is not a number at q, or that length is not greater than 0: no
/// ray can start there.
bool lacks_bounds(const Scene& scene, const double (&q)[3]);

/// The unit in which a method's step is counted, with H rescaled or not.
StepKind step_kind(const Scene& scene, std::uint32_t integrator, bool rescaled);

/// Null where a method serves the scene's space, else the reason. A formula states itself whether it is rescaled.
const char* refusal_of(const Scene& scene, std::uint32_t integrator, bool rescaled);

/// Why a ray failed on its way, with the parts of this scene that may have caused it.
std::string why_failed(const Scene& scene, Precision precision, Failure failure);

}  // namespace kagero
