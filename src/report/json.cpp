#include "report/json.h"

#include "report/profile_numbers.h"

namespace kagero {

std::string text_of(const Json& json) {
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
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
