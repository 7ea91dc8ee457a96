/// Protection of the viewer's server: the token, the headers Host and Origin, and the rate of requests.
#pragma once

#include "view/web/web_server.h"

#include <chrono>
#include <mutex>

namespace kagero {

/// Returns 32 hexadecimal digits from the random numbers of the system. Throws RunError if there are none.
std::string random_token();

/// Returns the value of a parameter in the query of a target such as "/picture?token=0&format=png"; "" without it.
std::string query_value(const std::string& target, const std::string& name);
/// Returns the path of a target, without its query.
std::string path_of_target(const std::string& target);

/// Checks the heads of requests.
class Access {
public:
    /// `address` is the address at which the server listens.
    Access(std::string token, std::string address) : token_(std::move(token)), address_(std::move(address)) {}
    /// Sets the port at which the server listens, once it is known. Without it, the port of Host is not checked.
    void set_port(std::uint16_t port) { port_ = port; }
    const std::string& token() const { return token_; }
    /// Returns the reason why a request is refused, or "" if it is permitted.
    ///
    /// A page of another site cannot know the token. The check of Host excludes names that such a site has made point
    /// to this machine (DNS rebinding). The check of Origin excludes requests that scripts of other sites send.
    std::string refusal(const WebRequest& head) const;

private:
    bool is_own_host(const std::string& host) const;

    std::string token_, address_;
    std::uint16_t port_ = 0;
};

/// Bounds the rate of requests: `rate` per second on average, and up to `burst` at once.
class RateLimit {
public:
    using Clock = std::chrono::steady_clock;
    RateLimit(double rate, double burst) : rate_(rate), burst_(burst), available_(burst) {}
    /// Returns true if a request is permitted at this time, and counts it.
    bool permits(Clock::time_point now);

private:
    const double rate_, burst_;
    double available_;
    Clock::time_point last_{};
    std::mutex mutex_;
};

}  // namespace kagero
