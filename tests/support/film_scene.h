/// A small animated scene, for tests of frames and films.
#pragma once

#include "tests/support/hole_scene.h"

namespace kagero::test {

/// Fixture for running the program in a folder that contains the scene `hole` as hole.toml, and the same scene with an
/// animation of nine frames as film.toml.
class FilmTest : public HoleTest {
protected:
    void SetUp() override {
        HoleTest::SetUp();
        write("film.toml", std::string(hole) +
                               "[animation]\nframes = 9\nfps = 12\n[animation.set]\n"
                               "\"space.rg\" = \"0.05*frame\"\n\"camera.fov\" = \"50 + frame\"\n");
    }
};

}  // namespace kagero::test
