// The web module. This is the only file that uses Boost.Beast and Boost.Asio.
#include "view/web/web_server.h"

#include <boost/asio/bind_executor.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>

#include <atomic>
#include <chrono>
#include <list>
#include <thread>

namespace kagero {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::ip::tcp;
using boost::system::error_code;

class Connection;

/// What all connections share.
struct Shared {
    const WebLimits limits;
    WebHandler& handler;
    std::atomic<std::size_t> connections{0}, running{0};
    std::list<Connection*> reading;  ///< Connections whose request is not complete; the first has waited longest.
    asio::io_context io{1};          ///< Reads and writes, on one thread.
    asio::thread_pool pool;          ///< Answers requests.

    Shared(const WebLimits& l, WebHandler& h) : limits(l), handler(h), pool(l.running) {}
};

std::optional<std::string> header(const http::fields& fields, http::field name) {
    const auto found = fields.find(name);
    if (found == fields.end()) return {};
    return std::string(found->value());
}

/// Returns the request without its body.
template <class Message>
WebRequest request_head(const Message& message) {
    WebRequest request;
    request.method = std::string(message.method_string());
    request.target = std::string(message.target());
    if (message.count(http::field::host) == 1) request.host = *header(message, http::field::host);
    request.origin = header(message, http::field::origin);
    if (const auto site = message.find("Sec-Fetch-Site"); site != message.end())
        request.fetch_site = std::string(site->value());
    return request;
}

/// A connection. Pending operations own it. All functions except the answering of requests run on the thread of
/// Shared::io.
class Connection : public std::enable_shared_from_this<Connection> {
public:
    Connection(Shared& shared, tcp::socket socket) : shared_(shared), stream_(std::move(socket)) {
        ++shared_.connections;
    }
    ~Connection() {
        stop_reading();
        --shared_.connections;
    }

    /// Reads the next request.
    void read() {
        place_ = shared_.reading.insert(shared_.reading.end(), this);
        parser_.emplace();
        parser_->header_limit(static_cast<std::uint32_t>(shared_.limits.head_bytes));
        parser_->body_limit(shared_.limits.body_bytes);
        stream_.expires_after(std::chrono::seconds(shared_.limits.read_seconds));
        http::async_read_header(stream_, buffer_, *parser_,
                                [self = shared_from_this()](error_code error, std::size_t) { self->on_head(error); });
    }

    /// Ends the connection at once. Its pending operations fail.
    void close() {
        stop_reading();
        error_code ignored;
        stream_.socket().close(ignored);
    }

private:
    void stop_reading() {
        if (place_) shared_.reading.erase(*place_);
        place_.reset();
    }
    void on_head(error_code error) {
        if (error) return refuse_unreadable(error);
        WebRequest head = request_head(parser_->get());
        if (auto refusal = shared_.handler.refusal(head)) return respond(std::move(*refusal), false);
        http::async_read(stream_, buffer_, *parser_,
                         [self = shared_from_this(), head = std::move(head)](error_code e, std::size_t) mutable {
                             self->on_request(e, std::move(head));
                         });
    }
    void on_request(error_code error, WebRequest request) {
        if (error) return refuse_unreadable(error);
        stop_reading();
        request.body = std::move(parser_->get().body());
        const bool keep_alive = parser_->get().keep_alive();
        if (++shared_.running > shared_.limits.running) {
            --shared_.running;
            return respond(text_response(503, "The server is busy; try again.", "text/plain"), false);
        }
        stream_.expires_never();
        asio::post(shared_.pool, [self = shared_from_this(), request = std::move(request), keep_alive] {
            WebResponse response = self->answer(request);
            --self->shared_.running;
            asio::post(self->shared_.io, [self, keep_alive, response = std::move(response)]() mutable {
                self->respond(std::move(response), keep_alive);
            });
        });
    }
    WebResponse answer(const WebRequest& request) {
        try {
            return shared_.handler.answer(request);
        } catch (const std::exception& exception) {
            return text_response(500, exception.what(), "text/plain; charset=utf-8");
        }
    }
    /// Answers a request that violates a limit or is not HTTP. Closes the connection in all other cases.
    void refuse_unreadable(error_code error) {
        const auto refuse = [&](unsigned status, const char* text) {
            respond(text_response(status, text, "text/plain"), false);
        };
        if (error == http::error::body_limit) return refuse(413, "The body of the request is too large.");
        if (error == http::error::header_limit || error == http::error::buffer_overflow)
            return refuse(431, "The head of the request is too large.");
        const bool is_http_error = error.category() == make_error_code(http::error::bad_value).category();
        if (is_http_error && error != http::error::end_of_stream && error != http::error::partial_message)
            return refuse(400, "The request is not valid HTTP.");
        close();
    }
    void respond(WebResponse response, bool keep_alive) {
        stop_reading();
        message_.emplace();
        message_->result(response.status);
        message_->version(11);
        message_->set(http::field::content_type, response.type);
        for (const auto& [name, value] : response.headers) message_->set(name, value);
        message_->body() = std::move(response.body);
        message_->keep_alive(keep_alive);
        message_->prepare_payload();
        stream_.expires_after(std::chrono::seconds(shared_.limits.write_seconds));
        http::async_write(stream_, *message_,
                          [self = shared_from_this(), sent = std::move(response.sent), keep_alive](error_code error,
                                                                                                   std::size_t) {
                              self->message_.reset();
                              if (error) return self->close();
                              if (sent) sent();
                              if (keep_alive) return self->read();
                              self->finish();
                          });
    }
    /// Ends the connection. The rest of the request is read for a short time, because a client that is still sending
    /// would otherwise not receive the answer.
    void finish() {
        error_code ignored;
        stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
        stream_.expires_after(std::chrono::seconds(1));
        discard();
    }
    void discard() {
        const auto self = shared_from_this();
        stream_.async_read_some(asio::buffer(discarded_), [self](error_code error, std::size_t bytes) {
            constexpr std::size_t most = 1 << 22;
            self->discarded_bytes_ += bytes;
            if (error || self->discarded_bytes_ > most) return self->close();
            self->discard();
        });
    }

