/// Work that all ranks do together, with results that rank 0 receives.
#pragma once

#include "parts/bytes.h"
#include "ranks/rank_link.h"

namespace kagero {

/// The work of one rank, and its exchange with the others. If a rank is stopped or fails, all ranks end early.
class JointWork {
public:
    /// `caller_stop` may be null. The caller sets it to end the work of all ranks.
    JointWork(Communicator& ranks, const std::atomic<bool>* caller_stop, LinkTimes times = {});

    /// Rank 0: handles a result of another rank. Called in the thread of the link. If it throws, all ranks end early.
    std::function<void(int from, std::string_view result)> receive_result;
    /// Rank 0: returns the answer to a request of another rank. Called in the thread of the link.
    std::function<std::string(const std::string& request)> answer_request;
    /// Other ranks: handles the answer to a request. Called in the thread of the link.
    std::function<void(const std::string&)> receive_answer;
    /// Rank 0: called between messages, in the thread of the link, for example to show progress.
    std::function<void()> observe = [] {};

    /// The flag that ends the work of this rank early.
    const std::atomic<bool>* stop() const { return &stop_; }
    /// Returns true if the own work of this rank is done. On rank 0, the other ranks may continue.
    bool own_work_is_done() const { return own_work_is_done_; }
    /// Rank 0: returns true if the work of all other ranks is done, and their results were received.
    bool others_have_ended() const { return ended_ + 1 >= ranks_.size(); }
    /// Other ranks: sends a result to rank 0, in one message with others. May be called from any thread.
    void post_result(std::string_view result);

    /// States that messages of other ranks have to be answered without delay.
    void expect_messages() { link_.expect(true); }
    /// Other ranks: sends a request to rank 0. May be called from any thread.
    void post_request(std::string bytes) {
        link_.post(0, request_message, std::move(bytes));
        hurry();
    }

    /// Calls `own_work`, which returns a text about its end, and waits until all ranks have ended. Returns these texts
    /// of all ranks on rank 0, and an empty list on the others. Throws the exception of `own_work`, on rank 0 also that
    /// of `receive_result` and RunError if another rank has failed, and LostRank if a rank is lost.
    std::vector<std::string> run(const std::function<std::string()>& own_work);

private:
    /// Kinds of messages. Kind 0 belongs to the link.
    enum MessageKind : int {
        result_message = 1,  ///< To rank 0: results, each as a text of ByteWriter.
        stop_message,        ///< All ranks end early.
        end_message,         ///< To rank 0: the work of the sender is done.
        over_message,        ///< From rank 0: all ranks have ended.
        request_message,     ///< To rank 0: a request.
        answer_message       ///< From rank 0: the answer to a request.
    };
    /// The end of the work of a rank.
    struct End {
        std::string host, text;
        std::string failure;  ///< Reason why the rank failed; empty if it did not.
    };

    static std::string encode(const End& end);
    static End decode(const std::string& bytes);
    bool is_root() const { return ranks_.rank() == 0; }
    void hurry();
    void post_results();
    void post_collected();
    void do_own_work(const std::function<std::string()>& own_work);
    void receive(const RankMessage& message);
    void receive_at_root(const RankMessage& message);
    void announce_stop();
    void idle();
    std::vector<std::string> texts_of_ends() const;

    Communicator& ranks_;
    const std::atomic<bool>* const caller_stop_;
    std::atomic<bool> stop_ = false, own_work_is_done_ = false;
    bool stop_is_announced_ = false, is_over_ = false;
    std::exception_ptr own_failure_, receive_failure_;
    std::vector<End> ends_;  ///< On rank 0, one for each rank. Used by the thread of the link until it has ended.
    End own_end_;
    std::atomic<int> ended_ = 0;  ///< Number of other ranks that have ended.
    std::mutex posting_;          ///< Protects the next member.
    ByteWriter results_;          ///< Results of this rank that are not sent yet.
    RankLink link_;               ///< The last member, because its thread uses the others.
};

}  // namespace kagero
