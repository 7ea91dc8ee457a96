#include "cli/frame_job.h"

#include "cli/interrupt.h"
#include "cli/output.h"
#include "cli/resolve.h"
#include "cli/verb.h"
#include "error.h"
#include "film/map.h"
#include "frames/file_pattern.h"
#include "frames/manifest.h"
#include "frames/video.h"
#include "parts/identity.h"
#include "ranks/gather_frames.h"
#include "report/text/numbers.h"
#include "report/warnings.h"

#include <filesystem>
#include <ostream>
#include <set>

namespace kagero {
namespace {

/// The names of all files of a run.
struct FrameFiles {
    std::string output;                    ///< The pattern of the pictures, or the film.
    std::optional<FilePattern> pictures;   ///< Empty if the output is a film.
    std::vector<const LayerInfo*> mapped;  ///< Layers for which --maps writes files.
};

/// Prints each message only once, although it can be true for many frames.
class OncePerRun {
public:
    explicit OncePerRun(const Terminal& terminal) : terminal_(terminal) {}

    /// Marks a message that was printed before.
    void mark(const std::string& key) { printed_.insert(key); }
    /// Prints a warning with the number of the first frame to which it applies.
    void warn(const std::string& key, const std::string& text, std::uint32_t frame) {
        if (printed_.insert(key).second) terminal_.warning("frame " + std::to_string(frame) + ": " + text);
    }

private:
    const Terminal& terminal_;
    std::set<std::string> printed_;
};

/// A run of render_frames with its outputs.
class FrameJob {
public:
    FrameJob(const Arguments& arguments, const FrameFiles& files, const FrameRange& range, FramePlans& plans,
             const Options& options, const Terminal& terminal)
        : arguments_(arguments), files_(files), plans_(plans), terminal_(terminal),
          line_(terminal, " of " + std::to_string(range.count()) + " frames"), messages_(terminal) {
        const Properties identity = identity_of(plans.first(), options);
        if (files.pictures) manifest_.emplace(files.pictures->manifest(), identity, arguments.resume);
        control_.identity = identity;
        for (const std::string& remark : plans.first().remarks) messages_.mark(remark);
        for (std::uint32_t i = 0; i < range.count(); ++i) select(range.frame(i));
    }

    /// Renders and writes the frames, on all ranks if `ranks` is not null.
    FramesReport run(double time_limit, Communicator* ranks, const Options& options) {
        const AnimationDescription& animation = *plans_.first().description().animation;
        const Tile& window = plans_.first().view.window;
        if (!files_.pictures && !frames_.empty())
            video_.emplace(files_.output, window.x1 - window.x0, window.y1 - window.y0, animation.fps);
        control_.write = [&](RenderedFrame& rendered) {
            FinishedFrame frame = finish_frame(rendered);
            write(frame);
            if (rendered.journal) rendered.journal->remove();
        };
        control_.in_order = video_.has_value();
        if (arguments_.resume)
            control_.journal_path = [&](std::uint32_t frame) { return files_.pictures->file(frame) + ".journal"; };
        control_.progress = [&](double done, double seconds) { line_.show(done, seconds); };
        control_.note = [&](const std::string& text) { line_.print_message([&] { terminal_.note(text); }); };
        control_.stop = InterruptGuard::requested();
        control_.time_limit = time_limit;
        control_.in_flight = frames_in_flight(plans_.first());
        if (ranks) share_frames(*ranks, plans_, options, frames_);
        FramesReport report = ranks ? render_frames_on_ranks(*ranks, plans_, frames_, control_,
                                                             [&](FinishedFrame& frame) { write(frame); })
                                    : render_frames(plans_, frames_, control_);
        if (video_ && report.written > 0) video_->finish();
        if (manifest_) manifest_->complete();
        line_.clear();
        return report;
    }

    std::uint64_t kept() const { return kept_; }
    bool misses_bound() const { return misses_bound_; }
    const std::vector<Json>& descriptions() const { return descriptions_; }

private:
    /// Adds a frame to the list of those that are rendered, unless --resume keeps its file.
    void select(std::uint32_t frame) {
        if (arguments_.resume && manifest_->has_complete(frame, files_.pictures->file(frame))) ++kept_;
        else frames_.push_back(frame);
    }

