/// How the light of orbiting matter changes its frequency on the way to the camera.
#pragma once

#include "appearance/pixel_sample.h"

namespace kagero {

/// dx/dt of matter at q, relative to `space.center`, that orbits freely about `normal` through the centre: with the
/// hole's mass M and angular momentum a, dφ/dt = √M / (r^{3/2} + a √M), r the radius of Boyer and Lindquist (Bardeen,
/// Press and Teukolsky 1972, eq. 2.16; a counts along the normal). In spaces without a hole it is at rest.
Double3 orbit_velocity(const Space& space, const Double3& normal, const Double3& q);

/// g, the frequency seen over the frequency sent, where a ray ends on a disk, or for a source at rest at infinity where
/// it escapes; 0 elsewhere, and within the innermost orbit of light, where no matter can orbit: there a disk is dark.
/// `spacetime`: the camera's observer has a rest frame.
double redshift_of(const Space& space, bool spacetime, const std::vector<ObjectDescription>& objects,
                   const PixelSample& ray);

/// Throws InputError for a disk whose matter has no orbits: a hole's disks lie about its centre, a spinning one's in
/// its equator. Lengths of the scene are in `length_unit`.
void check_disks(const Space& space, const SceneDescription& scene, double length_unit);

}  // namespace kagero
