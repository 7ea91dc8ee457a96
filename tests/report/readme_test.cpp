// Test of the numbers in the README: they follow from the lists of the program.
#include "tests/support/program.h"

#include <nlohmann/json.hpp>

#include <fstream>
#include <iterator>

namespace kagero::test {
namespace {

class Readme : public ProgramTest {};

TEST_F(Readme, StatesTheNumbersOfSpacesAndMethods) {
    const auto list = nlohmann::json::parse(run("list --json").out);
    const std::size_t spaces = list["hamiltonians"].size() - 1;  // without "formula"
    std::ifstream file(std::string(KAGERO_SOURCE) + "/README.md");
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    for (const std::string& part : {std::to_string(spaces) + " built-in spaces",
                                    std::to_string(list["integrators"].size()) + " integration methods"})
        EXPECT_NE(text.find(part), std::string::npos) << part;
}

}  // namespace
}  // namespace kagero::test
