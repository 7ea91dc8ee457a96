#include "parts/journals/entry_journal.h"

#include "error.h"
#include "parts/bytes.h"
#include "parts/identity.h"

#include <cstring>
#include <fstream>
#include <sstream>

namespace kagero {
namespace {

constexpr std::size_t hash_digits = 16;
constexpr const char* entry_journal_kind = "kagero entries 1";

std::string hexadecimal(std::uint64_t number) {
    std::ostringstream text;
    text << std::hex;
    text.width(hash_digits);
    text.fill('0');
    text << number;
    return text.str();
}

/// Returns the JSON of a line; null if the line is not complete or was changed.
Json json_of_line(const std::string& line) {
    if (line.size() <= hash_digits || line[hash_digits] != ' ') return {};
    const std::string text = line.substr(hash_digits + 1);
    if (hexadecimal(checksum(text)) != line.substr(0, hash_digits)) return {};
    return Json::parse(text, nullptr, false);
}

Properties identity_of_line(const Json& line) {
    Properties identity;
    for (const auto& [name, value] : line["identity"].items())
        if (value.is_string()) identity.emplace_back(name, value);
    return identity;
}

}  // namespace

EntryJournal::EntryJournal(std::string path, const Properties& identity) : file_(std::move(path)) { read(identity); }

/// Reads all complete lines and cuts the file after them. Writes the first line of a new journal.
void EntryJournal::read(const Properties& identity) {
    std::ifstream in(path(), std::ios::binary);
    if (!in) throw InputError("cannot read the journal '" + path() + "'");
    std::uint64_t valid = 0;
    std::string line;
    for (bool is_first = true; std::getline(in, line) && !in.eof(); is_first = false) {
        const Json json = json_of_line(line);
        if (is_first && (!json.is_object() || json.value("kind", "") != entry_journal_kind))
            throw InputError(path() + " is not a journal of this verb; remove it, or choose another folder with -o");
        if (!json.is_object()) break;
        if (is_first) {
            const std::string difference = describe_difference(identity_of_line(json), path(), identity, "this run");
            if (!difference.empty())
                throw InputError("the journal belongs to another run: " + difference + "; run as before, or remove " +
                                 path() + " to begin again");
        } else {
            entries_[json["name"]] = json["entry"];
        }
        valid += line.size() + 1;
    }
    file_.cut(valid);
    if (valid > 0) return;
    Json first;
    first["kind"] = entry_journal_kind;
    for (const auto& [name, value] : identity) first["identity"][name] = value;
    write_line(first);
}

/// Appends a line and transfers the file to the disk.
void EntryJournal::write_line(const Json& json) {
    const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace),
                      line = hexadecimal(checksum(text)) + ' ' + text + '\n';
    int error = file_.append(line);
    if (error == 0) error = file_.transfer();
    if (error != 0)
        throw RunError("cannot write the journal '" + path() + "': " + std::strerror(error) +
                       "; the finished entries remain in it, and the same command continues");
}

const Json* EntryJournal::find(const std::string& name) const {
    const auto found = entries_.find(name);
    return found == entries_.end() ? nullptr : &found->second;
}

void EntryJournal::append(const std::string& name, const Json& entry) {
    write_line({{"name", name}, {"entry", entry}});
    entries_[name] = entry;
}

void EntryJournal::remove() { file_.remove(); }

}  // namespace kagero
