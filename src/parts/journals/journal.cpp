#include "parts/journals/journal.h"

#include "error.h"
#include "scene/value.h"

#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>

namespace kagero {
namespace {

std::chrono::duration<double> journal_interval() {
    const char* variable = std::getenv("KAGERO_JOURNAL_INTERVAL");
    if (!variable || !*variable) return std::chrono::seconds(1);
    char* end = nullptr;
    const double seconds = std::strtod(variable, &end);
    if (*end || !(seconds >= 0 && seconds <= 3600))
        throw InputError("KAGERO_JOURNAL_INTERVAL: '" + std::string(variable) +
                         "' is not a number of seconds from 0 to 3600");
    return std::chrono::duration<double>(seconds);
}

}  // namespace

Journal::Journal(std::string path) : interval_(journal_interval()), file_(std::move(path)) {
    std::ifstream in(file_.path(), std::ios::binary);
    header_ = read_header(in, file_.path());
}

Journal::~Journal() {
    if (!removed_ && file_.size() == 0 && !header_) unlink(path().c_str());
}

void Journal::refuse_after(int error) const {
    if (error != 0)
        throw RunError("cannot write the journal '" + path() + "': " + std::strerror(error) +
                       "; the finished tiles remain in it, and the same command continues");
}

std::uint64_t Journal::begin(const TileFileHeader& header) {
    const std::uint64_t removed = file_.cut(0);
    append(encode_header(header));
    header_ = header;
    return removed;
}

std::uint64_t Journal::read(Film& film, TileResults& results) {
    std::ifstream in(path(), std::ios::binary);
    read_header(in, path());
    return file_.cut(read_tiles(in, *header_, film, results).valid_bytes);
}

void Journal::append(std::string_view records) { refuse_after(file_.append(records)); }

void Journal::transfer() { refuse_after(file_.transfer()); }

void Journal::remove() {
    file_.remove();
    removed_ = true;
}

}  // namespace kagero
