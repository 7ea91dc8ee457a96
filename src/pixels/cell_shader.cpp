#include "pixels/cell_shader.h"

#include "adaptive/displacement.h"
#include "appearance/blackbody.h"
#include "appearance/redshift.h"
#include "rays/camera.h"
#include "rays/end_distance.h"
#include "scene/vector3.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kagero {
namespace {

/// Numbers of nodes and test rays of a RayCell, and the index of the node in its middle.
constexpr std::size_t node_count = 9, test_count = 4, middle_node = 4;

Double3 position_of(const RayEnd& end) { return {end.q[0], end.q[1], end.q[2]}; }
Double3 direction_of(const RayEnd& end) { return {end.v[0], end.v[1], end.v[2]}; }

/// Returns the value at test ray i of the biquadratic function with the given values at the nodes.
template <class Value>
double value_at_test(std::uint32_t i, const Value& value_at_node) {
    // Weights of the nodes at the positions 1/4 and 3/4 of an edge.
    constexpr double weights[2][3] = {{0.375, 0.75, -0.125}, {-0.125, 0.75, 0.375}};
    double sum = 0;
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t column = 0; column < 3; ++column)
            sum += weights[i / 2][row] * weights[i % 2][column] * value_at_node(3 * row + column);
    return sum;
}

/// Adds whole turns to u, so that it is at most half a turn away from `middle`.
void unwrap(double& u, double middle) { u -= std::round(u - middle); }

/// Returns the displacement along the surface that changes orthogonal texture coordinates by (du, dv).
Double3 displacement_of(const ChartPoint& at, double du, double dv) {
    const auto along = [](const Double3& gradient, double change) {
        const double square = dot(gradient, gradient);
        return square > 0 ? scaled(gradient, change / square) : Double3{};
    };
    return add(along(at.u_gradient, du), along(at.v_gradient, dv));
}

/// Returns the greatest angle between neighbouring pixels of a cell on a sphere, from the differences of its nodes.
double greatest_step(const std::array<ChartPoint, 9>& nodes, std::uint32_t edge) {
    double greatest = 0;
    for (std::size_t i = 0; i < 9; ++i)
        for (const std::size_t k : {i + 1, i + 3}) {
            if (k > 8 || (k == i + 1 && i % 3 == 2)) continue;
            const double cosine = std::cos(std::numbers::pi * (nodes[i].v - 0.5));
            greatest = std::max(greatest, std::hypot(2 * (nodes[k].u - nodes[i].u) * cosine, nodes[k].v - nodes[i].v));
        }
    return greatest * std::numbers::pi * 2 / edge;
}

void set_sphere(const ImageLevel& image, const std::array<ChartPoint, 9>& nodes, ShadedCell& shaded) {
    shaded.sphere_texel_x = 2 * std::numbers::pi / image.width;
    shaded.sphere_texel_y = std::numbers::pi / image.height;
    shaded.sphere_texel = std::min(shaded.sphere_texel_x, shaded.sphere_texel_y);
    for (std::size_t i = 0; i < 9; ++i) {
        const double latitude = std::numbers::pi * (nodes[i].v - 0.5);
        shaded.sine[i] = std::sin(latitude);
        shaded.cosine[i] = std::cos(latitude);
    }
}

/// Sets the positions at the nodes minus integers that are multiples of `multiple`.
void set_positions(const std::array<double, 9>& positions, double multiple, CellNodes& nodes, double& base) {
    base = multiple * std::floor(positions[middle_node] / multiple);
    for (std::size_t i = 0; i < 9; ++i) nodes[i] = positions[i] - base;
}

}  // namespace

CellShader::CellShader(const Plan& plan, const Tile& shown, Film& film)
    : plan_(plan), shown_(shown), width_(film.width()),
      colors_(film.layers().size() == 1 ? film.plane("color") : nullptr) {}

