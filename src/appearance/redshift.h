/// Redshift of the light that the camera receives from disks and skies.
#pragma once

#include "appearance/pixel_sample.h"

namespace kagero {

/// Returns the coordinate velocity dx/dt of matter on a free circular orbit around the axis `normal` through the
/// centre. q is the position of the matter, relative to `space.center`. In Boyer-Lindquist coordinates, the angular
/// velocity is dφ/dt = √M / (r^{3/2} + a √M) (Bardeen, Press and Teukolsky 1972, eq. 2.16). M is the mass of the hole,
/// and a is the hole's angular momentum per mass along the normal. In spaces without a hole, the matter is at rest.
Double3 orbit_velocity(const Space& space, const Double3& normal, const Double3& q);

/// Returns g, the observed frequency divided by the emitted frequency. The light of a ray that ends on a disk comes
/// from orbiting matter. The light of an escaped ray comes from a source at rest at infinity. For all other rays, g is
/// 0. It is also 0 for the part of a disk inside the innermost light orbit: no matter can orbit there, so this part is
/// dark.
///
/// `spacetime` is true if the camera's observer has a rest frame. Otherwise, escaped rays have g = 1.
double redshift_of(const Space& space, bool spacetime, const std::vector<ObjectDescription>& objects,
                   const PixelSample& ray);

/// Throws InputError if the matter of a disk has no circular orbits. Around a hole, the centre of a disk must be that
/// of the hole. Around a spinning hole, the disk must also lie in the equatorial plane. Messages contain lengths
/// of the scene file: those of `scene` times `length_unit`.
void check_disks(const Space& space, const SceneDescription& scene, double length_unit);

}  // namespace kagero
