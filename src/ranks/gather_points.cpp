#include "ranks/gather_points.h"

#include "parts/bytes.h"
#include "ranks/gather_entries.h"
#include "ranks/joint_work.h"

namespace kagero {
namespace {

void put_point(ByteWriter& writer, const std::string& name, const PointContent& content) {
    writer.put_text(name);
    writer.put_list(content);
}

/// Returns the name and the content of a point that put_point has written.
NamedPoints::value_type get_point(ByteReader& reader) {
    std::string name = reader.get_text();
    return {std::move(name), reader.get_list<std::uint64_t>()};
}

/// The points that a rank has, and those that rank 0 has received. May be used from several threads.
class PointTable {
public:
    explicit PointTable(NamedPoints points) : points_(std::move(points)) {}

    std::optional<PointContent> find(const std::string& name) const {
        const std::lock_guard lock(mutex_);
        const auto found = points_.find(name);
        return found == points_.end() ? std::nullopt : std::optional(found->second);
    }
    /// Adds a point. Calls `added` unless there already is a point with this name.
    void add(const std::string& name, const PointContent& content,
             const std::function<void(const std::string&, const PointContent&)>& added) {
        const std::lock_guard lock(mutex_);
        if (points_.emplace(name, content).second && added) added(name, content);
    }

private:
    NamedPoints points_;
    mutable std::mutex mutex_;
};

}  // namespace

NamedPoints share_points(Communicator& ranks, const NamedPoints& finished) {
    ByteWriter writer;
    for (const auto& [name, content] : finished) put_point(writer, name, content);
    const std::string bytes = share_bytes(ranks, std::move(writer.bytes));
    NamedPoints shared;
    for (ByteReader reader(bytes); !reader.empty();) shared.insert(get_point(reader));
    return shared;
}

ErrorStudy study_on_ranks(Communicator& ranks, const Plan& plan, StudyOptions options, const NamedPoints& finished,
                          const std::function<void(const std::string&, const PointContent&)>& keep,
                          const Progress& progress, const std::atomic<bool>* stop, LinkTimes times) {
    const bool is_root = ranks.rank() == 0;
    PointTable points(finished);
    JointWork joint(ranks, stop, times);
    joint.receive_result = [&](int, std::string_view result) {
        ByteReader reader(result);
        const auto [name, content] = get_point(reader);
        points.add(name, content, keep);
    };
    options.share = {static_cast<std::uint32_t>(ranks.rank()), static_cast<std::uint32_t>(ranks.size())};
    options.store.has_times = false;
    options.store.find = [&](const std::string& name) { return points.find(name); };
    options.store.keep = [&](const std::string& name, const PointContent& content) {
        if (is_root) return points.add(name, content, keep);
        ByteWriter writer;
        put_point(writer, name, content);
        joint.post_result(writer.bytes);
        points.add(name, content, {});
    };
    options.await_others = [&] {
        constexpr auto pause = std::chrono::milliseconds(2);
        while (!joint.others_have_ended() && !*joint.stop()) std::this_thread::sleep_for(pause);
    };
    ErrorStudy study;
    joint.run([&]() -> std::string {
        if (is_root) {
            study = study_error(plan, options, progress, joint.stop());
        } else {
            PointMeasurements measurements(plan, options, joint.stop());
            measurements.prepare();
            measurements.measure(options.share, [](double) {});
        }
        return "";
    });
    return study;
}

}  // namespace kagero
