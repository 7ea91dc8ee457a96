// Tests of the picture of a room without a black hole. It is compared with the exact intersections of straight rays and
// walls. Pixels whose centre is within 1/1000 of a pixel of an edge of a square are left out. A pixel that lies in one
// square of the checker must have the colour of the square. Other pixels must have about the mean over the squares that
// they cover.
#include "tests/support/plan_fixture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace kagero::test {
namespace {

constexpr std::uint32_t size = 256;

/// Returns a + s b.
Double3 add_scaled(const Double3& a, double s, const Double3& b) {
    return {a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]};
}
Double3 cross(const Double3& a, const Double3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Double3 unit(const Double3& a) {
    return add_scaled({0, 0, 0}, 1 / std::hypot(a[0], a[1], a[2]), a);
}

/// A pinhole camera with square pixels. Row 0 is at the top.
struct Pinhole {
    Double3 eye, forward, right, up;
    double pixel;

    explicit Pinhole(const CameraDescription& c)
        : eye(c.position),
          forward(unit(add_scaled(c.look_at, -1, c.position))),
          right(unit(cross(forward, c.up))),
          up(cross(right, forward)),
          pixel(2 * std::tan(c.fov * std::numbers::pi / 360) / size) {}
    Double3 direction(double x, double y) const {
        return unit(add_scaled(add_scaled(forward, (x - 0.5 * size) * pixel, right), (0.5 * size - y) * pixel, up));
    }
};

/// The hit of a straight ray in the room [−1, 1]³: the index of the face in the order px nx py ny pz nz, the column and
/// row of the square of its checker, and the point.
struct Hit {
    int face, column, row;
    Double3 point;
    /// Returns true for hits in the same square.
    bool operator==(const Hit& o) const { return face == o.face && column == o.column && row == o.row; }
};

/// Returns the hit of the ray from `eye` in the direction d.
Hit exact_hit(const ObjectDescription& room, const Double3& eye, const Double3& d) {
    Hit hit{-1, 0, 0, {}};
    double nearest = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
        const auto k = static_cast<std::size_t>(axis);
        const double t = (std::copysign(1.0, d[k]) - eye[k]) / d[k];
        if (t < nearest) {
            nearest = t;
            hit.face = 2 * axis + (d[k] < 0);
        }
    }
    hit.point = add_scaled(eye, nearest, d);
    // Seen from inside, u increases to the right and v upward. On floor and ceiling, v increases with y.
    const auto [x, y, z] = hit.point;
    const double u[6] = {-y, y, x, -x, -x, x}, v[6] = {z, z, z, z, y, y};
    const auto& squares = room.faces[static_cast<std::size_t>(hit.face)].checker;
    hit.column = static_cast<int>(std::floor(0.5 * (u[hit.face] + 1) * squares[0]));
    hit.row = static_cast<int>(std::floor(0.5 * (v[hit.face] + 1) * squares[1]));
    return hit;
}

double brightness(const Hit& hit) {
    return (hit.column + hit.row) % 2 ? 0.25 : 1.0;
}

/// The parameters are the strategy and the space: `flat`, or `no_hole` for a black hole of radius 0.
class StraightRoom : public testing::TestWithParam<std::tuple<const char*, const char*>> {
protected:
    static std::unique_ptr<Plan> plan() {
        const auto [strategy, space] = GetParam();
        Overrides overrides{"film.size=[" + std::to_string(size) + "," + std::to_string(size) + "]",
                            "film.layers=[\"color\",\"status\",\"object\",\"gradients\",\"depth\"]"};
        if (space == std::string("flat")) {
            std::string text;
            std::ifstream file(KAGERO_SCENES "/room.toml");
            for (std::string line; std::getline(file, line);)
                if (line.rfind("rg", 0) != 0) text += line + '\n';
            overrides.push_back("space.hamiltonian=flat");
            return plan_of_text(text, overrides, with_strategy(strategy));
        }
        overrides.push_back("space.rg=0");
        return plan_of_file(KAGERO_SCENES "/room.toml", overrides, with_strategy(strategy));
    }
};

