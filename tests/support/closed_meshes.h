/// Closed convex meshes for the tests of hits.
#pragma once

#include "scene/vector3.h"

#include <array>
#include <cmath>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

namespace kagero::test {

/// The corners and triangles of a mesh. The corners are floats.
struct ClosedMesh {
    std::vector<Double3> corners;
    std::vector<std::array<std::size_t, 3>> triangles;

    /// Returns the text of an OBJ file.
    std::string obj() const {
        std::ostringstream text;
        text.precision(17);
        for (const auto& [x, y, z] : corners) text << "v " << x << ' ' << y << ' ' << z << '\n';
        for (const auto& [a, b, c] : triangles) text << "f " << a + 1 << ' ' << b + 1 << ' ' << c + 1 << '\n';
        return text.str();
    }
};

/// Returns a ball of this radius around the origin.
inline ClosedMesh ball_mesh(double radius, int columns = 48, int rows = 24) {
    ClosedMesh ball;
    for (int i = 1; i < rows; ++i)
        for (int k = 0; k < columns; ++k) {
            const double polar = i * std::numbers::pi / rows, azimuth = 2 * std::numbers::pi * (k + 0.3) / columns;
            Double3 corner =
                scaled({std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth), std::cos(polar)},
                       radius);
            for (double& x : corner) x = double(float(x));
            ball.corners.push_back(corner);
        }
    ball.corners.push_back({0, 0, radius});
    ball.corners.push_back({0, 0, -radius});
    const std::size_t north = ball.corners.size() - 2, south = ball.corners.size() - 1;
    const auto at = [columns](int i, int k) { return std::size_t((i - 1) * columns + k % columns); };
    for (int k = 0; k < columns; ++k) {
        ball.triangles.push_back({north, at(1, k), at(1, k + 1)});
        ball.triangles.push_back({south, at(rows - 1, k + 1), at(rows - 1, k)});
        for (int i = 1; i + 1 < rows; ++i) {
            ball.triangles.push_back({at(i, k), at(i + 1, k), at(i + 1, k + 1)});
            ball.triangles.push_back({at(i, k), at(i + 1, k + 1), at(i, k + 1)});
        }
    }
    return ball;
}

/// Returns a box around the origin that is rotated, so that its faces are not parallel to the axes.
inline ClosedMesh box_mesh(const Double3& half) {
    ClosedMesh box;
    const double c = std::cos(0.4), s = std::sin(0.4);
    for (int i = 0; i < 8; ++i) {
        const double x = (i & 1 ? 1 : -1) * half[0], y = (i & 2 ? 1 : -1) * half[1], z = (i & 4 ? 1 : -1) * half[2];
        const Double3 turned{c * x - s * y, s * x + c * y, z};
        Double3 corner{turned[0], c * turned[1] - s * turned[2], s * turned[1] + c * turned[2]};
        for (double& k : corner) k = double(float(k));
        box.corners.push_back(corner);
    }
    constexpr std::size_t faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                         {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    for (const auto& [a, b, d, e] : faces) {
        box.triangles.push_back({a, b, d});
        box.triangles.push_back({a, d, e});
    }
    return box;
}

}  // namespace kagero::test
