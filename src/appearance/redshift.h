/// Redshift of the light that the camera receives from disks and skies.
#pragma once

#include "appearance/pixel_sample.h"

namespace kagero {

/// Returns the coordinate velocity dx/dt of matter on a circular geodesic around the axis `normal` through the centre
/// of the space. q is the position of the matter, relative to `space.center`; around a hole, its coordinates are those
/// of Kerr and Schild. In Boyer-Lindquist coordinates, the angular velocity is dφ/dt = √M / (r^{3/2} + a √M) (Bardeen,
/// Press and Teukolsky 1972, eq. 2.16). It has the same value in Kerr-Schild coordinates. M is the mass of the hole,
/// and a is the hole's angular momentum per mass along `normal`. In spaces without a hole, the matter is at rest.
Double3 orbit_velocity(const Space& space, const Double3& normal, const Double3& q);

/// Returns g, the observed frequency divided by the emitted frequency. The light of a ray that ends on a disk comes
/// from orbiting matter. The light of an escaped ray comes from a source at rest at infinity. For all other rays, g is
/// 0. g is also 0 for the part of a disk inside the innermost light orbit: no matter can orbit there, so this part is
/// dark.
///
/// `spacetime` is true if observers have rest frames and light has a frequency. Otherwise, escaped rays have g = 1.
double redshift_of(const Space& space, bool spacetime, const std::vector<ObjectDescription>& objects,
                   const PixelSample& ray);

/// Throws InputError if the matter of a disk has no circular orbits. Around a hole, the centre of a disk must be that
/// of the hole. Around a spinning hole, the disk must also lie in the equatorial plane. The lengths in messages are
/// those of `scene` times `length_unit`, the unit of the scene file.
void check_disks(const Space& space, const SceneDescription& scene, double length_unit);

}  // namespace kagero
