/// The viewer: answers the requests of its pages.
#pragma once

#include "view/statistics.h"
#include "view/tabs.h"
#include "view/web/access.h"

namespace kagero {

/// The viewer of a scene. It writes no files and reads none because of a request.
class Viewer final : public WebHandler {
public:
    /// `address` is the address at which the server will listen. The token is random.
    Viewer(ViewScene scene, const std::string& address);
    /// Returns the URL of the page, once the port is known.
    std::string url(std::uint16_t port);
    const std::string& token() const { return access_.token(); }
    /// Cancels all pictures that are being made.
    void cancel() { tabs_.cancel_all(); }

    std::optional<WebResponse> refusal(const WebRequest& head) override;
    WebResponse answer(const WebRequest& request) override;

private:
    WebResponse answer_unprotected(const WebRequest& request);
    WebResponse scene_controls() const;
    WebResponse picture(const std::string& body);
    WebResponse pixel(const std::string& body, const std::string& target);
    WebResponse file(const std::string& body, const std::string& format);
    WebResponse encoded_answer(std::shared_ptr<const LivePicture> picture, const ViewState& state);
    /// Returns the page of a state, and throws InputError if too many pages are in use.
    std::shared_ptr<Tab> tab_of(const ViewState& state);

    ViewScene scene_;
    std::string address_;
    Access access_;
    RateLimit rate_;
    Tabs tabs_;
    Statistics statistics_;
};

}  // namespace kagero
