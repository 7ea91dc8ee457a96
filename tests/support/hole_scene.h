/// A small scene with a black hole, for tests of the command line.
#pragma once

#include "tests/support/program.h"

namespace kagero::test {

inline constexpr const char* hole = R"(# A black hole in front of a checkered sky
[space]
hamiltonian = "schwarzschild"
rg = 0.1
[camera]
position = [0, -2, 0]
look_at = [0, 0, 0]
up = [0, 0, 1]
[film]
size = [16, 8]
[sky]
checker = true
)";

/// Fixture for running the program in a folder that contains the scene `hole` as hole.toml.
class HoleTest : public ProgramTest {
protected:
    void SetUp() override {
        ProgramTest::SetUp();
        write("hole.toml", hole);
    }
};

}  // namespace kagero::test
