#include "frames/render_frames.h"

#include "accuracy/end_errors.h"
#include "frames/sub_frames.h"
#include "parts/journals/render_tiles.h"
#include "render/threads.h"

#include <chrono>
#include <condition_variable>

namespace kagero {
namespace {

/// The execution of a list of frames by several workers. Each worker renders one frame at a time, with all threads.
class FrameRun {
public:
    FrameRun(FramePlans& plans, const std::vector<std::uint32_t>& frames, const FrameControl& control)
        : plans_(plans), frames_(frames), control_(control), shares_(control.in_flight) {}

    /// Renders frames until all are taken, or the run ends early.
    void work(unsigned worker) try {
        for (std::size_t i = next_++; i < frames_.size() && !is_over(); i = next_++) {
            Plan plan = plans_.plan(frames_[i]);
            Film film = film_of(plan);
            RenderedFrame frame{frames_[i], std::move(plan), std::move(film), {}, nullptr};
            if (!render_frame(frame, worker)) return end_early(frame.report);
            if (control_.in_order && !await_turn(i)) return;
            control_.write(frame);
            finish(worker);
        }
    } catch (...) {
        fail();
        throw;
    }

    FramesReport report() const {
        return {written_, seconds(), written_ < frames_.size(), out_of_time_ && written_ < frames_.size()};
    }

private:
    double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count(); }

    bool is_over() {
        if (seconds() > control_.time_limit) out_of_time_ = true;
        return ended_ || out_of_time_ || (control_.stop && *control_.stop);
    }

    /// Reads the finished tiles of the frame's journal, or begins a new journal.
    void open_journal(RenderedFrame& frame, TileFileHeader& header, TileResults& results) const {
        frame.journal = std::make_unique<Journal>(control_.journal_path(frame.frame));
        Properties identity = with_frame(control_.identity, frame.frame);
        const bool continues = frame.journal->header().has_value();
        if (continues) check_same_render(*frame.journal, identity, {});
        header = header_of(frame.plan, frame.film, std::move(identity), {});
        if (!continues) {
            frame.journal->begin(header);
            return;
        }
        frame.journal->read(frame.film, results);
        if (control_.note)
            control_.note("continues frame " + std::to_string(frame.frame) + " from " + frame.journal->path() + ": " +
                          std::to_string(results.count()) + " of " + std::to_string(header.grid.count()) +
                          " tiles are finished");
    }

    /// Renders a frame. Returns false if it was not finished.
    bool render_frame(RenderedFrame& frame, unsigned worker) {
        RunControl control;
        control.stop = control_.stop;
        control.time_limit = control_.time_limit - seconds();
        control.progress = [&](double done, double) { show(worker, done); };
        if (has_sub_frames(frame.plan.description())) {
            frame.report = render_sub_frames(plans_, frame.plan, frame.frame, frame.film, control);
        } else if (!control_.journal_path) {
            frame.report = render_with_errors(frame.plan, frame.film, control);
        } else {
            TileFileHeader header;
            TileResults results;
            open_journal(frame, header, results);
            frame.report = render_tiles(frame.plan, header, frame.film, results, frame.journal.get(), control);
        }
        return !frame.report.interrupted;
    }

    /// Waits until all frames before number `i` of the list are written. Returns false if the run ends before.
    bool await_turn(std::size_t i) {
        std::unique_lock lock(mutex_);
        turn_changed_.wait(lock, [&] { return turn_ == i || ended_; });
        return turn_ == i;
    }

    void finish(unsigned worker) {
        const std::lock_guard lock(mutex_);
        ++written_;
        ++turn_;
        shares_[worker] = 0;
        turn_changed_.notify_all();
        report_progress();
    }

    void show(unsigned worker, double share) {
        const std::lock_guard lock(mutex_);
        shares_[worker] = share;
        report_progress();
    }

    void report_progress() {
        double done = double(written_);
        for (const double share : shares_) done += share;
        if (control_.progress) control_.progress(done / double(frames_.size()), seconds());
    }

    void end_early(const RunReport& report) {
        out_of_time_ = out_of_time_ || report.out_of_time;
        fail();
    }

    /// Ends the run: workers take no further frames, and none waits for its turn.
    void fail() {
        const std::lock_guard lock(mutex_);
        ended_ = true;
        turn_changed_.notify_all();
    }

    FramePlans& plans_;
    const std::vector<std::uint32_t>& frames_;
    const FrameControl& control_;
    const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
    std::atomic<std::size_t> next_ = 0;
    std::atomic<bool> ended_ = false, out_of_time_ = false;
    std::mutex mutex_;  ///< Protects the members that follow.
    std::condition_variable turn_changed_;
    std::size_t turn_ = 0;  ///< Number, in the list, of the frame that is written next.
    std::uint64_t written_ = 0;
    std::vector<double> shares_;  ///< Finished share of the frame of each worker.
};

}  // namespace

unsigned frames_in_flight(const Plan& first) {
    constexpr double max_floats = 64e6;  // of one film; 256 MB
    const Tile& window = first.view.window;
    double channels = 0;
    for (const LayerInfo& layer : all_layers())
        for (const std::string& name : first.description().film.layers)
            if (name == layer.name) channels += double(layer.channels.size());
    return double(window.x1 - window.x0) * double(window.y1 - window.y0) * channels > max_floats ? 1 : 2;
}

Properties with_frame(Properties identity, std::uint32_t frame) {
    identity.emplace_back("the frame", std::to_string(frame));
    return identity;
}

FramesReport render_frames(FramePlans& plans, const std::vector<std::uint32_t>& frames, const FrameControl& control) {
    FrameRun run(plans, frames, control);
    run_on_threads(control.in_flight, [&](unsigned worker) { run.work(worker); });
    return run.report();
}

}  // namespace kagero