    /// Writes a finished frame. Called from several threads, unless a film is written.
    void write(FinishedFrame& frame) {
        const auto begin = std::chrono::steady_clock::now();
        const std::string file = files_.pictures ? files_.pictures->file(frame.frame) : files_.output;
        if (video_) {
            video_->write(frame.film);
        } else {
            write_film(frame.film, file, frame.metadata);
            for (const LayerInfo* layer : files_.mapped) write_map(frame.film, *layer, map_path(file, *layer));
        }
        const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        frame.description["write_s"] = seconds;
        Json description = manifest_ ? manifest_->add(frame.description, file) : frame.description;
        const std::lock_guard lock(concluding_);
        if (frame.misses_bound) misses_bound_ = true;
        description["warnings"] = warnings_json(frame.warnings);
        descriptions_.push_back(std::move(description));
        line_.print_message([&] { print_messages(frame); });
    }

    void print_messages(const FinishedFrame& frame) {
        for (const std::string& remark : frame.remarks) messages_.warn(remark, remark, frame.frame);
        for (const Warning& warning : frame.warnings) messages_.warn(warning.key, warning.text, frame.frame);
        terminal_.detail("frame " + std::to_string(frame.frame) + ": " + rounded(frame.rays) + " rays in " +
                         rounded(frame.seconds) + " s");
    }

