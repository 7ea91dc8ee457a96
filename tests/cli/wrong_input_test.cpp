// Tests of wrong command lines and input files: the program must end with status 2, print the expected message and
// write no file.
#include "tests/support/hole_scene.h"

namespace kagero::test {
namespace {

struct Mistake {
    const char* arguments;
    const char* message;  ///< Part of the expected message.
};

void PrintTo(const Mistake& mistake, std::ostream* out) {
    *out << "kagero " << mistake.arguments;
}

class WrongInput : public HoleTest, public testing::WithParamInterface<Mistake> {};

TEST_P(WrongInput, EndsWithStatus2AndLeavesNoFile) {
    write("bad.toml", "[space]\nhamiltonian = \"schwarzschild\"\nrgg = 0.1\n");
    write("rays.csv", "x,y,z,dx,dy,dz\n1,0,0,0,1,0\n");
    write("word.csv", "x,y,z,dx,dy,dz\n1,0,0,0,1,0\n1,0,zero,0,1,0\n");
    write("short.csv", "x,y,z,dx,dy,dz\n1,0,0,0,1\n");
    write("header.csv", "x,y,z,dx,dy,w\n");
    write("twice.csv", "x,x,z,dx,dy,dz\n");
    write("empty.csv", "");
    write("huge.csv", "x,y,z,dx,dy,dz\n1e999,0,0,0,1,0\n");
    std::string deep = "a";
    for (int i = 0; i < 20000; ++i) deep += ".\"a.b\"";
    write("deep-key.toml", "note = \"\"\"\n\"\"\"  # a.b\n" + deep + " = 1\n");
    write("deep-table.toml", "[" + deep + "]\n");
    const auto before = files();
    const Outcome outcome = run(GetParam().arguments);
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_NE(outcome.err.find("kagero: error: "), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find(GetParam().message), std::string::npos) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(files(), before);
}

INSTANTIATE_TEST_SUITE_P(
    CommandLine, WrongInput,
    testing::Values(
        Mistake{"", "--help"}, Mistake{"rendr hole.toml", "did you mean \"render\"?"},
        Mistake{"--quiet render hole.toml", "--quiet"}, Mistake{"render", "no scene was given"},
        Mistake{"render hole.toml --siez 3x3", "did you mean \"--size\"?"},
        Mistake{"render hole.toml other.toml", "other.toml"},
        Mistake{"render hole.toml --threads", "--threads needs a value"},
        Mistake{"render hole.toml --json ''", "--json: the value is empty"},
        Mistake{"render hole.toml --crop --size 8x8",
                "--crop: the value is missing; the next word is the option --size"},
        Mistake{"render hole.toml --threads none", "'none' is not a whole number"},
        Mistake{"render hole.toml --threads 0", "it must be from 1 to"},
        Mistake{"render hole.toml --crop=-1,0,5,5", "'-1,0,5,5' is not 4 whole numbers, 0 or greater, separated by"},
        Mistake{"view hole.toml --bind localhost --port 0", "--bind: 'localhost' is not an IP address"},
        Mistake{"render hole.toml --threads -3", "'-3'"}, Mistake{"render hole.toml --isa avx", "avx"},
        Mistake{"render hole.toml --strategy pakcet", "did you mean \"packet\"?"},
        Mistake{"render hole.toml --precision single", "legal names: auto, double, float"},
        Mistake{"render hole.toml --color blue", "auto"},
        Mistake{"render hole.toml --size 64", "'64' is not a width and a height"},
        Mistake{"render hole.toml --size 0x8", "film.size"},
        Mistake{"render hole.toml --step fast", "'fast' is not a finite number"},
        Mistake{"render hole.toml --integrator gaus8", "gauss8"}, Mistake{"render hole.toml --layers stps", "steps"},
        Mistake{"render hole.toml --crop 1,1,1,2", "is empty"},
        Mistake{"render hole.toml --crop 0,0,17,8", "film of 16x8"},
        Mistake{"profile hole.toml --crop 0,0,17,8", "film of 16x8"},
        Mistake{"render hole.toml --pixel 16,0", "outside the film of 16x8"},
        Mistake{"render hole.toml --pixel 1", "--pixel"},
        Mistake{"render hole.toml --pixel 1,1 --json", "leave --json out"},
        Mistake{"render hole.toml --pixel 1,1 --columns actoin", "--columns"},
        Mistake{"render hole.toml --columns action", "add --pixel X,Y"},
        Mistake{"render hole.toml --pixel 1,1 -o a.exr", "leave -o out"},
        Mistake{"render hole.toml --integrator srkn6", "--integrator srkn6: "},
        Mistake{"render hole.toml --lanes 3", "--lanes 3: "},
        Mistake{"render hole.toml --spp -1", "legal range is 1 <= value"},
        Mistake{"render hole.toml -D camera.position=[0,0.01,0] -D camera.observer=zamo",
                "possible observers at this position: falling"},
        Mistake{"render hole.toml --layers ''", "the value is empty"},
        Mistake{"render hole.toml -o ''", "the value is empty"},
        Mistake{"print hole.toml -o hole.toml", "are the same file"},
        Mistake{"stability --json traped", "did you mean trapped?"},
        Mistake{"render hole.toml -D space.rg=", "the value after '=' is missing"},
        Mistake{"render hole.toml -D integrator.rescale=-r",
                "integrator.rescale = \"-r\" is not greater than 0 at camera.position"},
        Mistake{"stability trapped --lanes 4", "no option"}, Mistake{"error hole.toml --strategy per-ray", "compare"},
        Mistake{"render hole.toml -D camera.fvo=20", "fov"}, Mistake{"render hole.toml -D camera", "camera"}));

INSTANTIATE_TEST_SUITE_P(
    Files, WrongInput,
    testing::Values(Mistake{"render missing.toml", "missing.toml"}, Mistake{"render .", "."},
                    Mistake{"render bad.toml", "bad.toml:3:1"},
                    Mistake{"check deep-key.toml", "deep-key.toml:3: a key has more than 32 parts"},
                    Mistake{"check deep-table.toml", "deep-table.toml:1: a key has more than 32 parts"},
                    Mistake{"render hole.toml -o hole.xyz", "'.xyz' is not a supported picture format"},
                    Mistake{"render hole.toml -o picture", ".exr"},
                    Mistake{"render hole.toml -o missing/a.exr", "'missing' does not exist"},
                    Mistake{"render hole.toml -o /", "directory"},
                    Mistake{"render hole.toml --layers steps -o a.png", "layer 'color'"},
                    Mistake{"render hole.toml -o a.exr --json missing/a.json", "'missing' does not exist"},
                    Mistake{"render hole.toml -o a.exr --json ./a.exr", "are the same file"},
                    Mistake{"check missing.toml", "missing.toml"}, Mistake{"print bad.toml", "rgg"},
                    Mistake{"print hole.toml -o missing/a", "missing"},
                    Mistake{"list sceens", "did you mean \"scenes\"?"}));

INSTANTIATE_TEST_SUITE_P(
    Rays, WrongInput,
    testing::Values(Mistake{"trace hole.toml --rays missing.csv", "missing.csv"},
                    Mistake{"trace hole.toml --rays .", "is a directory"},
                    Mistake{"trace hole.toml --rays rays.csv -o rays.csv", "are the same file"},
                    Mistake{"trace hole.toml --rays word.csv", "word.csv:3:5: 'zero'"},
                    Mistake{"trace hole.toml --rays short.csv -o out.csv", "expected 6 values, found 5"},
                    Mistake{"trace hole.toml --rays header.csv", "header.csv:1:13: 'w'"},
                    Mistake{"trace hole.toml --rays twice.csv", "twice"},
                    Mistake{"trace hole.toml --rays empty.csv", "x,y,z,dx,dy,dz"},
                    Mistake{"trace hole.toml --rays huge.csv", "1e999"},
                    Mistake{"trace hole.toml --rays rays.csv --observer statik", "did you mean \"static\"?"},
                    Mistake{"trace hole.toml --rays rays.csv --parameter -1", "greater than 0"},
                    Mistake{"trace hole.toml --rays rays.csv --path --json", "one of the two"},
                    Mistake{"trace hole.toml --rays rays.csv --repeat 3", "--json"},
                    Mistake{"trace hole.toml --rays rays.csv --json --repeat 0", "it must be from 1 to"}));

}  // namespace
}  // namespace kagero::test