bool CellShader::shade(const RayCell& cell) const {
    if (!shades_cells()) return false;
    ShadedCell shaded{};
    shaded.edge = cell.edge;
    shaded.x0 = std::max(cell.x, shown_.x0) - cell.x;
    shaded.y0 = std::max(cell.y, shown_.y0) - cell.y;
    shaded.x1 = std::max(std::min(cell.x + cell.edge, shown_.x1), cell.x) - cell.x;
    shaded.y1 = std::max(std::min(cell.y + cell.edge, shown_.y1), cell.y) - cell.y;
    if (shaded.x0 >= shaded.x1 || shaded.y0 >= shaded.y1) return true;
    const std::size_t x = cell.x + shaded.x0 - shown_.x0, y = cell.y + shaded.y0 - shown_.y0;
    shaded.colors = colors_ + 3 * (y * width_ + x);
    shaded.row_length = 3 * std::size_t{width_};
    switch (cell.nodes[middle_node].status) {
        case Status::escaped: return shade_sky(cell, shaded);
        case Status::hit: return shade_surface(cell, shaded);
        default: plan_.module().shading.shade_cell(&shaded); return true;  // black
    }
}

bool CellShader::shade_sky(const RayCell& cell, ShadedCell& shaded) const {
    const Skies& skies = plan_.scene->sources.skies;
    if (plan_.description().camera.type == CameraType::orthographic) return false;  // directions have no bound
    const bool on_second_sheet = !skies.is_plain() && sky_view(skies, cell.nodes[middle_node]).on_second_sheet;
    const LoadedSky& sky = plan_.scene->paints->sky(on_second_sheet);
    Coordinates coordinates;
    const auto set = [&](const RayEnd& end, ChartPoint& point) {
        point = sky_uv(skies.is_plain() ? direction_of(end) : sky_view(skies, end).direction, sky.axes);
    };
    if (has_pattern(sky.paint)) {
        for (std::size_t i = 0; i < node_count; ++i) set(cell.nodes[i], coordinates.nodes[i]);
        for (std::size_t i = 0; i < test_count; ++i) set(cell.tests[i], coordinates.tests[i]);
    }
    if (!set_pattern(cell, {sky.paint, repeat_along_u, true, true}, coordinates, shaded)) return false;
    plan_.module().shading.shade_cell(&shaded);
    return true;
}

bool CellShader::shade_surface(const RayCell& cell, ShadedCell& shaded) const {
    const RayEnd& middle = cell.nodes[middle_node];
    const ShadedObject& object = plan_.scene->paints->object(middle.surface);
    const bool is_black = plan_.description().objects[middle.surface].material == Material::diffuse;
    if (is_black) {  // the light of diffuse surfaces is that of paths
        plan_.module().shading.shade_cell(&shaded);
        return true;
    }
    const LoadedPaint& paint = paint_of(object, middle.primitive);
    const Shape shape = object.geometry->shape;
    Coordinates coordinates;
    const auto set = [&](const RayEnd& end, ChartPoint& point) {
        point = surface_coordinates(object, end.primitive, position_of(end));
    };
    if (object.temperature > 0) {
        std::fill_n(shaded.color, 3, 1.0);
    } else {
        if (has_pattern(paint)) {
            for (std::size_t i = 0; i < node_count; ++i) set(cell.nodes[i], coordinates.nodes[i]);
            for (std::size_t i = 0; i < test_count; ++i) set(cell.tests[i], coordinates.tests[i]);
        }
        const bool on_sphere = shape == Shape::sphere, has_angle = on_sphere || shape == Shape::disk;
        const Pattern pattern{paint, edges_of(object, paint), has_angle, on_sphere};
        if (!set_pattern(cell, pattern, coordinates, shaded)) return false;
    }
    if (!set_lights(cell, shaded)) return false;
    plan_.module().shading.shade_cell(&shaded);
    return true;
}

