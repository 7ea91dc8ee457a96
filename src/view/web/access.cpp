#include "view/web/access.h"

#include "error.h"

#include <algorithm>

#include <sys/random.h>
#include <unistd.h>

namespace kagero {
namespace {

/// Compares two texts in a time that does not depend on where they differ.
bool equal_in_constant_time(const std::string& a, const std::string& b) {
    if (a.size() != b.size()) return false;
    unsigned char difference = 0;
    for (std::size_t i = 0; i < a.size(); ++i) difference |= static_cast<unsigned char>(a[i] ^ b[i]);
    return difference == 0;
}

std::string host_name() {
    char name[256] = {};
    return gethostname(name, sizeof name - 1) == 0 ? name : "";
}

/// Returns true if the text looks like an IPv4 address, or an IPv6 address in brackets. Such a host is no name that
/// somebody could have redirected.
bool is_numeric_host(const std::string& host) {
    if (host.starts_with('[')) return host.ends_with(']');
    return !host.empty() && host.find_first_not_of("0123456789.") == std::string::npos;
}

}  // namespace

std::string random_token() {
    unsigned char bytes[16];
    if (getrandom(bytes, sizeof bytes, 0) != static_cast<ssize_t>(sizeof bytes))
        throw RunError("the system provides no random numbers, which protect the viewer; getrandom failed");
    std::string token;
    for (const unsigned char byte : bytes) {
        token += "0123456789abcdef"[byte >> 4];
        token += "0123456789abcdef"[byte & 15];
    }
    return token;
}

std::string path_of_target(const std::string& target) { return target.substr(0, target.find('?')); }

std::string query_value(const std::string& target, const std::string& name) {
    std::size_t begin = target.find('?');
    while (begin != std::string::npos) {
        const std::size_t end = target.find('&', ++begin);
        const std::string pair = target.substr(begin, end == std::string::npos ? end : end - begin);
        if (pair.starts_with(name + "=")) return pair.substr(name.size() + 1);
        begin = end;
    }
    return {};
}

bool Access::is_own_host(const std::string& host) const {
    const std::size_t colon = host.rfind(':');
    const bool has_port = colon != std::string::npos && host.find(']', colon) == std::string::npos;
    const std::string name = host.substr(0, has_port ? colon : host.size()),
                      port = has_port ? host.substr(colon + 1) : "80";
    if (port_ != 0 && port != std::to_string(port_)) return false;
    const std::string own = address_.find(':') == std::string::npos ? address_ : '[' + address_ + ']';
    if (name == own || name == "localhost") return true;
    // A server for other machines is reached by one of several addresses, or by the name of this machine.
    const bool is_public = address_ != "127.0.0.1" && address_ != "::1";
    return is_public && (is_numeric_host(name) || (!name.empty() && name == host_name()));
}

std::string Access::refusal(const WebRequest& head) const {
    if (!is_own_host(head.host)) return "The header Host does not name this server.";
    if (head.origin && *head.origin != "http://" + head.host) return "The request comes from a page of another site.";
    if (head.fetch_site && *head.fetch_site != "same-origin" && *head.fetch_site != "none")
        return "The request comes from a page of another site.";
    if (!equal_in_constant_time(query_value(head.target, "token"), token_))
        return "The token is missing or wrong. Open the address that `kagero view` has printed.";
    return {};
}

bool RateLimit::permits(Clock::time_point now) {
    const std::lock_guard lock(mutex_);
    if (last_ != Clock::time_point{})
        available_ = std::min(burst_, available_ + rate_ * std::chrono::duration<double>(now - last_).count());
    last_ = now;
    if (available_ < 1) return false;
    available_ -= 1;
    return true;
}

}  // namespace kagero
