/// Parts and journals for tests, made in the test program from a plan.
#pragma once

#include "parts/choices.h"
#include "parts/identity.h"
#include "parts/journals/render_tiles.h"
#include "parts/merge.h"
#include "report/run_json.h"
#include "tests/support/plan_fixture.h"
#include "tests/support/program.h"
#include "tuning/resolve.h"

namespace kagero::test {

/// A part that was rendered but not written.
struct RenderedPart {
    TileFileHeader header;
    TileResults results{TileResults::Records::kept};
    RunReport report;

    RenderedPart(const Plan& plan, const Options& options, const PartNumber& part) {
        Film film = film_of(plan, Planes::none);
        header = header_of(plan, film, identity_of(plan, options), part);
        report = render_tiles(plan, header, film, results, nullptr, {});
    }
};

/// Fixture that renders pictures and their parts to files of its folder.
class PartTest : public ProgramTest {
protected:
    std::string path_of(const std::string& name) const { return (directory_ / name).string(); }

    /// Renders the picture without tiles files, as `render` does, and returns the bytes of the file.
    std::string render_at_once(const Plan& plan) const {
        Film film = film_of(plan);
        const RunReport report = render_with_errors(plan, film);
        write_film(film, path_of("whole.exr"), picture_metadata(plan, report));
        return read("whole.exr");
    }

    /// Renders the picture in `count` parts, with different numbers of threads. Returns the paths, last part first.
    std::vector<std::string> render_parts(Plan plan, const Options& options, std::uint32_t count) const {
        std::vector<std::string> paths;
        for (std::uint32_t number = count; number >= 1; --number) {
            plan.run.threads = 1 + number % 3;
            const RenderedPart part(plan, options, {number, count});
            paths.push_back(path_of(std::to_string(number) + "-of-" + std::to_string(count) + ".part"));
            write_part(paths.back(), part.header, part.results);
        }
        return paths;
    }

    /// Merges the parts and returns the bytes of the picture.
    std::string merge_to_file(const std::vector<std::string>& paths) const {
        const MergedPicture merged = merge_parts(paths, Missing::refused);
        write_film(merged.film, path_of("merged.exr"), merged.metadata());
        return read("merged.exr");
    }
};

}  // namespace kagero::test
