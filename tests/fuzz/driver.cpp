// Runs a fuzz target on the files of a corpus, and on random changes of them. The inputs are the same in every run with
// the same seed.
//
//     scene_fuzz [--seconds N] [--seed N] FILE|DIRECTORY ...
//
// N seconds are of processor time, so that other work on the machine does not shorten the search.
// An input that the target accepts is added to the corpus. An input on which the target crashes, or needs more than ten
// seconds of processor time, is written to fuzz-NAME.input in the working directory.
#include "target.h"

#include <sys/time.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>
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

constexpr std::size_t max_input_size = 1 << 14;  ///< Greatest length of an input, in bytes.
constexpr std::size_t max_corpus_size = 2000;   ///< Greatest number of inputs in the corpus.
constexpr unsigned max_run_seconds = 10;        ///< Processor time after which SIGPROF ends the run of an input.

std::string current_input;  ///< The input that the target is running on.
std::string crash_file;     ///< Name of the file to which the input is written if the target crashes.

/// Signal handler: writes the current input to the file and ends the process by the signal.
void save_input_and_end(int signal) {
    const int file = open(crash_file.c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0644);
    if (file >= 0) {
        [[maybe_unused]] const auto written = write(file, current_input.data(), current_input.size());
        close(file);
    }
    std::signal(signal, SIG_DFL);
    std::raise(signal);
}

std::string text_of(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// Returns a random number less than n, or 0 if n is 0.
std::size_t random_below(Random& random, std::size_t n) {
    return n == 0 ? 0 : random() % n;
}

/// Returns start and length of a random part of a text. Three of four parts have fewer than 13 bytes.
std::pair<std::size_t, std::size_t> random_part(Random& random, const std::string& text) {
    const std::size_t start = random_below(random, text.size() + 1), remaining = text.size() - start;
    return {start, random_below(random, 1 + (random() % 4 == 0 ? remaining : std::min<std::size_t>(remaining, 12)))};
}

/// Changes a text at a random position: erases, duplicates or replaces a part, changes a byte, or inserts a word, a
/// number or a part of another input.
void change(Random& random, std::string& text, const std::vector<std::string>& corpus,
            const std::vector<std::string>& words) {
    const auto [position, count] = random_part(random, text);
    switch (random() % 7) {
        case 0: text.erase(position, count); break;
        case 1: text.insert(position, text.substr(position, count)); break;
        case 2: text.insert(position, words[random_below(random, words.size())]); break;
        case 3: text.replace(position, count, words[random_below(random, words.size())]); break;
        case 4: if (!text.empty()) text[random_below(random, text.size())] = static_cast<char>(random()); break;
        case 5: {
            const std::string& other = corpus[random_below(random, corpus.size())];
            const auto [start, length] = random_part(random, other);
            text.insert(position, other.substr(start, length));
            break;
        }
        default: text.insert(position, std::to_string(static_cast<std::int64_t>(random()) >> (random() % 64)));
    }
}

/// Returns the processor time of this process, in seconds.
double processor_time() {
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Requests the signal SIGPROF after the given processor time. 0 cancels the request.
void limit_processor_time(unsigned seconds) {
    itimerval timer{};
    timer.it_value.tv_sec = seconds;
    setitimer(ITIMER_PROF, &timer, nullptr);
}

/// Runs the target on an input, and returns its result.
int run_target(const std::string& input) {
    current_input = input;
    limit_processor_time(max_run_seconds);
    return LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(current_input.data()), current_input.size());
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

    crash_file = "fuzz-" + fs::path(arguments[0]).stem().string() + ".input";
    for (const int signal : {SIGSEGV, SIGABRT, SIGFPE, SIGILL, SIGBUS, SIGPROF})
        std::signal(signal, save_input_and_end);

    const std::size_t initial_corpus_size = corpus.size();
    std::size_t accepted = 0, inputs = 0;
    for (const std::string& input : corpus) {
        accepted += run_target(input) == 0;
        ++inputs;
    }
    if (initial_corpus_size > 1 && accepted == 0) {
        std::printf("the target accepts no input of its corpus\n");
        return 1;
    }
    const double end = processor_time() + seconds;
    while (processor_time() < end) {
        std::string input = corpus[random_below(random, corpus.size())];
        for (std::size_t changes = 1 + random_below(random, 4); changes > 0; --changes)
            change(random, input, corpus, words);
        if (input.size() > max_input_size) input.resize(max_input_size);
        ++inputs;
        if (run_target(input) != 0) continue;
        ++accepted;
        if (corpus.size() < max_corpus_size) corpus.push_back(input);
        else corpus[initial_corpus_size + random_below(random, corpus.size() - initial_corpus_size)] = input;
    }
    limit_processor_time(0);
    std::printf("%zu inputs, %zu of them accepted\n", inputs, accepted);
    return 0;
}
