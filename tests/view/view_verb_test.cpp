// The verb view: its options, its end by Ctrl-C, and the libraries that other verbs do not load.
#include "tests/support/program.h"

namespace kagero::test {
namespace {

const std::string scene = std::string(KAGERO_SCENES) + "/hole.toml";

/// Runs a command, and sends it an interrupt when it has written its first line.
const std::string interrupt =
    "sh -c 'out=$(mktemp); \"$@\" > \"$out\" & while ! [ -s \"$out\" ] && kill -0 $!; do sleep 0.02; done; "
    "kill -INT $!; wait $!; status=$?; cat \"$out\"; rm \"$out\"; exit $status' sh";

class ViewVerbTest : public ProgramTest {};

TEST_F(ViewVerbTest, PrintsTheAddressAndEndsAfterAnInterrupt) {
    const Outcome outcome = run("view " + scene + " --port 0 --quiet", interrupt);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_TRUE(outcome.out.starts_with("http://127.0.0.1:")) << outcome.out;
    EXPECT_NE(outcome.out.find("/?token="), std::string::npos) << outcome.out;
    EXPECT_EQ(outcome.err, "");
    EXPECT_TRUE(files().empty()) << "the viewer writes no files";
}

TEST_F(ViewVerbTest, RefusesInvalidOptions) {
    const std::vector<std::pair<std::string, std::string>> cases{{"view", "no scene was given"},
                                                                 {"view nothing.toml", "nothing.toml"},
                                                                 {"view " + scene + " --port 65536", "--port"},
                                                                 {"view " + scene + " --port x", "--port"},
                                                                 {"view " + scene + " --size 5000x100", "film.size"},
                                                                 {"view " + scene + " -D camera.fov=1000", "fov"}};
    for (const auto& [arguments, part] : cases) {
        const Outcome outcome = run(arguments, "timeout 20");
        EXPECT_EQ(outcome.status, 2) << arguments;
        EXPECT_NE(outcome.err.find(part), std::string::npos) << arguments << ": " << outcome.err;
    }
}

// The first is an address of another machine, which fails on this one. The second is not an address.
TEST_F(ViewVerbTest, ReportsAnAddressAtWhichItCannotListen) {
    for (const auto& [address, status] : {std::pair{"192.0.2.1", 1}, std::pair{"example", 2}}) {
        const Outcome outcome = run("view " + scene + " --port 0 --bind " + address, "timeout 20");
        EXPECT_EQ(outcome.status, status) << address;
        EXPECT_NE(outcome.err.find("--bind"), std::string::npos) << outcome.err;
    }
}

// The dynamic linker lists the libraries that it loads, also those that a program loads later.
TEST_F(ViewVerbTest, IsTheOnlyVerbThatLoadsTheServer) {
    const Outcome render = run("render " + scene + " --size 16x16 -o x.png", "LD_DEBUG=files"),
                  view = run("view " + scene + " --port 0", "LD_DEBUG=files " + interrupt);
    EXPECT_EQ(render.err.find("kagero-view.so"), std::string::npos);
    EXPECT_NE(view.err.find("kagero-view.so"), std::string::npos);
}

}  // namespace
}  // namespace kagero::test
