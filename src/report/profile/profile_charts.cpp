#include "report/profile/profile_charts.h"

#include "report/profile/profile_numbers.h"
#include "report/text/chart.h"
#include "report/text/numbers.h"

#include <algorithm>

namespace kagero {
namespace {

constexpr const char* blue = "#2f6fb0";
constexpr const char* green = "#3a8f5c";
constexpr const char* orange = "#c9741f";
constexpr const char* purple = "#8457a6";
constexpr const char* grey = "#8a94a3";
constexpr const char* red = "#b5403a";

std::string rectangle(double x, double y, double w, double h, const std::string& css, const std::string& tooltip = "") {
    return "<rect x=\"" + fixed(x, 2) + "\" y=\"" + fixed(y, 2) + "\" width=\"" + fixed(w, 2) + "\" height=\"" +
           fixed(h, 2) + "\" style=\"" + css + "\">" + (tooltip.empty() ? "" : "<title>" + tooltip + "</title>") +
           "</rect>\n";
}

std::string anchored_text(double x, double y, const std::string& anchor, const std::string& text) {
    return "<text x=\"" + fixed(x) + "\" y=\"" + fixed(y) + "\" text-anchor=\"" + anchor + "\">" + text + "</text>\n";
}

std::string svg(double width, double height, const std::string& title, const std::string& body) {
    return "<svg viewBox=\"0 0 " + fixed(width, 0) + " " + fixed(height, 0) + "\" role=\"img\" aria-label=\"" + title +
           "\" xmlns=\"http://www.w3.org/2000/svg\">\n" + body + "</svg>\n";
}

std::string seconds_text(double seconds) {
    return seconds >= 1 ? rounded(seconds) + " s" : rounded(1e3 * seconds) + " ms";
}

/// Returns the bounding rectangle of all tiles.
Tile extent_of(const std::vector<TileRecord>& tiles) {
    Tile all{~0u, ~0u, 0, 0};
    for (const TileRecord& t : tiles)
        all = {std::min(all.x0, t.tile.x0), std::min(all.y0, t.tile.y0), std::max(all.x1, t.tile.x1),
               std::max(all.y1, t.tile.y1)};
    return all;
}

/// Returns the SVG of the tiles in a rectangle of this width at (left, top), in SVG units. `opacity` returns the
/// opacity of a tile, from 0 to 1.
template <class Opacity>
std::string tile_map(const Profile& profile, double left, double top, double width, const Opacity& opacity) {
    const Tile all = extent_of(profile.recording.tiles);
    const double scale = width / double(all.x1 - all.x0);
    std::string body;
    for (const TileRecord& t : profile.recording.tiles)
        body += rectangle(left + scale * (t.tile.x0 - all.x0), top + scale * (t.tile.y0 - all.y0),
                          scale * (t.tile.x1 - t.tile.x0), scale * (t.tile.y1 - t.tile.y0),
                          "fill:" + std::string(red) + ";opacity:" + fixed(std::clamp(opacity(t), 0.02, 1.0), 3),
                          "tile " + std::to_string(t.tile.x0) + "," + std::to_string(t.tile.y0) + ": measured " +
                              seconds_text(t.processor_time));
    return body;
}

}  // namespace

std::string stages_chart(const Profile& profile, double write_seconds) {
    const auto stages = stages_of(profile, write_seconds);
    double all = 0;
    for (const auto& stage : stages) all += stage.second;
    BarChart chart{"Seconds per stage, summed over threads", {}};
    for (const auto& [name, seconds] : stages)
        chart.bars.push_back({name, name == "integrate" ? blue : grey,
                              seconds_text(seconds) + ", " + fixed(100 * ratio(seconds, all)) + " %", seconds});
    return svg_of(chart);
}

std::string threads_chart(const Profile& profile) {
    constexpr double left = 72, width = 850, row_height = 26;
    const RunReport& report = profile.report;
    // The times of tiles are counted from the end of the prediction.
    const double scale = width / report.seconds, shift = report.predict_seconds;
    std::string body;
    for (std::size_t i = 0; i < report.threads.size(); ++i) {
        body += anchored_text(left - 8, row_height * double(i) + 18, "end", "thread " + std::to_string(i));
        body +=
            rectangle(left, row_height * double(i) + 3, width, row_height - 6, "fill:var(--panel);stroke:var(--line)");
        if (shift > 0)
            body += rectangle(left, row_height * double(i) + 3, scale * shift, row_height - 6,
                              "fill:" + std::string(orange), "predict");
    }
    for (const TileRecord& t : profile.recording.tiles) {
        const double y = row_height * t.thread + 3, x = left + scale * (shift + t.begin);
        const std::string tooltip = "tile " + std::to_string(t.tile.x0) + "," + std::to_string(t.tile.y0) + ": " +
                                    seconds_text(t.end - t.begin);
        body += rectangle(x, y, scale * (t.traced - t.begin), row_height - 6,
                          "fill:" + std::string(blue) + ";stroke:var(--ground);stroke-width:.3", tooltip);
        body += rectangle(left + scale * (shift + t.traced), y, scale * (t.end - t.traced), row_height - 6,
                          "fill:" + std::string(green), tooltip);
    }
    const double below = row_height * double(report.threads.size());
    body += anchored_text(left, below + 16, "start", "0") +
            anchored_text(left + width, below + 16, "end", seconds_text(report.seconds));
    return svg(940, below + 24, "Activity of each thread over time", body);
}

std::string tiles_map(const Profile& profile) {
    constexpr double width = 455;
    const Tile all = extent_of(profile.recording.tiles);
    // Costs are divided by the area, because tiles at the edge of the film are smaller.
    const auto area = [](const TileRecord& t) { return double(t.tile.x1 - t.tile.x0) * double(t.tile.y1 - t.tile.y0); };
    double max_predicted = 0, max_measured = 0;  // per pixel
    for (const TileRecord& t : profile.recording.tiles) {
        max_predicted = std::max(max_predicted, t.predicted / area(t));
        max_measured = std::max(max_measured, t.processor_time / area(t));
    }
    std::string body =
        anchored_text(width / 2, 14, "middle", profile.correlation ? "predicted" : "not predicted: number of rays") +
        anchored_text(485 + width / 2, 14, "middle", "measured");
    body += tile_map(profile, 0, 22, width,
                     [&](const TileRecord& t) { return ratio(t.predicted / area(t), max_predicted); });
    body += tile_map(profile, 485, 22, width,
                     [&](const TileRecord& t) { return ratio(t.processor_time / area(t), max_measured); });
    return svg(940, 24 + width * double(all.y1 - all.y0) / double(all.x1 - all.x0),
               "Predicted and measured cost of tiles", body);
}

std::string prediction_chart(const Profile& profile) {
    const double unit = seconds_per_predicted(profile);
    Series tiles{"tiles", blue, Mark::circle, false, false, false, {}, {}, true};
    double greatest = 0;  // over both coordinates of all points
    for (const TileRecord& t : profile.recording.tiles) {
        tiles.points.push_back({1e3 * unit * t.predicted, 1e3 * t.processor_time});
        tiles.tooltips.push_back("tile " + std::to_string(t.tile.x0) + "," + std::to_string(t.tile.y0));
        greatest = std::max({greatest, tiles.points.back()[0], tiles.points.back()[1]});
    }
    const Series ideal{"measured = predicted",         grey, Mark::none, true, false, false,
                       {{0, 0}, {greatest, greatest}}, {}};
    return svg_of(LineChart{"Measured against predicted cost of tiles",
                            {"predicted, milliseconds (scaled to the same sum)", false},
                            {"measured, milliseconds of processor time", false},
                            {ideal, tiles},
                            {},
                            0,
                            "",
                            0});
}

std::string scaling_chart(const Profile& profile) {
    Series measured{"measured", blue, Mark::circle, false, false, true, {}, {}};
    Series machine{"only multiply-adds", grey, Mark::circle, false, false, true, {}, {}};
    for (const ThreadsTime& time : profile.scaling) {
        machine.points.push_back({double(time.threads), time.machine_speedup});
        machine.tooltips.push_back(std::to_string(time.threads) + " threads: " + fixed(time.machine_speedup, 2));
        measured.points.push_back({double(time.threads), time.speedup});
        measured.tooltips.push_back(std::to_string(time.threads) + " threads: " + seconds_text(time.seconds));
    }
    const double max_threads = double(profile.scaling.back().threads);
    const Series ideal{"ideal", grey, Mark::none, true, false, false, {{0, 0}, {1, 1}, {max_threads, max_threads}}, {}};
    return svg_of(LineChart{"Speedup against the number of threads",
                            {"threads", false},
                            {"speedup over one thread", false},
                            {ideal, machine, measured},
                            {},
                            0,
                            "",
                            0});
}

std::string roofline_chart(const Profile& profile) {
    const double threads = double(profile.report.threads.size()), peak = profile.all_threads_peak / threads;
    const auto bar = [&](const std::string& label, const char* color, double rate) {
        return Bar{label, color, rounded(1e-9 * rate) + " GFLOP/s, " + fixed(100 * ratio(rate, peak)) + " %", rate};
    };
    BarChart chart{"Floating-point operations per second of one thread", {}};
    chart.bars.push_back(bar("peak: only multiply-adds", purple, peak));
    chart.bars.push_back(bar("integration and refinement", blue,
                             ratio(profile.total_operations, profile.stages.integrate + profile.stages.refine)));
    chart.bars.push_back(bar("tracing", blue, ratio(profile.total_operations, tracing_seconds(profile))));
    const double thread_seconds = profile.recorded_seconds * threads;
    chart.bars.push_back(bar("whole render", grey, ratio(profile.total_operations, thread_seconds)));
    return svg_of(chart);
}

}  // namespace kagero
