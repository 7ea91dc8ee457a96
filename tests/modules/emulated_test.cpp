// On processors that lack what this one has: the module that fits is the one that runs, and gives the bytes that it
// gives here.
#include "tests/support/hole_scene.h"

#include <nlohmann/json.hpp>

namespace kagero::test {
namespace {

struct Processor {
    const char *model, *isa;  ///< QEMU's name of it; the best instruction set it has
};

class Emulated : public HoleTest, public testing::WithParamInterface<Processor> {
protected:
    void SetUp() override {
        HoleTest::SetUp();
        if (std::system("qemu-x86_64 --version > /dev/null 2>&1") != 0)
            GTEST_SKIP() << "there is no qemu-x86_64 (Debian's qemu-user)";
        if (std::string("," KAGERO_BUILT_ISAS ",").find(std::string(",") + GetParam().isa + ",") == std::string::npos)
            GTEST_SKIP() << GetParam().isa << " is not built";
    }
    /// The program on the other processor.
    Outcome run_there(const std::string& arguments) const {
        return run(arguments, std::string("qemu-x86_64 -cpu ") + GetParam().model);
    }
};

TEST_P(Emulated, RendersByTheModuleThatFits) {
    const Outcome there = run_there("render hole.toml -o there.pfm --json there.json --threads 1 --quiet");
    ASSERT_EQ(there.status, 0) << there.err;
    EXPECT_EQ(nlohmann::json::parse(read("there.json"))["isa"], GetParam().isa);
    ASSERT_EQ(run(std::string("render hole.toml -o here.pfm --quiet --isa ") + GetParam().isa).status, 0);
    EXPECT_EQ(read("there.pfm"), read("here.pfm"));
}

TEST_P(Emulated, RefusesAModuleThatDoesNot) {
    if (std::string(KAGERO_BUILT_ISAS).find("avx512") == std::string::npos) GTEST_SKIP() << "avx512 is not built";
    const Outcome there = run_there("render hole.toml -o there.pfm --isa avx512");
    EXPECT_EQ(there.status, 2);
    EXPECT_NE(there.err.find("cannot run"), std::string::npos) << there.err;
    EXPECT_FALSE(exists("there.pfm"));
}

INSTANTIATE_TEST_SUITE_P(Processors, Emulated,
                         testing::Values(Processor{"Nehalem", "sse2"}, Processor{"Haswell", "avx2"}),
                         [](const auto& processor) { return std::string(processor.param.model); });

}  // namespace
}  // namespace kagero::test
