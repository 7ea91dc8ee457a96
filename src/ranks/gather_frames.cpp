#include "ranks/gather_frames.h"

#include "parts/bytes.h"
#include "parts/choices.h"
#include "parts/identity.h"
#include "ranks/agreement.h"
#include "ranks/joint_work.h"

#include <chrono>

namespace kagero {
namespace {

std::vector<std::uint32_t> frames_of_rank(const Communicator& ranks, const std::vector<std::uint32_t>& frames) {
    std::vector<std::uint32_t> own;
    const auto count = static_cast<std::size_t>(ranks.size());
    for (auto i = static_cast<std::size_t>(ranks.rank()); i < frames.size(); i += count) own.push_back(frames[i]);
    return own;
}

/// The end of a rank's work is the text "1" if its time was over.
std::string end_text(const FramesReport& report) { return report.out_of_time ? "1" : ""; }

}  // namespace

FramesReport render_frames_on_ranks(Communicator& ranks, FramePlans& plans, const std::vector<std::uint32_t>& frames,
                                    FrameControl control, const std::function<void(FinishedFrame&)>& write,
                                    LinkTimes times) {
    const auto begin = std::chrono::steady_clock::now();
    const auto seconds = [&] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    };
    const bool is_root = ranks.rank() == 0;
    std::atomic<std::uint64_t> written = 0;
    JointWork work(ranks, control.stop, times);
    work.receive_result = [&](int, std::string_view result) {
        FinishedFrame frame = decode_frame(result);
        write(frame);
        ++written;
    };
    work.observe = [&, progress = control.progress] {
        if (progress) progress(double(written) / double(frames.size()), seconds());
    };
    control.stop = work.stop();
    control.progress = {};
    control.journal_path = {};
    control.write = [&](RenderedFrame& rendered) {
        FinishedFrame frame = finish_frame(rendered);
        if (!is_root) return work.post_result(encode_frame(frame));
        write(frame);
        ++written;
    };
    FramesReport report;
    const std::vector<std::string> ends = work.run([&] {
        report = render_frames(plans, frames_of_rank(ranks, frames), control);
        return end_text(report);
    });
    if (!is_root) return report;
    report = {written, seconds(), written < frames.size(), false};
    for (const std::string& end : ends) report.out_of_time = report.out_of_time || (report.interrupted && !end.empty());
    return report;
}

std::vector<std::uint32_t> share_frames(Communicator& ranks, const FramePlans& plans, const Options& options,
                                        const std::vector<std::uint32_t>& frames) {
    Properties properties = identity_of(plans.first(), options);
    const Properties choices = choices_of(plans.first());
    properties.insert(properties.end(), choices.begin(), choices.end());
    agree_on_properties(ranks, properties);
    ByteWriter writer;
    for (const std::uint32_t frame : frames) writer.put(frame);
    agree(ranks);
    ranks.broadcast(writer.bytes);
    std::vector<std::uint32_t> shared;
    for (ByteReader reader(writer.bytes); !reader.empty();) shared.push_back(reader.get<std::uint32_t>());
    return shared;
}

}  // namespace kagero
