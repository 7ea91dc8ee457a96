// Without a hole the room is a picture that can be worked out with a ruler: where each ray meets which wall, and which
// square there. kagero's must be the same wherever that point is farther than a thousandth of a pixel from an edge; its
// colour is the mean over the pixel, so it must be the square's own wherever the pixel lies within one, and near the
// ruler's mean where it lies across some.
#include "tests/support/plan_fixture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace kagero::test {
namespace {

constexpr std::uint32_t size = 256;

Double3 add(const Double3& a, double s, const Double3& b) {
    return {a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]};
}
Double3 cross(const Double3& a, const Double3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Double3 unit(const Double3& a) {
    return add({0, 0, 0}, 1 / std::hypot(a[0], a[1], a[2]), a);
}

/// A pinhole camera with square pixels, row 0 on top.
struct Pinhole {
    Double3 eye, forward, right, up;
    double pixel;

    explicit Pinhole(const CameraDescription& c)
        : eye(c.position),
          forward(unit(add(c.look_at, -1, c.position))),
          right(unit(cross(forward, c.up))),
          up(cross(right, forward)),
          pixel(2 * std::tan(c.fov * std::numbers::pi / 360) / size) {}
    Double3 direction(double x, double y) const {
        return unit(add(add(forward, (x - 0.5 * size) * pixel, right), (0.5 * size - y) * pixel, up));
    }
};

/// What a straight ray meets in the room [−1, 1]³: face in the order px nx py ny pz nz, its checker square, the point.
struct View {
    int face, column, row;
    Double3 point;
    bool operator==(const View& o) const { return face == o.face && column == o.column && row == o.row; }
};

View look(const ObjectDescription& room, const Double3& eye, const Double3& d) {
    View view{-1, 0, 0, {}};
    double nearest = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
        const auto k = static_cast<std::size_t>(axis);
        const double t = (std::copysign(1.0, d[k]) - eye[k]) / d[k];
        if (t < nearest) nearest = t, view.face = 2 * axis + (d[k] < 0);
    }
    view.point = add(eye, nearest, d);
    // u to the right and v up as seen from inside; on floor and ceiling +y is up.
    const auto [x, y, z] = view.point;
    const double u[6] = {-y, y, x, -x, -x, x}, v[6] = {z, z, z, z, y, y};
    const auto& squares = room.faces[static_cast<std::size_t>(view.face)].checker;
    view.column = static_cast<int>(std::floor(0.5 * (u[view.face] + 1) * squares[0]));
    view.row = static_cast<int>(std::floor(0.5 * (v[view.face] + 1) * squares[1]));
    return view;
}

double brightness(const View& view) {
    return (view.column + view.row) % 2 ? 0.25 : 1.0;
}

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

