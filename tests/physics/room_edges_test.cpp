// Tests that long steps do not let rays pass through the edges of a closed room. In long steps, the dense output on
// which a hit is found differs from the refined position by more than the distance of a ray from an edge.
#include "tests/support/plan_fixture.h"

#include "render/render.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

namespace kagero::test {
namespace {

constexpr std::uint32_t size = 1024;

/// Expects that all rays of the room are hit or captured. `objects` is appended to the scene.
void expect_closed(const std::string& objects, const char* method, const char* step, const char* precision) {
    SCOPED_TRACE(std::string(method) + " " + step + " " + precision);
    Options options;
    options.precision = precision_named(precision);
    std::ifstream room(std::string(KAGERO_SCENES) + "/room.toml");
    const std::string scene{std::istreambuf_iterator<char>(room), {}};
    const auto plan = plan_of_text(scene + objects,
                                   {std::string("integrator.method=") + method, std::string("integrator.step=") + step,
                                    "film.size=[1024,1024]"},
                                   options);
    Film film(size, size, {"status"});
    const RunReport report = render(*plan, film);
    const auto count = [&](Status status) { return report.counters.ended[static_cast<int>(status)]; };
    EXPECT_EQ(count(Status::hit) + count(Status::captured), std::uint64_t{size} * size);
    EXPECT_GT(count(Status::captured), 0u);
}

TEST(RoomEdges, AreClosedForLongSteps) {
    expect_closed("", "orbit-srkn6", "0.6", "double");
    expect_closed("", "orbit-srkn6", "0.6", "float");
    expect_closed("", "orbit-srkn6", "1.2", "float");
    expect_closed("", "orbit-srkn11", "1", "float");
    expect_closed("", "gauss8", "0.3", "double");
}

// Rays whose chord hits a small square, but which pass it, continue to the wall behind it.
TEST(RoomEdges, AreReachedByRaysThatPassASquare) {
    std::string squares;
    for (int i = 0; i < 16; ++i)
        squares += "\n[[object]]\nname = \"square " + std::to_string(i) + "\"\nshape = \"rectangle\"\norigin = [" +
                   std::to_string(-0.6 + 0.3 * (i % 4)) + ", 0.6, " + std::to_string(-0.6 + 0.3 * (i / 4)) +
                   "]\nedge_u = [0.15, 0.02, 0]\nedge_v = [0, 0.03, 0.15]\n";
    for (const char* precision : {"double", "float"}) {
        expect_closed(squares, "orbit-srkn6", "0.6", precision);
        expect_closed(squares, "orbit-srkn11", "1", precision);
    }
    expect_closed(squares, "gauss8", "0.3", "double");
}

}  // namespace
}  // namespace kagero::test
