// Tests of the module that reads images and writes them in all formats but PFM. It is loaded only by runs that need it,
// and other runs work without it.
#include "modules/modules.h"
#include "tests/support/program.h"

namespace kagero::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* tiny_room = "'" KAGERO_SCENES "/room.toml' --size 4x4 --quiet -o ";

class ImageModule : public ProgramTest {
protected:
    /// Returns true if the dynamic linker opened the module, according to its log.
    bool is_opened_by(const std::string& arguments) const {
        EXPECT_EQ(run(arguments, "LD_DEBUG=files LD_DEBUG_OUTPUT=opened").status, 0) << arguments;
        bool opened = false;
        for (const auto& file : fs::directory_iterator(directory_))
            if (file.path().filename().string().starts_with("opened.")) {
                opened = opened || text_of(file.path()).find("kagero-images.so") != std::string::npos;
                fs::remove(file.path());
            }
        return opened;
    }
};

TEST_F(ImageModule, IsLoadedOnlyByRunsThatNeedIt) {
    EXPECT_TRUE(is_opened_by(std::string("render ") + tiny_room + "a.png"));
    EXPECT_TRUE(is_opened_by("check '" KAGERO_SCENES "/galaxy.toml'"));  // the sky is an image
    EXPECT_FALSE(is_opened_by(std::string("render ") + tiny_room + "a.pfm"));
    EXPECT_FALSE(is_opened_by("check '" KAGERO_SCENES "/room.toml'"));
    write("rays.csv", "x,y,z,dx,dy,dz\n-1,0,0,1,0,0\n");
    EXPECT_FALSE(is_opened_by("trace '" KAGERO_SCENES "/galaxy.toml' --rays rays.csv -o ends.csv --quiet"));
    EXPECT_FALSE(is_opened_by("--help"));
}

// The program is copied to a folder without the image module.
TEST_F(ImageModule, IsNotNeededToWritePfm) {
    fs::create_directories(directory_ / "bin");
    fs::create_directories(directory_ / "lib/kagero");
    fs::copy(KAGERO_BINARY, directory_ / "bin");
    for (const IsaInfo& isa : find_isas())
        fs::create_symlink(isa.path, directory_ / "lib/kagero" / fs::path(isa.path).filename());
    const std::string program = (directory_ / "bin/kagero").string();
    EXPECT_EQ(run_program(program, std::string("render ") + tiny_room + "a.pfm").status, 0);
    const Outcome outcome = run_program(program, std::string("render ") + tiny_room + "a.png");
    EXPECT_EQ(outcome.status, 1);
    EXPECT_NE(outcome.err.find("kagero-images.so"), std::string::npos) << outcome.err;
    EXPECT_EQ(files(), (std::set<std::string>{"a.pfm", "bin", "lib"}));
}

}  // namespace
}  // namespace kagero::test
