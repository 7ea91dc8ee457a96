// Tests of the ranges of --frames and of the names of the files of frames.
#include "error.h"
#include "frames/file_pattern.h"
#include "frames/frame_range.h"

#include <gtest/gtest.h>

namespace kagero::test {
namespace {

template <class Call>
std::string message_of(const Call& call) {
    try {
        call();
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

TEST(FrameRange, ContainsEveryStepBelowItsEnd) {
    for (std::uint32_t first = 0; first < 5; ++first)
        for (std::uint32_t end = first + 1; end < 9; ++end)
            for (std::uint32_t step = 1; step < 5; ++step) {
                const FrameRange range =
                    frame_range(std::to_string(first) + ":" + std::to_string(end) + ":" + std::to_string(step), 10);
                std::vector<std::uint32_t> expected, found;
                for (std::uint32_t frame = first; frame < end; frame += step) expected.push_back(frame);
                for (std::uint32_t i = 0; i < range.count(); ++i) found.push_back(range.frame(i));
                EXPECT_EQ(found, expected);
            }
    EXPECT_EQ(frame_range("2147483647:2147483648", 1u << 31).frame(0), 2147483647u);
}

TEST(FrameRange, RefusesWhatIsNoRange) {
    const auto expect = [](const std::string& range, const std::string& expected) {
        const std::string message = message_of([&] { frame_range(range, 10); });
        EXPECT_NE(message.find(expected), std::string::npos) << range << ": " << message;
    };
    expect("3:3", "contains no frame");
    expect("4:3", "contains no frame");
    expect("0:5:0", "the STEP in '0:5:0' is 0");
    expect("0:11", "at most 10; -D animation.frames=N");
    expect("0:2147483649", "is beyond 2147483648");
    expect("0:99999999999999999999", "is beyond 2147483648");
    for (const char* range : {"", "3", ":", "1:", ":2", "a:b", "0:1:2:3", "-1:2", "0:1.5", "0: 1"})
        expect(range, "is not a range A:B or A:B:STEP");
}

TEST(FilePattern, PutsTheNumberInItsPlace) {
    EXPECT_EQ(FilePattern("a-%04d.exr").file(17), "a-0017.exr");
    EXPECT_EQ(FilePattern("a-%04d.exr").file(123456), "a-123456.exr");
    EXPECT_EQ(FilePattern("out/%d.png").file(0), "out/0.png");
    EXPECT_EQ(FilePattern("%3d%%.png").file(7), "  7%.png");
    EXPECT_EQ(FilePattern("out/a-%04d.exr").manifest(), "out/a-frames.json");
    EXPECT_EQ(FilePattern("%04d.png").manifest(), "frames.json");
}

TEST(FilePattern, RefusesPathsWithoutOnePlace) {
    const auto expect = [](const std::string& path, const std::string& expected) {
        const std::string message = message_of([&] { FilePattern{path}; });
        EXPECT_NE(message.find(expected), std::string::npos) << path << ": " << message;
    };
    expect("a.exr", "has no place for the number");
    expect("a%%.exr", "has no place for the number");
    expect("a-%d-%d.exr", "more than one place");
    expect("a-%s.exr", "is not followed by d");
    expect("a-%", "is not followed by d");
    expect("%d/a.exr", "in the name of a directory");
}

}  // namespace
}  // namespace kagero::test
