/// The interface of the web module (view/http/module.cpp), which serves HTTP with Boost.Beast. It is a separate shared
/// library that only `kagero view` loads, so that other commands neither contain nor load a server.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace kagero {

/// A request: its head, and its body once that is complete.
struct WebRequest {
    std::string method;                             ///< Such as "GET".
    std::string target;                             ///< Path and query, such as "/picture?token=0".
    std::string host;                               ///< The header Host; "" if there is none, or more than one.
    std::optional<std::string> origin, fetch_site;  ///< The headers Origin and Sec-Fetch-Site.
    std::string body;
};

/// The answer to a request.
struct WebResponse {
    unsigned status = 200;
    std::string type = "text/plain; charset=utf-8";  ///< Value of Content-Type.
    std::vector<unsigned char> body{};
    std::vector<std::pair<std::string, std::string>> headers{};  ///< Further headers.
    std::function<void()> sent{};  ///< Called when the whole answer was sent. May be empty.
};

/// Returns an answer that consists of a text.
inline WebResponse text_response(unsigned status, const std::string& text, const std::string& type) {
    return {status, type, {text.begin(), text.end()}};
}

/// Bounds on what clients can make the server do.
struct WebLimits {
    /// Open connections. Beyond it, the connection whose client has been silent for the longest time is closed. If all
    /// requests are being answered, further connections get status 503.
    std::size_t connections = 64;
    std::size_t running = 16;          ///< Requests that are being answered. Further ones get status 503.
    std::size_t head_bytes = 8192;     ///< Size of the request line and the headers; beyond it: status 431.
    std::size_t body_bytes = 1 << 16;  ///< Size of the body; beyond it: status 413.
    unsigned read_seconds = 10;        ///< Time for a whole request. Slower connections are closed.
    unsigned write_seconds = 30;       ///< Time for a whole answer. Slower connections are closed.
};

/// Answers requests. All functions are called from several threads at once.
class WebHandler {
public:
    virtual ~WebHandler() = default;
    /// Returns the answer that refuses a request, from its head alone; nothing if its body may be read.
    virtual std::optional<WebResponse> refusal(const WebRequest& head) = 0;
    /// Returns the answer to a complete request that was not refused.
    virtual WebResponse answer(const WebRequest& request) = 0;
};

/// A running server. The destructor closes all connections and returns when no request is being answered any more.
class WebServer {
public:
    virtual ~WebServer() = default;
    virtual std::uint16_t port() const = 0;  ///< Returns the port, which the system chooses if 0 was requested.
};

/// The functions of the web module.
struct WebModule {
    std::uint32_t abi;  ///< The value of web_abi with which the module was compiled.
    /// Starts a server at an address and a port. The handler must outlive it. Returns "" on success, otherwise the
    /// reason for the failure.
    std::string (*start)(const std::string& address, std::uint16_t port, const WebLimits& limits, WebHandler& handler,
                         std::unique_ptr<WebServer>& server);
};

/// Version of this interface. It changes with every change of the types in this file.
inline constexpr std::uint32_t web_abi = 1;
/// Type of the function `kagero_web`, which the module exports.
using WebModuleFunction = const WebModule* (*)();

/// Loads the web module and starts a server. Throws RunError if the module is missing, or if the server cannot start.
std::unique_ptr<WebServer> start_web_server(const std::string& address, std::uint16_t port, const WebLimits& limits,
                                            WebHandler& handler);

}  // namespace kagero
