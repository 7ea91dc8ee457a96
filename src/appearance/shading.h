/// Colours of surfaces and skies at a point.
#pragma once

#include "appearance/pyramid.h"
#include "geometry/geometry.h"

namespace kagero {

/// A paint with its image.
struct LoadedPaint {
    Paint paint;
    std::shared_ptr<const StoredImage> image;           ///< Null unless the paint is a texture.
    std::shared_ptr<const std::vector<Image>> coarser;  ///< Coarser mipmap levels, from coarser_images.
    std::shared_ptr<const ImageLevelTable> levels{};    ///< `image` and `coarser` for the kernels.
};

/// Data of an object for shading, in coordinates relative to `space.center`.
struct ShadedObject {
    const ObjectGeometry* geometry = nullptr;
    Shading shading{};
    std::vector<LoadedPaint> paints;    ///< Six for a box or room, otherwise one.
    std::optional<LoadedPaint> emission;  ///< The light that a part of a mesh file emits.
    std::vector<TriangleChart> charts;  ///< Maps from the triangles of the mesh to u and v, if a paint has a pattern.
    Double3 normal{};                   ///< Normal of a disk.
    double inner = 0, outer = 0;        ///< Radii of a disk.
    double temperature = 0;             ///< Temperature of a disk at its inner edge, in kelvin; 0 if it has a paint.
    double inverse_luminance = 0;       ///< 1 / luminance of a black body at `temperature`; 0 if it has a paint.
};

/// Returns true if the colour of a paint depends on the position: if it is a texture or a checker.
bool has_pattern(const LoadedPaint& paint);
/// Returns the temperature at which a disk appears that radiates as a black body, in kelvin. Its temperature is
/// T ∝ r^(−3/4), which holds far from the inner edge of a disk that radiates the gravitational energy of its matter
/// (Shakura and Sunyaev 1973). `redshift` is that of object_color.
double observed_temperature(const ShadedObject& disk, const Double3& point, double redshift);
/// Returns the normal of a triangle at a point, of any length. It is interpolated between the vertex normals. If there
/// are none, or if the result is zero, it is the geometric normal.
Double3 interpolated_normal(const TriangleMesh& mesh, std::uint32_t primitive, const Double3& point);
/// Returns the colour of a paint without a pattern.
Float3 plain_color(const Paint& paint);

/// Returns the paint of a triangle of an object.
const LoadedPaint& paint_of(const ShadedObject& object, std::uint32_t primitive);
/// Returns the texture coordinates of a point on a surface, with gradients. All are 0 on a mesh without u and v.
ChartPoint surface_coordinates(const ShadedObject& object, std::uint32_t primitive, const Double3& point);
/// Returns how a paint of an object continues beyond the edges of its image. The longitudes of a sphere and the angles
/// of a disk are periodic. On a mesh, the paint states it. On a rectangle or a face of a box, the texels at the edges
/// are continued.
Edges edges_of(const ShadedObject& object, const LoadedPaint& paint);
/// Returns |normal · ray_direction| with the shading `lambert`, otherwise 1. `ray_direction` is a unit vector.
double lambert_factor(const ShadedObject& object, std::uint32_t primitive, const Double3& point,
                      const Double3& ray_direction);

/// Returns the linear colour of a surface at `point`, relative to `space.center`. A pattern is averaged over the patch.
/// `ray_direction` is a unit vector. With the shading `lambert`, the light comes from the camera, and the colour is
/// multiplied by |normal · ray_direction|.
///
/// `redshift` is g, the observed frequency divided by the emitted frequency; only the colours of disks depend on it. If
/// a disk emits light of intensity I(ν), the observed intensity is g³ I(ν/g) (Liouville's theorem). A black body then
/// appears at g times its temperature, and a colour is g⁴ times as bright. If `black_body` is not null, it is the
/// colour of the black body, and `redshift` is not used for it.
Float3 object_color(const ShadedObject& object, std::uint32_t primitive, const Double3& point,
                    const Double3& ray_direction, double redshift, const Patch& patch,
                    const Float3* black_body = nullptr);

/// Returns the light that a part of a mesh file emits at a point, relative to `space.center`. It states its emission.
Float3 emission_color(const ShadedObject& object, std::uint32_t primitive, const Double3& point);

/// Returns the linear colour of the sky in a unit direction. A pattern is averaged over the filter's
/// footprint.
Float3 sky_color(const LoadedPaint& paint, const SkyAxes& axes, const Double3& direction, const SkyFilter& filter);

}  // namespace kagero