bool CellShader::set_pattern(const RayCell& cell, const Pattern& pattern, Coordinates& coordinates,
                             ShadedCell& shaded) const {
    const Paint& paint = pattern.paint.paint;
    std::copy(paint.color.begin(), paint.color.end(), shaded.color);
    if (!has_pattern(pattern.paint)) return true;
    if (pattern.edges.along_u == BeyondEdge::mirror || pattern.edges.along_v == BeyondEdge::mirror) return false;
    if (pattern.has_angle) {
        const double middle = coordinates.nodes[middle_node].u;
        for (ChartPoint& node : coordinates.nodes) unwrap(node.u, middle);
        for (ChartPoint& test : coordinates.tests) unwrap(test.u, middle);
        if (!are_coordinates_accurate(cell, coordinates)) return false;
    }
    if (!pattern.paint.image) return set_checker(pattern, coordinates, shaded);
    if (!set_image(pattern, coordinates, shaded)) return false;
    if (!pattern.on_sphere) return true;
    // The stripes of the filter are approximated by parabolas.
    constexpr double max_step = 0.2, min_cosine = 0.1;
    set_sphere(shaded.image.levels[0], coordinates.nodes, shaded);
    const double least_cosine = *std::min_element(std::begin(shaded.cosine), std::end(shaded.cosine));
    return greatest_step(coordinates.nodes, cell.edge) < max_step && least_cosine > min_cosine;
}

bool CellShader::set_checker(const Pattern& pattern, const Coordinates& coordinates, ShadedCell& shaded) {
    const double columns = pattern.paint.paint.checker[0], rows = pattern.paint.paint.checker[1];
    // Around a sphere or disk, the colours alternate only if the number of squares is even.
    if (pattern.has_angle && std::fmod(columns, 2) != 0) return false;
    std::array<double, node_count> x, y;
    for (std::size_t i = 0; i < node_count; ++i) {
        x[i] = coordinates.nodes[i].u * columns;
        y[i] = coordinates.nodes[i].v * rows;
    }
    set_positions(x, 2, shaded.x, shaded.base[0]);  // the pattern repeats after two squares
    set_positions(y, 2, shaded.y, shaded.base[1]);
    constexpr double unlimited = 1e30;
    const bool ends_x = pattern.edges.along_u == BeyondEdge::clamp, ends_y = pattern.edges.along_v == BeyondEdge::clamp;
    shaded.has_checker = true;
    shaded.checker = {{ends_x ? 0 : -unlimited, ends_y ? 0 : -unlimited},
                      {ends_x ? columns : unlimited, ends_y ? rows : unlimited}};
    return true;
}

bool CellShader::set_image(const Pattern& pattern, const Coordinates& coordinates, ShadedCell& shaded) {
    if (pattern.paint.paint.factor != Double3{1, 1, 1}) return false;  // cells have no factor for colours of images
    shaded.image = pattern.paint.levels->levels(pattern.edges);
    const ImageLevel& image = shaded.image.levels[0];
    std::array<double, node_count> x, y;
    for (std::size_t i = 0; i < node_count; ++i) {
        x[i] = coordinates.nodes[i].u * image.width - 0.5;
        y[i] = (1 - coordinates.nodes[i].v) * image.height - 0.5;
    }
    set_positions(x, 1, shaded.x, shaded.base[0]);
    set_positions(y, 1, shaded.y, shaded.base[1]);
    return true;
}

bool CellShader::are_coordinates_accurate(const RayCell& cell, const Coordinates& coordinates) const {
    const auto u = [&](std::size_t i) { return coordinates.nodes[i].u; };
    const auto v = [&](std::size_t i) { return coordinates.nodes[i].v; };
    constexpr double margin = 1.25;          // the error of the ray ends may be as large as the bound
    const double inverse = 1.0 / cell.edge;  // the mean of two differences over half an edge
    for (std::uint32_t i = 0; i < 4; ++i) {
        const ChartPoint& test = coordinates.tests[i];
        const std::size_t a = i % 2 + 3 * (i / 2), b = a + 1, c = a + 3, d = a + 4;
        const auto slope = [&](const auto& f, bool is_down) {
            return inverse * (is_down ? f(c) + f(d) - f(a) - f(b) : f(b) + f(d) - f(a) - f(c));
        };
        const EndDerivatives derivatives{displacement_of(test, slope(u, false), slope(v, false)),
                                         displacement_of(test, slope(u, true), slope(v, true))};
        const Double3 error = displacement_of(test, value_at_test(i, u) - test.u, value_at_test(i, v) - test.v);
        if (!(displacement_in_pixels(derivatives, error, pixel_size_at(plan_, cell.tests[i])) <=
              margin * plan_.run.interpolation_bound))
            return false;
    }
    return true;
}

