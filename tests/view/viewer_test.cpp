// The viewer over HTTP: pictures, errors, and requests that must be refused while the server continues to run.
#include "view/viewer.h"
#include "tests/view/http_client.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <thread>

namespace kagero::test {
namespace {

/// A viewer of a small scene at a free port.
class ViewerTest : public ::testing::Test {
protected:
    explicit ViewerTest(const std::string& scene = "hole.toml")
        : viewer_(load_view_scene(std::string(KAGERO_SCENES) + "/" + scene, {"film.size=[64,48]"}, {}), "127.0.0.1"),
          server_(start_web_server("127.0.0.1", 0, {}, viewer_)) {
        viewer_.url(server_->port());
    }
    std::string host() const { return "127.0.0.1:" + std::to_string(server_->port()); }
    std::string request(const std::string& method, const std::string& path, const std::string& body = "",
                        const std::string& headers = "") const {
        const std::string separator = path.find('?') == std::string::npos ? "?" : "&";
        return method + " " + path + separator + "token=" + viewer_.token() + " HTTP/1.1\r\nHost: " + host() + "\r\n" +
               headers + "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body;
    }
    std::string answer_to(const std::string& text) const {
        const Client client(server_->port());
        client.send(text);
        return client.receive();
    }
    int status_after(const std::string& text) const { return status_of(answer_to(text)); }
    /// Expects that the server still makes pictures.
    void expect_alive() const {
        const std::string answer = answer_to(request("POST", "/picture", R"({"tab": "alive", "quality": "full"})"));
        EXPECT_EQ(status_of(answer), 200);
        EXPECT_TRUE(body_of(answer).starts_with("\x89PNG")) << answer.substr(0, 300);
    }

