#include "report/thread_shares.h"

#include "report/text/numbers.h"

namespace kagero {

ThreadShares shares_of(const RunReport& report, const ThreadTime& time) {
    const double seconds = report.seconds - report.predict_seconds;
    return {ratio(time.busy, seconds), ratio(seconds - time.finished, seconds)};
}

Json threads_json(const RunReport& report) {
    Json threads = Json::array();
    for (const ThreadTime& time : report.threads) {
        const ThreadShares shares = shares_of(report, time);
        threads.push_back({{"tiles", time.tiles}, {"busy", shares.busy}, {"idle_at_end", shares.idle_at_end}});
    }
    return threads;
}

}  // namespace kagero