    Shared& shared_;
    std::optional<std::list<Connection*>::iterator> place_;  ///< That in Shared::reading.
    beast::tcp_stream stream_;
    beast::flat_buffer buffer_{1 << 14};
    std::optional<http::request_parser<http::string_body>> parser_;
    std::optional<http::response<http::vector_body<unsigned char>>> message_;
    std::array<char, 4096> discarded_{};
    std::size_t discarded_bytes_ = 0;
};

/// A server with its threads.
class BeastServer final : public WebServer {
public:
    /// Starts to listen. Sets `reason` if that fails.
    BeastServer(const std::string& address, std::uint16_t port, const WebLimits& limits, WebHandler& handler,
                std::string& reason)
        : shared_(limits, handler), acceptor_(shared_.io), retry_(shared_.io) {
        error_code error;
        listen(address, port, error);
        if (error) {
            reason = error.message();
            return;
        }
        port_ = acceptor_.local_endpoint().port();
        accept();
        thread_ = std::jthread([this] { shared_.io.run(); });
    }
    ~BeastServer() override {
        shared_.io.stop();
        if (thread_.joinable()) thread_.join();
        shared_.pool.join();
    }
    std::uint16_t port() const override { return port_; }

private:
    void listen(const std::string& address, std::uint16_t port, error_code& error) {
        const auto ip = asio::ip::make_address(address, error);
        if (error) return;
        const tcp::endpoint endpoint(ip, port);
        acceptor_.open(endpoint.protocol(), error);
        if (error) return;
        acceptor_.set_option(asio::socket_base::reuse_address(true), error);
        if (error) return;
        acceptor_.bind(endpoint, error);
        if (error) return;
        acceptor_.listen(asio::socket_base::max_listen_connections, error);
    }
    void accept() {
        acceptor_.async_accept([this](error_code error, tcp::socket socket) {
            if (error == asio::error::operation_aborted) return;
            if (error) return accept_later();  // for example, no file descriptor is left
            if (has_place()) {
                error_code ignored;
                socket.set_option(tcp::no_delay(true), ignored);
                std::make_shared<Connection>(shared_, std::move(socket))->read();
            } else turn_away(std::move(socket));
            accept();
        });
    }
    /// Returns true if another connection may be accepted. If there are too many, the one whose client has been silent
    /// for the longest time is closed; connections whose requests are being answered are kept.
    bool has_place() {
        if (shared_.connections < shared_.limits.connections) return true;
        if (shared_.reading.empty()) return false;
        shared_.reading.front()->close();
        return true;
    }
    void accept_later() {
        retry_.expires_after(std::chrono::milliseconds(50));
        retry_.async_wait([this](error_code error) {
            if (!error) accept();
        });
    }
    static void turn_away(tcp::socket socket) {
        static constexpr char answer[] =
            "HTTP/1.1 503 Service Unavailable\r\nConnection: close\r\nContent-Length: 0\r\n\r\n";
        error_code ignored;
        socket.non_blocking(true, ignored);
        socket.write_some(asio::buffer(answer, sizeof answer - 1), ignored);
        socket.shutdown(tcp::socket::shutdown_both, ignored);
    }

    Shared shared_;
    tcp::acceptor acceptor_;
    asio::steady_timer retry_;
    std::uint16_t port_ = 0;
    std::jthread thread_;
};

/// Starts a server; implements WebModule::start.
std::string start(const std::string& address, std::uint16_t port, const WebLimits& limits, WebHandler& handler,
                  std::unique_ptr<WebServer>& server) {
    std::string reason;
    auto started = std::make_unique<BeastServer>(address, port, limits, handler, reason);
    if (reason.empty()) server = std::move(started);
    return reason;
}

constexpr WebModule the_web_module{web_abi, start};

}  // namespace
}  // namespace kagero

extern "C" __attribute__((visibility("default"))) const kagero::WebModule* kagero_web() {
    return &kagero::the_web_module;
}
