/// Colours of cells of pixels in which ray ends are interpolated.
#pragma once

#include "film/film.h"
#include "kernels/shading_cell.h"
#include "plan/plan.h"
#include "rays/ray_cell.h"

namespace kagero {

/// Shades a cell as one unit. The position in the pattern of the sky or surface and the light of the surface are
/// computed for the traced rays of the cell, and the kernel module interpolates them for its pixels. Nothing is stored
/// for single pixels but their colours.
class CellShader {
public:
    /// Writes to `film`, which covers the rectangle `shown` of the picture. All arguments must outlive this object.
    CellShader(const Plan& plan, const Tile& shown, Film& film);
    /// Returns true if the film has no layers other than colours. Otherwise, no cell is shaded.
    bool shades_cells() const { return colors_; }
    /// Computes those pixels of a cell that the film covers. Returns false and computes nothing if the film has layers
    /// other than colours, or if the interpolated quantities are not accurate enough at the test rays of the cell. The
    /// error of a position in a pattern may be 1.25 times the bound on the error of ray ends.
    bool shade(const RayCell& cell) const;

private:
    /// A pattern: the paint, its continuation beyond the edges, whether u is an angle, and whether it covers a sphere.
    struct Pattern {
        const LoadedPaint& paint;
        Edges edges;
        bool has_angle, on_sphere;
    };
    /// Texture coordinates of the nodes and test rays, and their gradients at the test rays.
    struct Coordinates {
        std::array<ChartPoint, 9> nodes;
        std::array<ChartPoint, 4> tests;
    };
    /// The light at the nodes and test rays: factors of the colours of the pattern.
    struct Lights {
        std::array<Double3, 9> nodes;
        std::array<Double3, 4> tests;
    };

    bool shade_sky(const RayCell& cell, ShadedCell& shaded) const;
    bool shade_surface(const RayCell& cell, ShadedCell& shaded) const;
    bool set_pattern(const RayCell& cell, const Pattern& pattern, Coordinates& coordinates, ShadedCell& shaded) const;
    /// Set the positions of the nodes in the squares of a checker, or in the texels of an image. They return false if
    /// the kernel module cannot shade the cell.
    static bool set_checker(const Pattern& pattern, const Coordinates& coordinates, ShadedCell& shaded);
    static bool set_image(const Pattern& pattern, const Coordinates& coordinates, ShadedCell& shaded);
    bool are_coordinates_accurate(const RayCell& cell, const Coordinates& coordinates) const;
    bool set_lights(const RayCell& cell, ShadedCell& shaded) const;
    Lights lights_of(const RayCell& cell) const;
    /// Returns the factor that the motion of a disk's matter applies to its temperature.
    double redshift_at(const RayCell& cell, const std::array<std::uint32_t, 2>& at, const RayEnd& end) const;

    const Plan& plan_;
    const Tile& shown_;
    std::uint32_t width_;
    float* colors_;  ///< The plane of colours; null if the film has other layers.
};

}  // namespace kagero
