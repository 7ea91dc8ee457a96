/// Mean colours of images over the footprints and patches of rays, from copies of decreasing resolution (mipmaps).
#pragma once

#include "appearance/texture.h"
#include "film/image.h"
#include "kernels/abi.h"
#include "kernels/shading_cell.h"

#include <span>

namespace kagero {

/// Mapping of an image to a plane, or to a sphere by equirectangular projection.
enum class Mapping { plane, sphere };

/// Computes copies of an image with decreasing resolution. Rows of the image are added from the top, so that the copies
/// are computed while the image is read. Each copy has half the rows and columns of the previous one, rounded down. The
/// last copy has one texel, the mean over the plane or sphere. Texels are weighted by their areas on the plane or
/// sphere. A row of a copy is added to the next copy as soon as it is complete.
class ImageReduction {
public:
    /// Prepares the copies of an image of this size.
    ImageReduction(int width, int height, Mapping mapping);
    /// Adds the next rows of the image, so that rows 0 to `end` − 1 have been added.
    void add_rows(const StoredImage& image, int end);
    /// Returns the copies, after all rows of the image have been added.
    std::vector<Image> take_images();

private:
    /// A pair of overlapping cells of an axis: a texel, and a texel of the next copy.
    struct Overlap {
        int source, target;
        float weight;  ///< Weight of the source in the target.
    };
    /// A copy, and the overlaps with the texels from which it is computed.
    struct Level {
        Image image;
        std::vector<Overlap> columns, rows;
        std::vector<float> reduced_row{};  ///< A source row, reduced to the columns of the copy.
        int source_rows = 0;               ///< Number of source rows that were added.
        std::size_t next = 0;              ///< Index of the first element of `rows` whose source was not added.
    };
    void add_row(std::size_t level, const float* row);

    std::vector<Level> levels_;
    int added_rows_ = 0;
};

/// Returns the copies of a whole image, computed by ImageReduction.
std::vector<Image> coarser_images(const StoredImage& image, Mapping mapping = Mapping::sphere);

/// Lists an image and its coarser copies, which must outlive it.
class ImageLevelTable {
public:
    ImageLevelTable(const StoredImage& image, const std::vector<Image>& coarser);
    /// Returns the levels. The result is valid as long as this object.
    ImageLevels levels(Edges edges) const;

private:
    ImageLevels::Components components_{};
    const float* linear_ = nullptr;
    std::vector<ImageLevel> levels_;
};

/// The copies of an image and the number of points in which it is probed, for its mean over a stripe.
struct Probes {
    /// Copy whose texels are as large as the stripe is wide, as a real number: 0 is the image, and i is coarser[i − 1].
    double level = 0;
    int count = 1;  ///< Number of probes along the stripe, 1 to 16.

    Probes() = default;
    /// Computes both from the length and the width of a stripe, in texels. The width is increased to at least one texel
    /// and at least 1/16 of the length.
    Probes(double length, double width);
};

/// A footprint around a direction, and the probes in the image of the sky. Without an image, there is one probe.
struct SkyFilter {
    Footprint footprint{};
    Probes probes{};
};
/// Returns the size of a texel in radians: the shorter side of a texel on the equator.
double texel_on_sphere(const StoredImage& image);
/// Returns the filter with which an image is averaged over a footprint.
SkyFilter sky_filter(const StoredImage& image, const Footprint& footprint);

/// Returns the image's mean colour over a footprint around a direction: the mean of the probes along the footprint's
/// long axis. A probe interpolates trilinearly between the two copies whose texels are closest in size to the short
/// axis (L. Williams, SIGGRAPH 1983). If the footprint is smaller than a texel, the result is the bilinear
/// interpolation of the image.
Float3 sky_texture_color(const StoredImage& image, const std::vector<Image>& coarser, const Double3& direction,
                         const SkyAxes& axes, const SkyFilter& filter);

/// Sets `colors` to those of sky_texture_color at the first points of a list for which the kernel module has computed
/// texture coordinates and filters. The module also computes the texture coordinates along bent stripes.
void sky_texture_colors(const StoredImage& image, const std::vector<Image>& coarser, const Module& module,
                        const SkyPoints& points, std::span<Float3> colors);

/// Returns the image's mean colour over a patch around a point on a sphere, computed as in sky_texture_color.
/// `from_center` is the point relative to the centre, and `right` and `below` are the sides of the patch.
Float3 sphere_texture_color(const StoredImage& image, const std::vector<Image>& coarser, const Double3& from_center,
                            const Double3& right, const Double3& below);

/// Returns the image's mean colour over a patch around the point (u, v) of a surface, computed as in sky_texture_color.
Float3 surface_texture_color(const StoredImage& image, const std::vector<Image>& coarser, double u, double v,
                             const UvPatch& patch, Edges edges);

}  // namespace kagero