double CellShader::redshift_at(const RayCell& cell, const std::array<std::uint32_t, 2>& at, const RayEnd& end) const {
    const CameraRay ray = camera_ray(plan_, cell.x + at[0] + 0.5, cell.y + at[1] + 0.5);
    PixelSample sample;
    sample.end = &end;
    sample.ray = &ray;
    return redshift_of(plan_.scene->sources, plan_.view.spacetime, sample);
}

CellShader::Lights CellShader::lights_of(const RayCell& cell) const {
    const ShadedObject& object = plan_.scene->paints->object(cell.nodes[middle_node].surface);
    const bool is_disk = object.geometry->shape == Shape::disk;
    constexpr std::uint32_t count = node_count + test_count;  // the nodes, then the test rays
    std::array<double, count> kelvin{};
    std::array<Double3, count> light;
    for (std::uint32_t i = 0; i < count; ++i) {
        const bool is_node = i < node_count;
        const std::uint32_t test = i - std::uint32_t{node_count};
        const RayEnd& end = is_node ? cell.nodes[i] : cell.tests[test];
        const double redshift =
            is_disk ? redshift_at(cell, is_node ? cell.node_position(i) : cell.test_position(test), end) : 1;
        const double moving = object.temperature > 0 ? object.inverse_luminance : std::pow(redshift, 4);
        light[i].fill(moving * lambert_factor(object, end.primitive, position_of(end), direction_of(end)));
        if (object.temperature > 0) kelvin[i] = observed_temperature(object, position_of(end), redshift);
    }
    if (object.temperature > 0) {
        std::array<Double3, count> rgb;
        blackbody_colors(plan_.module(), kelvin, rgb.data());
        for (std::size_t i = 0; i < count; ++i)
            for (std::size_t k = 0; k < 3; ++k) light[i][k] *= rgb[i][k];
    }
    Lights lights;
    std::copy_n(light.begin(), node_count, lights.nodes.begin());
    std::copy_n(light.begin() + node_count, test_count, lights.tests.begin());
    return lights;
}

bool CellShader::set_lights(const RayCell& cell, ShadedCell& shaded) const {
    const ShadedObject& object = plan_.scene->paints->object(cell.nodes[middle_node].surface);
    const bool has_light = object.geometry->shape == Shape::disk || object.shading == Shading::lambert;
    if (!has_light) return true;
    const Lights lights = lights_of(cell);
    shaded.lights = object.temperature > 0 ? 3 : 1;
    constexpr double half_unit = 1.0 / 1024;  // of the 16-bit floats in which pictures store colours
    for (std::size_t k = 0; k < shaded.lights; ++k) {
        double greatest = 0, slope = 0;
        for (std::size_t i = 0; i < 9; ++i) {
            shaded.light[k][i] = lights.nodes[i][k];
            greatest = std::max(greatest, lights.nodes[i][k]);
            for (const std::size_t next : {i + 1, i + 3})
                if (next < 9 && (next != i + 1 || i % 3 < 2))
                    slope = std::max(slope, std::abs(lights.nodes[next][k] - lights.nodes[i][k]) * 2 / cell.edge);
        }
        // The second term is the change of the light over the bound on the error of positions.
        const double tolerance = std::max(half_unit * greatest, plan_.run.interpolation_bound * slope);
        for (std::uint32_t i = 0; i < 4; ++i) {
            const double error =
                value_at_test(i, [&](std::size_t node) { return shaded.light[k][node]; }) - lights.tests[i][k];
            if (!(std::abs(error) <= tolerance)) return false;
        }
    }
    return true;
}

}  // namespace kagero