    Viewer viewer_;
    std::unique_ptr<WebServer> server_;
};

TEST_F(ViewerTest, ServesThePageAndItsFiles) {
    const std::string page = answer_to(request("GET", "/"));
    EXPECT_EQ(status_of(page), 200);
    EXPECT_NE(page.find("Content-Security-Policy: default-src 'none'"), std::string::npos);
    EXPECT_NE(page.find("view.js?token=" + viewer_.token()), std::string::npos);
    EXPECT_EQ(page.find("@TOKEN@"), std::string::npos);
    EXPECT_EQ(status_after(request("GET", "/view.js")), 200);
    EXPECT_EQ(status_after(request("GET", "/view.css")), 200);
    for (const char* path : {"/nothing", "/../view.js", "/etc/passwd", "//", "/view.js/", "/%2e%2e/"})
        EXPECT_EQ(status_after(request("GET", path)), 404) << path;
}

TEST_F(ViewerTest, DescribesTheScene) {
    const auto scene = nlohmann::json::parse(body_of(answer_to(request("GET", "/scene"))));
    EXPECT_FALSE(scene.at("parameters").empty());
    for (const auto& parameter : scene["parameters"])
        for (const char* key : {"key", "value", "least", "greatest", "unit", "meaning"})
            EXPECT_TRUE(parameter.contains(key)) << key;
    EXPECT_GT(scene.at("layers").size(), 5u);
}

TEST_F(ViewerTest, MakesMovingAndStillPictures) {
    const std::string first = answer_to(request("POST", "/picture", R"({"tab": "a", "quality": "moving"})"));
    EXPECT_EQ(status_of(first), 200);
    const std::string second =
        answer_to(request("POST", "/picture", R"({"tab": "a", "quality": "moving", "keys": {"camera.fov": 50}})"));
    EXPECT_TRUE(body_of(second).starts_with("\xff\xd8\xff")) << "moving pictures are JPEG files";
    EXPECT_NE(second.find("X-Kagero: {\"width\":64,\"height\":48"), std::string::npos) << second.substr(0, 600);
    expect_alive();
    const auto stats = nlohmann::json::parse(body_of(answer_to(request("GET", "/stats"))));
    for (const char* key : {"fps", "width", "height", "ms", "mrays_per_s", "traced_share"})
        EXPECT_TRUE(stats.contains(key)) << key;
    for (const char* key : {"trace", "shade", "encode"}) EXPECT_TRUE(stats["ms"].contains(key)) << key;
    EXPECT_EQ(stats["width"], 64);
}

TEST_F(ViewerTest, TracesThePixelAndSaves) {
    const auto pixel = nlohmann::json::parse(body_of(answer_to(request("POST", "/pixel?x=3&y=4", R"({"tab": "a"})"))));
    EXPECT_EQ(pixel.at("status"), "escaped");
    EXPECT_GT(pixel.at("path").size(), 1u);
    EXPECT_GE(pixel.at("position_error").get<double>(), 0);
    EXPECT_EQ(status_after(request("POST", "/pixel?x=64&y=4", R"({"tab": "a"})")), 422);
    EXPECT_TRUE(body_of(answer_to(request("POST", "/file?format=exr", R"({"tab": "a"})"))).starts_with("v/1\x01"));
    EXPECT_TRUE(body_of(answer_to(request("POST", "/file?format=png", R"({"tab": "a"})"))).starts_with("\x89PNG"));
    const std::string toml =
        body_of(answer_to(request("POST", "/file?format=toml", R"({"tab": "a", "keys": {"camera.fov": 51}})")));
    EXPECT_NE(toml.find("fov = 51"), std::string::npos) << toml;
    EXPECT_EQ(status_after(request("POST", "/file?format=../x", R"({"tab": "a"})")), 422);
}

TEST_F(ViewerTest, ReportsInvalidValues) {
    const std::string answer = answer_to(request("POST", "/picture", R"({"tab": "a", "keys": {"camera.fov": 1000}})"));
    EXPECT_EQ(status_of(answer), 422);
    EXPECT_NE(answer.find("fov"), std::string::npos);
    const std::string file =
        answer_to(request("POST", "/picture", R"({"tab": "a", "keys": {"sky.texture": "/etc/passwd"}})"));
    EXPECT_EQ(status_of(file), 422);
    EXPECT_NE(file.find("cannot be changed"), std::string::npos);
    expect_alive();
}

TEST_F(ViewerTest, RefusesForeignRequests) {
    const std::string head = " HTTP/1.1\r\n", own = "Host: " + host() + "\r\n",
                      target = "GET /?token=" + viewer_.token();
    EXPECT_EQ(status_after("GET /" + head + own + "\r\n"), 403);
    EXPECT_EQ(status_after("GET /?token=0" + head + own + "\r\n"), 403);
    EXPECT_EQ(status_after(target + head + own + "Origin: http://example.org\r\n\r\n"), 403);
    EXPECT_EQ(status_after(target + head + own + "Sec-Fetch-Site: cross-site\r\n\r\n"), 403);
    EXPECT_EQ(status_after(target + head + "Host: example.org\r\n\r\n"), 403);
    EXPECT_EQ(status_after(target + head + own + own + "\r\n"), 403);
    EXPECT_EQ(status_after(target + head + "\r\n"), 403);
    EXPECT_EQ(status_after("DELETE /?token=" + viewer_.token() + head + own + "\r\n"), 405);
    expect_alive();
}

TEST_F(ViewerTest, RefusesLargeAndDamagedRequests) {
    const Client large(server_->port());
    large.send("POST /picture?token=" + viewer_.token() + " HTTP/1.1\r\nHost: " + host() +
               "\r\nContent-Length: 104857600\r\n\r\n");
    const std::string megabyte(1 << 20, 'x');
    for (int i = 0; i < 100 && large.send(megabyte);) ++i;
    EXPECT_EQ(status_of(large.receive()), 413);
    const Client chunked(server_->port());
    chunked.send("POST /picture?token=" + viewer_.token() + " HTTP/1.1\r\nHost: " + host() +
                 "\r\nTransfer-Encoding: chunked\r\n\r\n");
    for (int i = 0; i < 100 && chunked.send("10000\r\n" + std::string(65536, 'x') + "\r\n");) ++i;
    EXPECT_EQ(status_of(chunked.receive()), 413);
    EXPECT_EQ(status_after("GET /" + std::string(100000, 'x') + " HTTP/1.1\r\n\r\n"), 431);
    EXPECT_EQ(status_after("this is not HTTP\r\n\r\n"), 400);
    expect_alive();
}

TEST_F(ViewerTest, SurvivesAThousandConnections) {
    std::vector<Client> clients;
    for (int i = 0; i < 1000; ++i) clients.emplace_back(server_->port());
    int refused = 0, answered = 0;
    for (const Client& client : clients) client.send(request("GET", "/stats"));
    for (const Client& client : clients) {
        const int status = status_of(client.receive());
        answered += status == 200;
        refused += status == 503 || status == 429 || status == 0;  // 0: closed before the request arrived
    }
    EXPECT_EQ(answered + refused, 1000);
    EXPECT_GT(answered, 10);
    EXPECT_GT(refused, 500) << "more connections than permitted must be refused";
    clients.clear();
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    expect_alive();
}

TEST_F(ViewerTest, DoesNotWaitForSlowClients) {
    std::vector<Client> silent;
    for (int i = 0; i < 30; ++i) silent.emplace_back(server_->port());
    for (const Client& client : silent) client.send("POST /picture?token=");
    expect_alive();
    {
        const Client closed(server_->port());  // closes before its picture is ready
        closed.send(request("POST", "/picture", R"({"tab": "b", "quality": "full"})"));
    }
    expect_alive();
}

// More silent connections than permitted: the one that is silent for the longest time is closed at once.
TEST_F(ViewerTest, DoesNotWaitForMoreSilentClientsThanPermitted) {
    std::vector<Client> silent;
    for (std::size_t i = 0; i < 3 * WebLimits{}.connections; ++i) silent.emplace_back(server_->port());
    const auto begin = std::chrono::steady_clock::now();
    for (int i = 0; i < 5; ++i) expect_alive();
    const std::chrono::duration<double> waited = std::chrono::steady_clock::now() - begin;
    EXPECT_LT(waited.count(), WebLimits{}.read_seconds / 2);
    silent.back().send(request("GET", "/stats"));
    EXPECT_EQ(status_of(silent.back().receive()), 200) << "the connection that was opened last must be kept";
    EXPECT_EQ(silent.front().receive(), "") << "the connection that was opened first must be closed";
}

TEST_F(ViewerTest, ServesTwoPagesAndBoundsTheirNumber) {
    const auto picture = [&](int tab) {
        return status_after(request("POST", "/picture", R"({"tab": "t)" + std::to_string(tab) + "\"}"));
    };
    for (std::size_t i = 0; i < Tabs::max_tabs; ++i) EXPECT_EQ(picture(int(i)), 200) << i;
    EXPECT_EQ(picture(100), 422);
    EXPECT_EQ(picture(0), 200);
}

TEST_F(ViewerTest, KeepsAConnectionOpen) {
    const Client client(server_->port());
    for (int i = 0; i < 5; ++i) {
        client.send(request("GET", "/stats"));
        EXPECT_EQ(status_of(client.receive()), 200);
    }
}

class FormulaViewerTest : public ViewerTest {
protected:
    FormulaViewerTest() : ViewerTest("formula-reissner-nordstrom.toml") {}
};

TEST_F(FormulaViewerTest, ReportsMistakesInAFormula) {
    const std::string answer =
        answer_to(request("POST", "/picture", R"~({"tab": "a", "keys": {"space.H": "px^2 + cso(x)"}})~"));
    EXPECT_EQ(status_of(answer), 422);
    EXPECT_NE(body_of(answer).find("space.H"), std::string::npos) << answer;
    expect_alive();
}

}  // namespace
}  // namespace kagero::test
