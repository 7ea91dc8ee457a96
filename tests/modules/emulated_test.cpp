// Runs the program on emulated processors with fewer instruction sets. The program must select the best module that the
// processor supports. The picture must be equal, byte for byte, to that of the same module on this processor.
#include "tests/support/hole_scene.h"

#include <nlohmann/json.hpp>

namespace kagero::test {
namespace {

/// An emulated processor.
struct Processor {
    const char* model;  ///< Name in QEMU.
    const char* isa;    ///< Best instruction set that it supports.
};

class EmulatedProcessor : public HoleTest, public testing::WithParamInterface<Processor> {
protected:
    void SetUp() override {
        HoleTest::SetUp();
        if (std::system("qemu-x86_64 --version > /dev/null 2>&1") != 0)
            GTEST_SKIP() << "qemu-x86_64 is not installed (package qemu-user of Debian).";
        if (std::string("," KAGERO_BUILT_ISAS ",").find(std::string(",") + GetParam().isa + ",") == std::string::npos)
            GTEST_SKIP() << "The module for " << GetParam().isa << " is not built.";
    }
    /// Runs the program on the emulated processor.
    Outcome run_emulated(const std::string& arguments) const {
        return run(arguments, std::string("qemu-x86_64 -cpu ") + GetParam().model);
    }
};

TEST_P(EmulatedProcessor, RendersTheSamePictureAsThisProcessor) {
    const Outcome emulated =
        run_emulated("render hole.toml -o emulated.pfm --json emulated.json --threads 1 --quiet");
    ASSERT_EQ(emulated.status, 0) << emulated.err;
    EXPECT_EQ(nlohmann::json::parse(read("emulated.json"))["isa"], GetParam().isa);
    ASSERT_EQ(run(std::string("render hole.toml -o native.pfm --quiet --isa ") + GetParam().isa).status, 0);
    EXPECT_EQ(read("emulated.pfm"), read("native.pfm"));
}

TEST_P(EmulatedProcessor, RefusesModulesOfUnsupportedInstructionSets) {
    if (std::string(KAGERO_BUILT_ISAS).find("avx512") == std::string::npos)
        GTEST_SKIP() << "The module for avx512 is not built.";
    const Outcome emulated = run_emulated("render hole.toml -o emulated.pfm --isa avx512");
    EXPECT_EQ(emulated.status, 2);
    EXPECT_NE(emulated.err.find("does not support it"), std::string::npos) << emulated.err;
    EXPECT_FALSE(exists("emulated.pfm"));
}

INSTANTIATE_TEST_SUITE_P(Processors, EmulatedProcessor,
                         testing::Values(Processor{"Nehalem", "sse2"}, Processor{"Haswell", "avx2"}),
                         [](const auto& processor) { return std::string(processor.param.model); });

}  // namespace
}  // namespace kagero::test
