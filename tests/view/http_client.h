/// A client that sends HTTP requests as text, so that it can also send invalid ones.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <string>
#include <utility>

namespace kagero::test {

/// A connection to a port of this machine.
class Client {
public:
    explicit Client(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(port);
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        timeval limit{20, 0};
        ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
        ::setsockopt(socket_, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);
        connected_ = ::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
    }
    Client(Client&& other) noexcept
        : socket_(std::exchange(other.socket_, -1)), connected_(std::exchange(other.connected_, false)) {}
    ~Client() {
        if (socket_ >= 0) ::close(socket_);
    }
    bool connected() const { return connected_; }
    /// Sends a text. Returns false if the server has closed the connection.
    bool send(const std::string& text) const {
        for (std::size_t sent = 0; sent < text.size();) {
            const ssize_t count = ::send(socket_, text.data() + sent, text.size() - sent, MSG_NOSIGNAL);
            if (count <= 0) return false;
            sent += std::size_t(count);
        }
        return true;
    }
    /// Reads one answer with a Content-Length; what was read so far if the connection ends.
    std::string receive() const {
        std::string answer;
        char buffer[65536];
        while (!is_complete(answer)) {
            const ssize_t count = ::recv(socket_, buffer, sizeof buffer, 0);
            if (count <= 0) break;
            answer.append(buffer, std::size_t(count));
        }
        return answer;
    }

private:
    static bool is_complete(const std::string& answer) {
        const std::size_t end = answer.find("\r\n\r\n"), length = answer.find("Content-Length: ");
        if (end == std::string::npos) return false;
        const std::size_t body = length < end ? std::strtoul(&answer[length + 16], nullptr, 10) : 0;
        return answer.size() >= end + 4 + body;
    }
    int socket_;
    bool connected_;
};

/// Returns the status of an answer; 0 if there is none.
inline int status_of(const std::string& answer) {
    return answer.starts_with("HTTP/1.1 ") ? std::atoi(answer.c_str() + 9) : 0;
}
/// Returns the body of an answer.
inline std::string body_of(const std::string& answer) {
    const std::size_t end = answer.find("\r\n\r\n");
    return end == std::string::npos ? "" : answer.substr(end + 4);
}

}  // namespace kagero::test
