// Tests of the reader of rays: every double must be read exactly, and wrong text must be refused by an InputError.
#include "report/csv/read_rays.h"

#include "error.h"
#include "report/text/numbers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <random>
#include <sstream>

namespace {

using namespace kagero;

std::vector<RayInput> parse(const std::string& text) {
    std::istringstream in(text);
    return read_rays(in, "rays");
}

/// Returns a random normal double; all bit patterns are equally likely.
double random_double(std::mt19937_64& random) {
    while (true) {
        const double value = std::bit_cast<double>(random());
        if (std::isnormal(value)) return value;
    }
}

TEST(RaysCsv, IsReadWithExactDoubles) {
    std::mt19937_64 random(1);
    std::vector<double> values;
    std::string text = "x,y,z,dx,dy,dz\n";
    for (int row = 0; row < 1000; ++row)
        for (int column = 0; column < 6; ++column) {
            values.push_back(random_double(random));
            append_exact(text, values.back());
            text += column < 5 ? ',' : '\n';
        }
    const auto rays = parse(text);
    ASSERT_EQ(rays.size(), 1000u);
    for (std::size_t i = 0; i < rays.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k) {
            EXPECT_EQ(rays[i].position[k], values[6 * i + k]);
            EXPECT_EQ(rays[i].direction[k], values[6 * i + k + 3]);
        }
}

TEST(RaysCsv, CanContainFieldsInQuotes) {
    const auto rays = parse("\"x\", \"y\" ,z,dx,dy,dz\n\"1.5\",2,\"-3\",0,1,0\n");
    ASSERT_EQ(rays.size(), 1u);
    EXPECT_EQ(rays[0].position, (Double3{1.5, 2, -3}));
    for (const char* unclosed : {"\"", "\"x", "x\""})
        EXPECT_THROW(parse(std::string(unclosed) + ",y,z,dx,dy,dz\n"), InputError) << unclosed;
}

TEST(RaysCsv, CanContainInfinitiesAndNan) {
    const auto rays = parse("x,y,z,dx,dy,dz\ninf,-inf,nan,+1,-0,1e-3");
    ASSERT_EQ(rays.size(), 1u);
    EXPECT_EQ(rays[0].position[0], HUGE_VAL);
    EXPECT_EQ(rays[0].position[1], -HUGE_VAL);
    EXPECT_TRUE(std::isnan(rays[0].position[2]));
    EXPECT_EQ(rays[0].direction, (Double3{1, 0, 1e-3}));
}

TEST(RaysCsv, HasNoRaysIfItHasOnlyAHeader) {
    EXPECT_TRUE(parse("x,y,z,dx,dy,dz\r\n").empty());
}

// The limit on the length of a line prevents reading a binary file completely.
TEST(RaysCsv, IsRefusedIfALineIsTooLong) {
    const std::string header = "x,y,z,dx,dy,dz\n";
    const auto with_line_of = [&](std::size_t length) {
        return header + "1,2,3,4,5,6" + std::string(length - 11, ' ');
    };
    EXPECT_EQ(parse(with_line_of(9999)).size(), 1u);
    EXPECT_EQ(parse(with_line_of(9999) + "\n1,2,3,4,5,6\n").size(), 2u);
    for (const char* line_end : {"", "\n"})
        try {
            parse(with_line_of(100'000) + line_end);
            FAIL();
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find("rays:2:1: a line of more than 10,000 characters"),
                      std::string::npos)
                << error.what();
        }
}

TEST(RaysCsv, IsReadOrRefusedAfterRandomChanges) {
    std::mt19937_64 random(2);
    const std::string original = "\xef\xbb\xbfx,y,z,dx,dy,dz\r\n1,2,3,0,1,0\r\n-1e5,inf,nan,0.5,+1,-0\r\n";
    for (int trial = 0; trial < 20000; ++trial) {
        std::string text = original;
        for (std::uint64_t changes = 1 + random() % 4; changes-- > 0;) {
            const std::size_t position = random() % text.size();
            if (random() % 2)
                text[position] = static_cast<char>(random());
            else
                text.erase(position, 1 + random() % 5);
        }
        try {
            EXPECT_LE(parse(text).size(), std::count(text.begin(), text.end(), '\n') + 1u);
        } catch (const InputError& error) {
            EXPECT_EQ(std::strncmp(error.what(), "rays:", 5), 0) << error.what();
        }
    }
}

}  // namespace
