// Protection of the viewer: token, Host, Origin, and the rate of requests.
#include "view/web/access.h"

#include <gtest/gtest.h>

namespace kagero::test {
namespace {

constexpr const char* token = "0123456789abcdef0123456789abcdef";

Access access_at(const std::string& address = "127.0.0.1") {
    Access access(token, address);
    access.set_port(8080);
    return access;
}

/// Returns a request that the page itself would send.
WebRequest own_request() {
    WebRequest request;
    request.method = "POST";
    request.target = std::string("/picture?token=") + token;
    request.host = "127.0.0.1:8080";
    request.origin = "http://127.0.0.1:8080";
    request.fetch_site = "same-origin";
    return request;
}

TEST(ViewerAccess, PermitsThePage) {
    EXPECT_EQ(access_at().refusal(own_request()), "");
    WebRequest first = own_request();  // typed into the address bar
    first.origin.reset();
    first.fetch_site = "none";
    EXPECT_EQ(access_at().refusal(first), "");
    first.host = "localhost:8080";
    EXPECT_EQ(access_at().refusal(first), "");
}

TEST(ViewerAccess, NeedsTheWholeToken) {
    for (const std::string wrong : {"", "0", "0123456789abcdef0123456789abcdee", "0123456789abcdef0123456789abcdef0"}) {
        WebRequest request = own_request();
        request.target = "/picture?token=" + wrong;
        EXPECT_NE(access_at().refusal(request).find("token"), std::string::npos) << wrong;
    }
    WebRequest request = own_request();
    request.target = std::string("/picture?mytoken=") + token;
    EXPECT_NE(access_at().refusal(request), "");
}

TEST(ViewerAccess, RefusesOtherHosts) {
    for (const std::string host : {"", "example.org", "example.org:8080", "127.0.0.1", "127.0.0.1:8081",
                                   "127.0.0.2:8080", "127.0.0.1.example.org:8080", "[::1]:8080"}) {
        WebRequest request = own_request();
        request.host = host;
        request.origin = "http://" + host;
        EXPECT_NE(access_at().refusal(request).find("Host"), std::string::npos) << host;
    }
}

TEST(ViewerAccess, RefusesOtherOrigins) {
    for (const std::string origin :
         {"null", "http://example.org", "https://127.0.0.1:8080", "http://127.0.0.1:8081", "http://localhost:8080"}) {
        WebRequest request = own_request();
        request.origin = origin;
        EXPECT_NE(access_at().refusal(request).find("another site"), std::string::npos) << origin;
    }
    WebRequest request = own_request();
    request.origin.reset();
    request.fetch_site = "cross-site";
    EXPECT_NE(access_at().refusal(request), "");
}

TEST(ViewerAccess, PermitsNumericHostsIfItServesOtherMachines) {
    const Access access = access_at("0.0.0.0");
    WebRequest request = own_request();
    request.host = "192.0.2.7:8080";
    request.origin = "http://192.0.2.7:8080";
    EXPECT_EQ(access.refusal(request), "");
    request.host = "example.org:8080";
    request.origin = "http://example.org:8080";
    EXPECT_NE(access.refusal(request), "");
}

TEST(ViewerAccess, MakesDifferentTokens) {
    const std::string a = random_token(), b = random_token();
    EXPECT_EQ(a.size(), 32u);
    EXPECT_NE(a, b);
    EXPECT_EQ(a.find_first_not_of("0123456789abcdef"), std::string::npos);
}

TEST(ViewerAccess, ReadsQueries) {
    EXPECT_EQ(query_value("/pixel?token=a&x=12&y=7", "x"), "12");
    EXPECT_EQ(query_value("/pixel?token=a&x=12&y=7", "y"), "7");
    EXPECT_EQ(query_value("/pixel?token=a&x=12&y=7", "z"), "");
    EXPECT_EQ(query_value("/pixel", "x"), "");
    EXPECT_EQ(path_of_target("/pixel?token=a"), "/pixel");
}

TEST(ViewerAccess, BoundsTheRate) {
    RateLimit limit(10, 5);
    const auto start = RateLimit::Clock::now();
    int permitted = 0;
    for (int i = 0; i < 100; ++i) permitted += limit.permits(start);
    EXPECT_EQ(permitted, 5);
    for (int i = 0; i < 100; ++i) permitted += limit.permits(start + std::chrono::milliseconds(301));
    EXPECT_EQ(permitted, 8);
}

}  // namespace
}  // namespace kagero::test