TEST_P(StraightRoom, HasTheColorsAndDepthsOfExactHits) {
    const auto p = plan();
    ASSERT_TRUE(p->scene->straight);
    const ObjectDescription& room = p->description().objects[0];
    const Pinhole camera(p->description().camera);
    Film film(size, size, p->description().film.layers);
    const RunReport report = render(*p, film);
    EXPECT_EQ(report.counters.ended[static_cast<int>(Status::hit)], std::uint64_t{size} * size);
    EXPECT_EQ(report.counters.gradients, 0u);
    int near_edges = 0, within_squares = 0, wrong_pixels = 0;
    std::vector<double> errors;  // of pixels that cover several squares
    for (std::uint32_t y = 0; y < size; ++y)
        for (std::uint32_t x = 0; x < size; ++x) {
            const auto at = [&](double dx, double dy) {
                return exact_hit(room, camera.eye, camera.direction(x + 0.5 + dx, y + 0.5 + dy));
            };
            const Hit hit = at(0, 0);
            constexpr double margin = 1e-3;
            if (!(at(margin, 0) == hit && at(-margin, 0) == hit && at(0, margin) == hit && at(0, -margin) == hit)) {
                ++near_edges;
                continue;
            }
            const Double3& paint = room.faces[static_cast<std::size_t>(hit.face)].color;
            double shade = brightness(hit);
            // The patch of a pixel follows from a block of 2 × 2 pixels. Because of perspective, the patch can be a
            // little larger than the pixel.
            bool within_square = true, within_face = true;
            for (const double dx : {-0.55, 0.55})
                for (const double dy : {-0.55, 0.55}) {
                    const Hit corner = at(dx, dy);
                    within_square &= corner == hit;
                    within_face &= corner.face == hit.face;
                }
            const float* color = film.pixel("color", x, y);
            const double depth =
                std::hypot(hit.point[0] - camera.eye[0], hit.point[1] - camera.eye[1], hit.point[2] - camera.eye[2]);
            bool is_correct = *film.pixel("status", x, y) == 0 && *film.pixel("object", x, y) == 1;
            // The tolerances are half an ulp of float for the colour, and one ulp for the depth.
            within_squares += within_square;
            for (std::size_t k = 0; k < 3 && within_square; ++k)
                is_correct &= std::abs(color[k] - paint[k] * shade) <= 6e-8;
            if (!within_square && within_face) {
                shade = 0;
                constexpr int n = 12;
                for (int i = 0; i < n * n; ++i)
                    shade += brightness(at((i % n + 0.5) / n - 0.5, (i / n + 0.5) / n - 0.5)) / (n * n);
                errors.push_back(color[0] / paint[0] - shade);
            }
            is_correct &= std::abs(*film.pixel("depth", x, y) - depth) <= 1.2e-7 * depth;
            if (!is_correct && ++wrong_pixels <= 5)
                ADD_FAILURE() << "pixel " << x << "," << y << ": face " << hit.face << " square " << hit.column << ","
                              << hit.row << ", but colour " << color[0] << " " << color[1] << " " << color[2]
                              << ", depth " << *film.pixel("depth", x, y) << " for " << depth;
        }
    EXPECT_EQ(wrong_pixels, 0);
    EXPECT_GT(within_squares, int(size * size / 2));
    double sum2 = 0;
    for (const double error : errors) {
        sum2 += error * error;
        EXPECT_LT(std::abs(error), 0.2);
    }
    EXPECT_GT(errors.size(), std::size_t{2000});
    EXPECT_LT(std::sqrt(sum2 / double(errors.size())), 0.02);
    // About 60 edges cross the picture, and each excludes a strip of 2e-3 pixels. The bound allows ten times as many.
    EXPECT_LT(near_edges, size * 60 * 2e-3 * 10);
}

// The ray ends in double are compared with the exact hits. The tolerance is a few roundings of a coordinate, divided by
// the sine of the angle between ray and wall.
TEST_P(StraightRoom, HasExactHits) {
    const auto p = plan();
    const Pinhole camera(p->description().camera);
    std::vector<RayStart> starts;
    std::vector<Hit> hits;
    for (std::uint32_t y = 0; y < size; y += 5)
        for (std::uint32_t x = 0; x < size; x += 3) {
            starts.push_back(pixel_ray_start(*p, x, y));
            hits.push_back(exact_hit(p->description().objects[0], camera.eye, camera.direction(x + 0.5, y + 0.5)));
        }
    std::vector<RayEnd> ends;
    trace(*p, starts, ends);
    for (std::size_t i = 0; i < ends.size(); ++i) {
        ASSERT_EQ(ends[i].status, Status::hit);
        const auto axis = static_cast<std::size_t>(hits[i].face / 2);
        EXPECT_EQ(static_cast<int>(ends[i].primitive / 2), hits[i].face);
        EXPECT_EQ(ends[i].gradients, 0u);
        const double rounding = 8 * std::numeric_limits<double>::epsilon();
        for (std::size_t k = 0; k < 3; ++k)
            EXPECT_NEAR(ends[i].q[k], hits[i].point[k], rounding / std::abs(ends[i].v[axis]));
    }
}

INSTANTIATE_TEST_SUITE_P(Spaces, StraightRoom,
                         testing::Combine(testing::Values("packet", "scalar"), testing::Values("no_hole", "flat")),
                         [](const auto& instance) {
                             return std::string(std::get<0>(instance.param)) + "_" + std::get<1>(instance.param);
                         });

}  // namespace
}  // namespace kagero::test
