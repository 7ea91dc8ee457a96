// kagero merge: makes a picture from its parts.
#include "parts/merge.h"
#include "cli/output.h"
#include "cli/verb.h"
#include "error.h"
#include "report/json.h"
#include "report/run_json.h"

#include <ostream>

namespace kagero {

namespace {

void declare_merge(CLI::App& app, Arguments& arguments) {
    add_option(app, "PART", arguments.parts,
               "Part files of `kagero render --part`, in any order. With --incomplete, a journal of `kagero render "
               "--resume` may be given too",
               "");
    add_option(app, "-o,--output", arguments.output,
               "File for the picture, in the formats of `kagero render`. It has the same bytes as a picture that is "
               "rendered at once",
               "FILE");
    add_flag(app, "--incomplete", arguments.incomplete,
             "Also merge if parts or tiles are missing. Their pixels are black");
    add_json(app, arguments);
    add_messages(app, arguments);
}

std::string merge_json(const MergedPicture& picture, std::size_t files, double write_seconds) {
    Json json;
    json["parts"] = picture.header.part.count;
    json["files"] = files;
    json["missing_parts"] = picture.missing_parts;
    json["tiles"] = picture.header.grid.count();
    json["missing_tiles"] = picture.missing_tiles;
    json["width"] = picture.header.width;
    json["height"] = picture.header.height;
    for (const auto& [name, value] : picture.header.metadata)
        if (name == "version" || name == "isa" || name == "strategy" || name == "precision" || name == "integrator")
            json[name] = value;
    json.update(counts_json(picture.report));
    json["write_s"] = write_seconds;
    json["remarks"] = picture.remarks;
    return text_of(json);
}

int run_merge(const Arguments& arguments, const Terminal& terminal) {
    if (arguments.parts.empty()) throw InputError("no part was given; name the files of all parts of a picture");
    if (arguments.output.empty()) throw InputError("no output was given; name the file for the picture with -o");
    const Missing missing = arguments.incomplete ? Missing::allowed : Missing::refused;
    std::vector<NamedFile> inputs;
    for (const std::string& part : arguments.parts) inputs.emplace_back("the part", part);
    check_outputs({{"-o", arguments.output}, {"--json", arguments.json}}, inputs);
    const TileFileHeader header = check_parts(arguments.parts, missing);
    check_writable(arguments.output, header.layers, header.width, header.height);
    const MergedPicture picture = merge_parts(arguments.parts, missing);
    for (const std::string& remark : picture.remarks) terminal.warning(remark);
    const double write_seconds = save_film(picture.film, arguments.output, picture.metadata());
    if (!arguments.json.empty())
        write_output(arguments.json,
                     [&](std::ostream& out) { out << merge_json(picture, arguments.parts.size(), write_seconds); });
    terminal.note((picture.missing_tiles > 0 ? "the incomplete picture is in " : "the picture is in ") +
                  arguments.output);
    return header.misses_bound ? exit_bound : exit_done;
}

}  // namespace

const Verb merge_verb{"merge", "Make a picture from its parts, which `render --part` has written", declare_merge,
                      run_merge};

}  // namespace kagero
