#include "ranks/joint_work.h"

#include "error.h"

namespace kagero {

JointWork::JointWork(Communicator& ranks, const std::atomic<bool>* caller_stop, LinkTimes times)
    : ranks_(ranks), caller_stop_(caller_stop), ends_(static_cast<std::size_t>(ranks.size())),
      link_(
          ranks, [this](const RankMessage& message) { receive(message); }, [this] { idle(); }, times) {}

std::string JointWork::encode(const End& end) {
    ByteWriter writer;
    for (const std::string& text : {end.host, end.text, end.failure}) writer.put_text(text);
    return writer.bytes;
}

JointWork::End JointWork::decode(const std::string& bytes) {
    ByteReader reader(bytes);
    End end;
    for (std::string* text : {&end.host, &end.text, &end.failure}) *text = reader.get_text();
    return end;
}

std::vector<std::string> JointWork::run(const std::function<std::string()>& own_work) {
    link_.start([this] { stop_ = true; });
    do_own_work(own_work);
    link_.join();
    if (own_failure_) std::rethrow_exception(own_failure_);
    if (receive_failure_) std::rethrow_exception(receive_failure_);
    return is_root() ? texts_of_ends() : std::vector<std::string>{};
}

/// Does the work of this rank, and keeps the exception that ends it until all ranks have ended.
void JointWork::do_own_work(const std::function<std::string()>& own_work) {
    own_end_.host = ranks_.host();
    try {
        own_end_.text = own_work();
    } catch (const std::exception& error) {
        own_failure_ = std::current_exception();
        own_end_.failure = error.what();
        stop_ = true;
    }
    if (!is_root()) {
        post_results();
        link_.post(0, end_message, encode(own_end_));
    }
    own_work_is_done_ = true;
    hurry();
}

void JointWork::post_result(std::string_view result) {
    constexpr std::size_t most_bytes = std::size_t{1} << 28;
    const std::lock_guard lock(posting_);
    if (results_.bytes.size() + result.size() > most_bytes) post_collected();
    results_.put_text(result);
}

/// Posts the results of this rank that are not posted yet.
void JointWork::post_results() {
    const std::lock_guard lock(posting_);
    post_collected();
}

/// Posts results as one message; `posting_` is locked.
void JointWork::post_collected() {
    if (results_.bytes.empty()) return;
    std::string message = std::move(results_.bytes);
    results_.bytes = {};
    results_.bytes.reserve(message.size());  // the next message is probably as long
    link_.post(0, result_message, std::move(message));
}

/// Sends the posted messages at once, and looks often for others from now on.
void JointWork::hurry() {
    link_.expect(true);
    link_.wake();
}

void JointWork::receive(const RankMessage& message) {
    if (is_root()) return receive_at_root(message);
    if (message.kind == over_message) return link_.finish();
    if (message.kind == answer_message) {
        link_.expect(false);
        return receive_answer(message.bytes);
    }
    stop_ = stop_is_announced_ = true;
}

/// Handles a message. A failure, such as a full disk, stops all ranks and is thrown when they have ended.
void JointWork::receive_at_root(const RankMessage& message) {
    try {
        if (message.kind == result_message) {
            for (ByteReader reader(message.bytes); !reader.empty();) receive_result(message.from, reader.get_view());
            return;
        }
        if (message.kind == request_message)
            return link_.post(message.from, answer_message, answer_request(message.bytes));
        stop_ = stop_ || message.kind == stop_message;
        if (message.kind != end_message) return;
        End& end = ends_[static_cast<std::size_t>(message.from)];
        end = decode(message.bytes);
        ++ended_;
        stop_ = stop_ || !end.failure.empty();
    } catch (const std::exception&) {
        if (!receive_failure_) receive_failure_ = std::current_exception();
        stop_ = true;
    }
}

void JointWork::announce_stop() {
    if (caller_stop_ && *caller_stop_) stop_ = true;
    if (!stop_ || stop_is_announced_) return;
    stop_is_announced_ = true;
    link_.post_to_all(stop_message, "");
}

void JointWork::idle() {
    announce_stop();
    if (!is_root()) return post_results();
    observe();
    if (!own_work_is_done_ || ended_ + 1 < ranks_.size() || is_over_) return;
    is_over_ = true;
    link_.post_to_all(over_message, "");
    link_.finish();
}

std::vector<std::string> JointWork::texts_of_ends() const {
    std::vector<std::string> texts{own_end_.text};
    for (std::size_t rank = 1; rank < ends_.size(); ++rank) {
        if (!ends_[rank].failure.empty())
            throw RunError("rank " + std::to_string(rank) + " on host " + ends_[rank].host + ": " +
                           ends_[rank].failure);
        texts.push_back(ends_[rank].text);
    }
    return texts;
}

}  // namespace kagero
