// Runs a fuzz target on inputs grown from a corpus, the same ones every time:
//
//     scene_fuzz [--seconds N] [--seed N] FILE|DIRECTORY ...
//
// An input that the target takes joins the corpus. One on which it crashes, or takes ten seconds of processor time
// (which does not depend on what else the machine does), is written to fuzz-NAME.input here.
#include "target.h"

#include <sys/time.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fcntl.h>
#include <fstream>
#include <iterator>
#include <random>
#include <sstream>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
using Random = std::mt19937_64;

constexpr std::size_t longest = 1 << 14, largest_corpus = 2000;
constexpr unsigned hang_seconds = 10;

std::string current;  ///< what the target is looking at
std::string report;   ///< where it goes if that is the last it looks at

void save_and_leave(int signal) {
    const int file = open(report.c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0644);
    if (file >= 0) {
        [[maybe_unused]] const auto written = write(file, current.data(), current.size());
        close(file);
    }
    std::signal(signal, SIG_DFL);
    std::raise(signal);
}

std::string text_of(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

std::size_t below(Random& random, std::size_t n) {
    return n == 0 ? 0 : random() % n;
}

/// A part of a text, most often a short one.
std::pair<std::size_t, std::size_t> part(Random& random, const std::string& text) {
    const std::size_t from = below(random, text.size() + 1), room = text.size() - from;
    return {from, below(random, 1 + (random() % 4 == 0 ? room : std::min<std::size_t>(room, 12)))};
}

void change(Random& random, std::string& text, const std::vector<std::string>& corpus,
            const std::vector<std::string>& words) {
    const auto [from, count] = part(random, text);
    switch (random() % 7) {
        case 0: text.erase(from, count); break;
        case 1: text.insert(from, text.substr(from, count)); break;
        case 2: text.insert(from, words[below(random, words.size())]); break;
        case 3: text.replace(from, count, words[below(random, words.size())]); break;
        case 4: if (!text.empty()) text[below(random, text.size())] = static_cast<char>(random()); break;
        case 5: {
            const std::string& other = corpus[below(random, corpus.size())];
            const auto [start, length] = part(random, other);
            text.insert(from, other.substr(start, length));
            break;
        }
        default: text.insert(from, std::to_string(static_cast<std::int64_t>(random()) >> (random() % 64)));
    }
}

/// Sends SIGPROF after so many seconds of processor time; 0: never.
void limit_processor_time(unsigned seconds) {
    itimerval timer{};
    timer.it_value.tv_sec = seconds;
    setitimer(ITIMER_PROF, &timer, nullptr);
}

int look(const std::string& input) {
    current = input;
    limit_processor_time(hang_seconds);
    return LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(current.data()), current.size());
}

}  // namespace

int main(int count, char** arguments) {
    double seconds = 10;
    Random random(1);
    std::vector<std::string> corpus{""};
    for (int i = 1; i < count; ++i) {
        const std::string argument = arguments[i];
        if (argument == "--seconds" && i + 1 < count) seconds = std::atof(arguments[++i]);
        else if (argument == "--seed" && i + 1 < count) random.seed(std::strtoull(arguments[++i], nullptr, 10));
        else if (fs::is_directory(argument)) {
            for (const auto& entry : fs::directory_iterator(argument))
                if (entry.is_regular_file()) corpus.push_back(text_of(entry.path()));
        } else corpus.push_back(text_of(argument));
    }
    std::istringstream stream(fuzz_words);
    const std::vector<std::string> words{std::istream_iterator<std::string>(stream), {}};

    report = "fuzz-" + fs::path(arguments[0]).stem().string() + ".input";
    for (const int signal : {SIGSEGV, SIGABRT, SIGFPE, SIGILL, SIGBUS, SIGPROF}) std::signal(signal, save_and_leave);

    const std::size_t given = corpus.size();
    std::size_t taken = 0, inputs = 0;
    for (const std::string& input : corpus) taken += look(input) == 0, ++inputs;
    if (given > 1 && taken == 0) {
        std::printf("the target takes nothing of its corpus\n");
        return 1;
    }
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (std::chrono::steady_clock::now() < end) {
        std::string input = corpus[below(random, corpus.size())];
        for (std::size_t changes = 1 + below(random, 4); changes > 0; --changes) change(random, input, corpus, words);
        if (input.size() > longest) input.resize(longest);
        ++inputs;
        if (look(input) != 0) continue;
        ++taken;
        if (corpus.size() < largest_corpus) corpus.push_back(input);
        else corpus[given + below(random, corpus.size() - given)] = input;
    }
    limit_processor_time(0);
    std::printf("%zu inputs, %zu of them taken\n", inputs, taken);
    return 0;
}