    const Arguments& arguments_;
    const FrameFiles& files_;
    FramePlans& plans_;
    const Terminal& terminal_;
    ProgressLine line_;
    OncePerRun messages_;
    std::vector<std::uint32_t> frames_;
    std::uint64_t kept_ = 0;
    std::optional<Manifest> manifest_;
    std::optional<VideoEncoder> video_;
    FrameControl control_;
    std::mutex concluding_;  ///< Protects the members that follow.
    bool misses_bound_ = false;
    std::vector<Json> descriptions_;
};

/// Throws InputError for options that cannot be combined with --frames.
void check_frame_combination(const Arguments& arguments, const SceneDescription& scene) {
    if (!scene.animation)
        throw InputError("--frames: the scene '" + arguments.scene +
                         "' is not animated; add the table [animation], or state -D animation.frames=N");
    if (!arguments.part.empty())
        throw InputError(
            "--part divides one picture, and --frames already divides an animation: machine I of N renders "
            "--frames A+I-1:B:N; leave --part out");
    if (!arguments.pixel.empty()) throw InputError("--pixel writes the path of one ray in frame 0; leave --frames out");
    const bool is_film = is_video(arguments.output);
    if (arguments.resume && is_film)
        throw InputError(
            "--resume cannot continue a film, because its file is complete only at the end; write the "
            "frames as pictures, -o name-%04d.png, and encode them when all are complete");
    if (arguments.mpi && is_film)
        throw InputError(
            "--mpi writes frames as pictures, because they are finished in any order; state -o name-%04d.png, and "
            "encode them when all are complete");
    if (arguments.maps && is_film) throw InputError("--maps writes pictures beside pictures; a film has none");
}

/// Returns the names of all files. Throws InputError if one of them cannot be written.
FrameFiles files_of_frames(const Arguments& arguments, const Options& options, const SceneDescription& scene,
                           const FrameRange& range) {
    FrameFiles files;
    const std::string stem = std::filesystem::path(arguments.scene).stem().string();
    files.output = arguments.output.empty() ? stem + "-%04d.exr" : arguments.output;
    files.mapped = mapped_layers(arguments, scene.film.layers);
    const Tile& crop = options.crop;
    const bool whole = arguments.crop.empty();
    const std::uint32_t width = whole ? scene.film.width : crop.x1 - crop.x0,
                        height = whole ? scene.film.height : crop.y1 - crop.y0;
    std::vector<NamedFile> outputs{{"--json", arguments.json}};
    if (is_video(files.output)) {
        outputs.emplace_back("-o", files.output);
        check_outputs(outputs, files_of(scene));
        check_video(files.output, scene.film.layers, width, height);
        return files;
    }
    files.pictures.emplace(files.output);
    outputs.emplace_back("the manifest", files.pictures->manifest());
    const std::vector<NamedFile> inputs = files_of(scene);
    for (std::uint32_t i = 0; i < range.count(); ++i) {
        const std::string file = files.pictures->file(range.frame(i));
        if (i == 0) check_writable(file, scene.film.layers, width, height);
        if (i == 0 || range.count() <= 100) outputs.emplace_back("frame " + std::to_string(range.frame(i)), file);
    }
    check_outputs(outputs, inputs);
    return files;
}

void print_frames_result(const FramesReport& report, const FrameJob& job, const FrameFiles& files,
                         const FrameRange& range, const Terminal& terminal) {
    const std::string all = std::to_string(range.count()),
                      count = report.interrupted ? std::to_string(job.kept() + report.written) + " of " + all : all;
    std::string text = report.out_of_time ? "the time limit was reached; " : report.interrupted ? "interrupted; " : "";
    text += report.interrupted ? count + " frames are" : range.count() == 1 ? "1 frame is" : count + " frames are";
    text += " in " + files.output;
    if (files.pictures) text += ", described in " + files.pictures->manifest();
    if (job.kept() > 0) text += "; " + std::to_string(job.kept()) + " of them were complete";
    if (!files.pictures && report.written == 0) text = "interrupted before a frame was finished; no film is written";
    terminal.note(text + " (" + rounded(report.seconds) + " s, " + rounded(double(report.written) / report.seconds) +
                  " frames/s)");
}

}  // namespace

void add_frame_options(CLI::App& verb, Arguments& arguments) {
    add_option(
        verb, "--frames", arguments.frames,
        "Render the frames A, A+STEP, ... below B of an animated scene. -o contains the place of the number, such "
        "as name-%04d.exr, or is a film, .mp4, .webm or .mkv. Default for -o: SCENE-%04d.exr in the working "
        "directory. Without --frames, frame 0 is rendered",
        "A:B[:STEP]");
}

void check_picture_output(const Arguments& arguments, const SceneDescription& scene) {
    const std::string frames = scene.animation ? "0:" + std::to_string(scene.animation->frames) : "0:240";
    if (is_video(arguments.output))
        throw InputError("-o: '" + arguments.output + "' is a film; state its frames, such as --frames " + frames);
    if (scene.animation && has_frame_number(arguments.output))
        throw InputError("-o: '" + arguments.output +
                         "' has a place for the number of a frame, but only frame 0 is "
                         "rendered; state --frames, such as --frames " +
                         frames + ", or another name");
}

std::unique_ptr<FramePlans> frame_plans_with_progress(const SceneDescription& scene, const Options& options,
                                                      const Terminal& terminal) {
    constexpr double delay = 1;  // seconds before progress is shown
    RunControl control;
    ProgressLine line(terminal, " of the trial rays");
    control.progress = [&](double done, double seconds) {
        if (seconds > delay) line.show(done, seconds);
    };
    auto plans = std::make_unique<FramePlans>(scene, options, control);
    line.clear();
    print_remarks(plans->first(), terminal);
    return plans;
}

int render_frames_of(const Arguments& arguments, Options options, const SceneDescription& scene, double time_limit,
                     const Terminal& terminal, Communicator* ranks) {
    check_frame_combination(arguments, scene);
    const FrameRange range = frame_range(arguments.frames, scene.animation->frames);
    const FrameFiles files = files_of_frames(arguments, options, scene, range);
    options.energy_error = true;  // in the attributes of pictures, the manifest and the JSON
    check_frames(scene, catalogue(options.isa), range);
    if (files.pictures) prepare_to_write(files.pictures->file(range.first));
    const std::unique_ptr<FramePlans> plans = frame_plans_with_progress(scene, options, terminal);
    const InterruptGuard interrupts;
    FrameJob job(arguments, files, range, *plans, options, terminal);
    const FramesReport report = job.run(time_limit, ranks, options);
    if (!arguments.json.empty())
        write_output(arguments.json, [&](std::ostream& out) {
            out << frames_json(plans->first(), report, job.kept(), job.descriptions());
        });
    print_frames_result(report, job, files, range, terminal);
    if (report.interrupted && !report.out_of_time) return exit_interrupted;
    return job.misses_bound() ? exit_bound : exit_done;
}

}  // namespace kagero