TEST_P(StraightRoom, IsTheRulersPicture) {
    const auto p = plan();
    ASSERT_TRUE(p->scene->straight);
    const ObjectDescription& room = p->description().objects[0];
    const Pinhole camera(p->description().camera);
    Film film(size, size, p->description().film.layers);
    const RunReport report = render(*p, film);
    EXPECT_EQ(report.counters.ended[static_cast<int>(Status::hit)], std::uint64_t{size} * size);
    EXPECT_EQ(report.counters.gradients, 0u);
    int near_edges = 0, within_squares = 0, wrong = 0;
    std::vector<double> off_mean;
    for (std::uint32_t y = 0; y < size; ++y)
        for (std::uint32_t x = 0; x < size; ++x) {
            const auto at = [&](double dx, double dy) {
                return look(room, camera.eye, camera.direction(x + 0.5 + dx, y + 0.5 + dy));
            };
            const View seen = at(0, 0);
            constexpr double margin = 1e-3;
            if (!(at(margin, 0) == seen && at(-margin, 0) == seen && at(0, margin) == seen && at(0, -margin) == seen)) {
                ++near_edges;
                continue;
            }
            const Double3& paint = room.faces[static_cast<std::size_t>(seen.face)].color;
            double shade = brightness(seen);
            // Patches are those of blocks of pixels: a little off where the wall is seen from near its plane.
            bool within_square = true, within_face = true;
            for (const double dx : {-0.55, 0.55})
                for (const double dy : {-0.55, 0.55}) {
                    const View corner = at(dx, dy);
                    within_square &= corner == seen, within_face &= corner.face == seen.face;
                }
            const float* color = film.pixel("color", x, y);
            const double depth =
                std::hypot(seen.point[0] - camera.eye[0], seen.point[1] - camera.eye[1], seen.point[2] - camera.eye[2]);
            bool right = *film.pixel("status", x, y) == 0 && *film.pixel("object", x, y) == 1;
            // Half an ulp of float for the colour's rounding and one for the depth's.
            within_squares += within_square;
            for (std::size_t k = 0; k < 3 && within_square; ++k) right &= std::abs(color[k] - paint[k] * shade) <= 6e-8;
            if (!within_square && within_face) {
                shade = 0;
                constexpr int n = 12;
                for (int i = 0; i < n * n; ++i)
                    shade += brightness(at((i % n + 0.5) / n - 0.5, (i / n + 0.5) / n - 0.5)) / (n * n);
                off_mean.push_back(color[0] / paint[0] - shade);
            }
            right &= std::abs(*film.pixel("depth", x, y) - depth) <= 1.2e-7 * depth;
            if (!right && ++wrong <= 5)
                ADD_FAILURE() << "pixel " << x << "," << y << ": face " << seen.face << " square " << seen.column << ","
                              << seen.row << ", but colour " << color[0] << " " << color[1] << " " << color[2]
                              << ", depth " << *film.pixel("depth", x, y) << " for " << depth;
        }
    EXPECT_EQ(wrong, 0);
    EXPECT_GT(within_squares, int(size * size / 2));
    double sum2 = 0;
    for (const double off : off_mean) {
        sum2 += off * off;
        EXPECT_LT(std::abs(off), 0.2);
    }
    EXPECT_GT(off_mean.size(), std::size_t{2000});
    EXPECT_LT(std::sqrt(sum2 / double(off_mean.size())), 0.02);
    // Edges cross some 30 pixel columns and rows; 2e-3 of what they cross is too near.
    EXPECT_LT(near_edges, size * 60 * 2e-3 * 10);
}

// The same rays in double: hits are Newton's on planes through corners of size 1, so a few roundings of a coordinate
// remain, over the sine of the angle at which the ray meets the wall.
TEST_P(StraightRoom, HitsLieWhereTheRulerSays) {
    const auto p = plan();
    const Pinhole camera(p->description().camera);
    std::vector<RayStart> starts;
    std::vector<View> views;
    for (std::uint32_t y = 0; y < size; y += 5)
        for (std::uint32_t x = 0; x < size; x += 3) {
            starts.push_back(pixel_ray(*p, x, y));
            views.push_back(look(p->description().objects[0], camera.eye, camera.direction(x + 0.5, y + 0.5)));
        }
    std::vector<RayEnd> ends;
    trace(*p, starts, ends);
    for (std::size_t i = 0; i < ends.size(); ++i) {
        ASSERT_EQ(ends[i].status, Status::hit);
        const auto axis = static_cast<std::size_t>(views[i].face / 2);
        EXPECT_EQ(static_cast<int>(ends[i].primitive / 2), views[i].face);
        EXPECT_EQ(ends[i].gradients, 0u);
        const double rounding = 8 * std::numeric_limits<double>::epsilon();
        for (std::size_t k = 0; k < 3; ++k)
            EXPECT_NEAR(ends[i].q[k], views[i].point[k], rounding / std::abs(ends[i].v[axis]));
    }
}

INSTANTIATE_TEST_SUITE_P(Spaces, StraightRoom,
                         testing::Combine(testing::Values("packet", "scalar"), testing::Values("no_hole", "flat")),
                         [](const auto& chosen) {
                             return std::string(std::get<0>(chosen.param)) + "_" + std::get<1>(chosen.param);
                         });

}  // namespace
}  // namespace kagero::test
