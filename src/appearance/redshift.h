/// Redshift of the light that the camera receives from disks and skies.
#pragma once

#include "appearance/pixel_sample.h"
#include "spaces/circular_orbits.h"
#include "spaces/time_dilation.h"

namespace kagero {

/// The sources of the light of a scene.
struct Sources {
    const Space* space = nullptr;
    const std::vector<ObjectDescription>* objects = nullptr;
    Skies skies;
    std::vector<CircularOrbits> orbits;  ///< Orbits of the matter of each object; empty if none are searched for.
    /// Time dilation of the matter of each object on circular orbits around a built-in hole; empty if there is none.
    std::vector<TimeDilation> dilations;
};

/// Returns the sources of a scene. Both arguments must outlive them. The orbits of disks whose velocity is not stated
/// are searched for in the space of a formula if `with_orbits` is true.
Sources make_sources(const Space& space, const SceneDescription& scene, bool with_orbits);

/// Returns the ranges of the distance in which there are no circular orbits, "between 1 and 1.5, and between …"; "" if
/// there are none. Lengths are multiplied by `length_unit`.
std::string ranges_at_rest(const CircularOrbits& orbits, double length_unit);

/// Returns remarks on disks whose matter has no circular orbits, or whose velocity is not below the speed of light.
/// Lengths in the remarks are multiplied by `length_unit`.
std::vector<std::string> remarks_on_matter(const Sources& sources, const SceneDescription& scene, double length_unit);

/// Returns the coordinate velocity dx/dt of matter on a circular geodesic around the axis `normal` through the centre
/// of the space. q is the position of the matter, relative to `space.center`; around a hole, its coordinates are those
/// of Kerr and Schild. In Boyer-Lindquist coordinates, the angular velocity is dφ/dt = √M / (r^{3/2} + a √M) (Bardeen,
/// Press and Teukolsky 1972, eq. 2.16). It has the same value in Kerr-Schild coordinates. M is the mass of the hole,
/// and a is the hole's angular momentum per mass along `normal`. In built-in spaces without a hole, the matter is at
/// rest.
Double3 orbit_velocity(const Space& space, const Double3& normal, const Double3& q);

/// Returns g, the observed frequency divided by the emitted frequency. The light of a ray that ends on a disk comes
/// from its matter, which has the stated velocity, or is on a circular orbit. In a formula, it is at rest where there
/// is no such orbit. The light of an escaped ray has the frequency frequency_at_sky at its source. For all other rays,
/// g is 0. g is also 0 for matter that would not be slower than light: around a built-in hole, for the part of a disk
/// inside the innermost light orbit. These parts are dark.
///
/// `spacetime` is true if observers have rest frames and light has a frequency. Otherwise, escaped rays have g = 1.
double redshift_of(const Sources& sources, bool spacetime, const PixelSample& ray);

/// Throws InputError if the matter of a disk without a stated velocity has no circular orbits, or if no part of a disk
/// with a stated velocity is slower than light. Around a hole, the centre of a disk must be that of the hole. Around a
/// spinning hole, the disk must also lie in the equatorial plane. The lengths in messages are those of `scene` times
/// `length_unit`, the unit of the scene file.
void check_disks(const Space& space, const SceneDescription& scene, double length_unit);

}  // namespace kagero
