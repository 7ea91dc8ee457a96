/// Fixture that runs the program as a user does, in a temporary folder.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace kagero::test {

inline std::string text_of(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

inline std::vector<std::string> lines_of(const std::string& text) {
    std::istringstream in(text);
    std::vector<std::string> lines;
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
}

/// Exit status and output of one run of a program.
struct Outcome {
    int status;  ///< Exit status; −1 if a signal terminated the program.
    std::string out, err;
};

/// Fixture with an initially empty folder in which the program runs. The output of the program is stored in a second
/// folder.
class ProgramTest : public testing::Test {
protected:
    void SetUp() override {
        std::string test = testing::UnitTest::GetInstance()->current_test_info()->name();
        for (char& c : test)
            if (c == '/') c = '-';
        directory_ = std::filesystem::temp_directory_path() / ("kagero-" + test + "-" + std::to_string(::getpid()));
        output_ = directory_.string() + "-output";
        std::filesystem::create_directories(directory_);
        std::filesystem::create_directories(output_);
    }
    void TearDown() override {
        std::filesystem::remove_all(directory_);
        std::filesystem::remove_all(output_);
    }

    void write(const std::string& name, const std::string& text) const {
        std::ofstream(directory_ / name, std::ios::binary) << text;
    }
    bool exists(const std::string& name) const { return std::filesystem::exists(directory_ / name); }
    std::string read(const std::string& name) const { return text_of(directory_ / name); }
    /// Returns the names of all files in the folder.
    std::set<std::string> files() const {
        std::set<std::string> names;
        for (const auto& entry : std::filesystem::directory_iterator(directory_))
            names.insert(entry.path().filename().string());
        return names;
    }

    /// Runs kagero with `arguments`, which may use shell syntax. `prefix` is shell text in front of the command, such
    /// as variables, or a command whose output is piped to stdin.
    Outcome run(const std::string& arguments, const std::string& prefix = "") const {
        return run_program(KAGERO_BINARY, arguments, prefix);
    }
    Outcome run_program(const std::string& program, const std::string& arguments,
                        const std::string& prefix = "") const {
        const std::string command = "cd '" + directory_.string() + "' && " + prefix + " '" + program + "' " +
                                    arguments + " >'" + (output_ / "out").string() + "' 2>'" +
                                    (output_ / "err").string() + "'";
        const int status = std::system(command.c_str());
        return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text_of(output_ / "out"), text_of(output_ / "err")};
    }

    std::filesystem::path directory_, output_;
};

}  // namespace kagero::test
