#include "report/compare_report.h"

#include "plan/names.h"
#include "report/json.h"
#include "report/machine.h"
#include "report/text/numbers.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

/// Returns how a kernel evaluates H, as text.
const char* name_of(HamiltonianCode code) {
    switch (code) {
        case HamiltonianCode::built_in: return "built-in";
        case HamiltonianCode::generated: return "generated";
        default: return "interpreted";
    }
}

Json row_json(const CompareRow& row, unsigned threads) {
    const KernelInfo& kernel = *row.kernel;
    return {{"strategy", name_of(kernel.strategy)},
            {"form", kernel.form == Form::none ? Json() : Json(name_of(kernel.form))},
            {"code", name_of(row.code)},
            {"method", row.method},
            {"precision", name_of(kernel.precision)},
            {"isa", row.isa},
            {"lanes", kernel.lanes},
            {"registers", kernel.registers},
            {"shape", row.shape},
            {"threads", threads},
            {"seconds",
             {{"median", row.seconds.median},
              {"min", row.seconds.min},
              {"max", row.seconds.max},
              {"samples", row.samples}}},
            {"mrays_per_s", 1e-6 * row.rays_per_second},
            {"speedup", row.speedup},
            {"lane_occupancy", row.rendered ? Json(row.occupancy) : Json()},
            {"max_difference", row.rendered ? Json(row.max_difference) : Json()},
            {"flips", row.rendered ? Json(row.flips) : Json()},
            {"step", row.step},
            {"solver_tolerance", row.solver_tolerance}};
}

using Cells = std::vector<std::string>;

/// Returns "-" for a value that is not finite, because an interruption prevented its measurement.
std::string number_or_dash(double value) { return std::isfinite(value) ? rounded(value) : "-"; }

Cells cells_of(const CompareRow& row) {
    const KernelInfo& kernel = *row.kernel;
    std::string strategy = name_of(kernel.strategy);
    if (kernel.form != Form::none) strategy += std::string(" ") + name_of(kernel.form);
    return {row.isa,
            strategy,
            name_of(row.code),
            row.method,
            rounded(row.step),
            name_of(kernel.precision),
            std::to_string(kernel.lanes),
            std::to_string(kernel.registers),
            row.shape,
            number_or_dash(1e3 * row.seconds.median),
            number_or_dash(row.rays_per_second),
            number_or_dash(row.speedup),
            row.rendered ? rounded(row.occupancy) : "-",
            row.rendered ? rounded(row.max_difference) : "-",
            row.rendered ? std::to_string(row.flips) : "-"};
}

const Cells header{"isa",       "strategy", "code", "method", "step",    "precision", "lanes",
                   "registers", "shape",    "ms",   "rays/s", "speedup", "occupancy", "difference",
                   "flips"};
constexpr std::size_t text_columns = 6;  ///< Number of leading columns, which are aligned to the left.

/// Returns the size of the picture, and that of the scene if it is another one.
std::string size_text(const SceneDescription& scene, const Comparison& comparison) {
    const auto size = [](std::uint32_t width, std::uint32_t height) {
        return std::to_string(width) + "x" + std::to_string(height);
    };
    const std::string compared = size(comparison.width, comparison.height),
                      stated = size(scene.film.width, scene.film.height);
    return compared + " pixels" +
           (compared == stated ? "" : " (" + stated + " would take too long; see --seconds and --size)") + ", ";
}

}  // namespace

std::string compare_json(const SceneDescription& scene, const CompareOptions& options, const Comparison& comparison) {
    Json rows = Json::array(), left_out = Json::array();
    for (const CompareRow& row : comparison.rows) rows.push_back(row_json(row, options.threads));
    for (const auto& [what, why] : comparison.left_out) left_out.push_back({{"what", what}, {"why", why}});
    Json flags = Json::object();
    for (const auto& [isa, options_of_compiler] : comparison.flags) flags[isa] = options_of_compiler;
    const Json json{{"rows", rows},
                    {"scene", scene.path},
                    {"width", comparison.width},
                    {"height", comparison.height},
                    {"rays", comparison.rays},
                    {"rounds", comparison.rounds},
                    {"equal_error", options.equal_error > 0 ? Json(options.equal_error) : Json()},
                    {"baseline", options.baseline.empty() ? Json() : Json(options.baseline)},
                    {"version", KAGERO_VERSION},
                    {"processor", processor_name()},
                    {"compiler", comparison.compiler},
                    {"flags", flags},
                    {"left_out", left_out},
                    {"interrupted", comparison.interrupted},
                    {"remarks", comparison.remarks}};
    return text_of(json);
}

std::string compare_text(const SceneDescription& scene, const CompareOptions& options, const Comparison& comparison) {
    std::vector<Cells> lines{header};
    for (const CompareRow& row : comparison.rows) lines.push_back(cells_of(row));
    std::vector<std::size_t> width(header.size());
    for (const Cells& cells : lines)
        for (std::size_t i = 0; i < cells.size(); ++i) width[i] = std::max(width[i], cells[i].size());
    std::string text;
    for (const Cells& cells : lines) {
        std::string line;
        for (std::size_t i = 0; i < cells.size(); ++i) {
            const std::string padding(width[i] - cells[i].size(), ' ');
            if (i) line += "  ";
            line += i < text_columns ? cells[i] : padding;
            line += i < text_columns ? padding : cells[i];
        }
        text += line + "\n";
    }
    text += "\n";
    text += size_text(scene, comparison) + rounded(double(comparison.rays)) + " rays, ";
    text += std::to_string(options.threads) +
            (options.threads == 1 ? " thread, " : " threads, ") + std::to_string(comparison.rounds) +
            " interleaved rounds. Times are medians; speedup is the median ratio to scalar double on " +
            (options.baseline.empty() ? "the same instruction set. " : options.baseline + ". ") +
            (options.equal_error > 0 ? "Each row uses its cheapest method with an error of at most " +
                                           shortest(options.equal_error) + " pixel for 99 % of the rays.\n"
             : options.methods.size() > 1 ? "Each method uses the step of the scene, or its tolerance if it has step "
                                            "control. Speedup refers to scalar double with the same method.\n"
                                          : "All rows use the same method and step.\n");
    for (const auto& [what, why] : comparison.left_out) text += "left out: " + what + ": " + why + "\n";
    return text;
}

}  // namespace kagero
