// Tests of films, which ffmpeg encodes. Tests that need ffmpeg are skipped where it is not installed.
#include "tests/support/film_scene.h"

#include <nlohmann/json.hpp>

namespace kagero::test {
namespace {

/// Skips a test without ffmpeg.
#define KAGERO_REQUIRE_FFMPEG() \
    if (std::system("ffmpeg -version >/dev/null 2>&1") != 0) GTEST_SKIP() << "ffmpeg is not installed"

class Video : public FilmTest {
protected:
    /// Returns the description of the video stream of a film.
    nlohmann::json stream_of(const std::string& film) const {
        const Outcome outcome = run_program("ffprobe", "-v error -count_frames -show_streams -of json " + film);
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        return nlohmann::json::parse(outcome.out)["streams"][0];
    }
    /// Writes a program with the name ffmpeg, and returns the variable PATH that selects it.
    std::string replace_ffmpeg(const std::string& script) const {
        std::filesystem::create_directories(directory_ / "bin");
        write("bin/ffmpeg", "#!/bin/sh\n" + script);
        std::filesystem::permissions(directory_ / "bin/ffmpeg", std::filesystem::perms::owner_all);
        return "PATH='" + (directory_ / "bin").string() + "':/usr/bin:/bin";
    }
};

TEST_F(Video, HasAllFramesAndTheTagsOfItsColors) {
    KAGERO_REQUIRE_FFMPEG();
    for (const std::string extension : {"mp4", "mkv", "webm"}) {
        const Outcome outcome = run("render film.toml --size 64x48 --frames 0:9 -o film." + extension);
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        const nlohmann::json stream = stream_of("film." + extension);
        EXPECT_EQ(stream["nb_read_frames"], "9");
        EXPECT_EQ(stream["r_frame_rate"], "12/1");
        EXPECT_EQ(stream["width"], 64);
        EXPECT_EQ(stream["pix_fmt"], "yuv420p");
        for (const char* key : {"color_space", "color_transfer", "color_primaries"}) EXPECT_EQ(stream[key], "bt709");
        EXPECT_EQ(stream["color_range"], "tv");
    }
    EXPECT_EQ(files(), (std::set<std::string>{"hole.toml", "film.toml", "film.mp4", "film.mkv", "film.webm"}));
}

// The decoded pictures are those of the frames, in their order, within the losses of the encoder.
TEST_F(Video, ShowsTheFramesInOrder) {
    KAGERO_REQUIRE_FFMPEG();
    ASSERT_EQ(run("render film.toml --size 64x48 --frames 0:9 -o film.mkv").status, 0);
    ASSERT_EQ(run("render film.toml --size 64x48 --frames 0:9 -o a-%d.ppm").status, 0);
    ASSERT_EQ(run_program("ffmpeg", "-v error -i film.mkv -f rawvideo -pix_fmt rgb24 film.raw").status, 0);
    const std::string decoded = read("film.raw");
    const std::size_t bytes = 64 * 48 * 3;
    ASSERT_EQ(decoded.size(), 9 * bytes);
    for (std::size_t frame = 0; frame < 9; ++frame) {
        const std::string picture = read("a-" + std::to_string(frame) + ".ppm");
        const std::size_t begin = picture.size() - bytes;
        std::vector<double> differences(9);
        for (std::size_t other = 0; other < 9; ++other)
            for (std::size_t i = 0; i < bytes; ++i)
                differences[other] += std::abs(double(static_cast<unsigned char>(picture[begin + i])) -
                                               double(static_cast<unsigned char>(decoded[other * bytes + i])));
        EXPECT_EQ(std::min_element(differences.begin(), differences.end()) - differences.begin(), long(frame));
        EXPECT_LT(differences[frame] / double(bytes), 12);
    }
}

TEST_F(Video, IsPlayableAfterASignal) {
    KAGERO_REQUIRE_FFMPEG();
    // The signal is sent a second after ffmpeg has begun the file, which it does with the first picture.
    write("until.sh",
          "\"$@\" & until [ -n \"$(find . -name '.a.mp4.part*' -size +0)\" ] || ! kill -0 $! 2>/dev/null; do "
          "sleep 0.05; done; sleep 1; kill -$SIGNAL $! 2>/dev/null; wait $!\n");
    for (const std::string signal : {"INT", "TERM"}) {
        std::filesystem::remove(directory_ / "a.mp4");
        const Outcome outcome =
            run("render film.toml --size 320x240 --integrator gauss8 --step 0.01 -D "
                "animation.frames=2000 --frames 1:2000 -D 'animation.set.\"space.rg\"=0.1' "
                "-D 'animation.set.\"camera.fov\"=\"50+9*u\"' -o a.mp4",
                "SIGNAL=" + signal + " sh until.sh");
        ASSERT_EQ(outcome.status, 130) << outcome.err;
        EXPECT_NE(outcome.err.find("interrupted; "), std::string::npos) << outcome.err;
        ASSERT_TRUE(exists("a.mp4")) << outcome.err;
        EXPECT_GT(std::stoi(stream_of("a.mp4")["nb_read_frames"].get<std::string>()), 0);
    }
}

TEST_F(Video, IsNotWrittenIfFfmpegFails) {
    const auto expect = [&](const std::string& path, int status, const std::string& expected) {
        const Outcome outcome = run("render film.toml --size 64x48 --frames 0:9 -o a.mp4", path);
        EXPECT_EQ(outcome.status, status) << outcome.err;
        EXPECT_NE(outcome.err.find(expected), std::string::npos) << outcome.err;
        EXPECT_FALSE(exists("a.mp4"));
    };
    expect("PATH=/nowhere", 2, "the program ffmpeg, which encodes films, is not in a folder of PATH");
    expect(replace_ffmpeg("echo broken encoder >&2; exit 3"), 1, "ffmpeg could not write the film 'a.mp4': broken");
    expect(replace_ffmpeg("cat >/dev/null; echo disk full >&2; exit 1"), 1, "disk full");
    for (const auto& entry : std::filesystem::directory_iterator(directory_))
        EXPECT_EQ(entry.path().filename().string().find(".part"), std::string::npos) << entry.path();
}

TEST_F(Video, IsRefusedWhereItCannotBeWritten) {
    const auto expect = [&](const std::string& arguments, const std::string& expected) {
        const Outcome outcome = run("render film.toml " + arguments, replace_ffmpeg("exit 0"));
        EXPECT_EQ(outcome.status, 2) << arguments;
        EXPECT_NE(outcome.err.find(expected), std::string::npos) << arguments << ": " << outcome.err;
    };
    expect("--size 63x48 --frames 0:9 -o a.mp4", "must be even; use --size 64x48");
    expect("--frames 0:9 -o a.mp4 --resume", "--resume cannot continue a film");
    expect("--frames 0:9 -o a.webm --maps --layers color,steps", "--maps writes pictures beside pictures");
    expect("--frames 0:9 -o a.mp4 --layers steps", "a film shows the layer 'color'");
    expect("-o a.mp4", "is a film; state its frames, such as --frames 0:9");
}

}  // namespace
}  // namespace kagero::test
