#include "view/viewer.h"

#include "error.h"
#include "modules/modules.h"
#include "report/explanation.h"
#include "scene/print.h"
#include "view/controls.h"
#include "view/encoder.h"
#include "view/pixel_report.h"
#include "view/web/page.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace kagero {
namespace {

using Clock = std::chrono::steady_clock;

/// Requests per second on average, and at once. A page that moves at 60 pictures a second sends fewer.
constexpr double max_request_rate = 300, max_request_burst = 600;

constexpr const char* json_type = "application/json";

WebResponse json_response(unsigned status, const Json& json) { return text_response(status, text_of(json), json_type); }
WebResponse error_response(unsigned status, const std::string& message) {
    return json_response(status, {{"error", message}});
}

/// Adds the headers of all answers: nothing may be kept, framed, or taken for another type, and the page loads nothing
/// from elsewhere.
void add_protection(WebResponse& response) {
    response.headers.insert(
        response.headers.end(),
        {{"Cache-Control", "no-store"},
         {"X-Content-Type-Options", "nosniff"},
         {"Referrer-Policy", "no-referrer"},
         {"X-Frame-Options", "DENY"},
         {"Cross-Origin-Resource-Policy", "same-origin"},
         {"Content-Security-Policy",
          "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; "
          "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"}});
}

/// Marks the whole picture of a tab as running during its lifetime, so that a newer request can cancel it.
class Running {
public:
    explicit Running(Tab& tab) : tab_(tab), stop_(std::make_shared<std::atomic<bool>>(false)) {
        const std::lock_guard lock(tab_.running_mutex);
        tab_.running = stop_;
    }
    ~Running() {
        const std::lock_guard lock(tab_.running_mutex);
        tab_.running.reset();
    }
    const std::atomic<bool>& stop() const { return *stop_; }

private:
    Tab& tab_;
    std::shared_ptr<std::atomic<bool>> stop_;
};

/// Returns one line of JSON without characters that a header cannot contain.
std::string header_text(const Json& json) { return json.dump(-1, ' ', true, Json::error_handler_t::replace); }

Json info_json(const LivePicture& picture, const ViewState& state, const EncodedPicture& encoded) {
    const auto number = [](double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); };
    return {{"width", picture.width},
            {"height", picture.height},
            {"reduction", picture.reduction},
            {"spp", picture.plan->description().film.spp},
            {"method", picture.plan->scene->straight ? "straight rays" : picture.plan->method().name},
            {"integration_error", number(picture.integration_error)},
            {"interpolation_error", {{"p99", picture.interpolation_p99}, {"max", picture.interpolation_max}}},
            {"traced_share",
             double(picture.rays) / (double(picture.width) * picture.height * picture.plan->description().film.spp)},
            {"reuse", picture.reuse},
            {"layer", state.layer},
            {"scale", {number(encoded.least), number(encoded.greatest)}},
            {"remarks", picture.remarks}};
}

std::uint32_t coordinate(const std::string& target, const char* name, std::uint32_t size) {
    const std::string text = query_value(target, name);
    std::uint32_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size() || value >= size)
        throw InputError(std::string(name) + ": the value must be a whole number from 0 to " +
                         std::to_string(size - 1));
    return value;
}

}  // namespace

Viewer::Viewer(ViewScene scene, const std::string& address)
    : scene_(std::move(scene)), address_(address), access_(random_token(), address),
      rate_(max_request_rate, max_request_burst), tabs_(scene_) {}

std::string Viewer::url(std::uint16_t port) {
    access_.set_port(port);
    const std::string host = address_.find(':') == std::string::npos ? address_ : '[' + address_ + ']';
    return "http://" + host + ':' + std::to_string(port) + "/?token=" + access_.token();
}

std::optional<WebResponse> Viewer::refusal(const WebRequest& head) {
    const auto refuse = [](unsigned status, const std::string& reason) {
        WebResponse response = error_response(status, reason);
        add_protection(response);
        return response;
    };
    if (const std::string reason = access_.refusal(head); !reason.empty()) return refuse(403, reason);
    if (!rate_.permits(Clock::now())) return refuse(429, "There were too many requests; try again in a second.");
    if (head.method != "GET" && head.method != "POST") return refuse(405, "The method must be GET or POST.");
    return {};
}

WebResponse Viewer::answer(const WebRequest& request) {
    WebResponse response;
    try {
        response = answer_unprotected(request);
    } catch (const InputError& error) {
        response = error_response(422, error.what());
    } catch (const Interrupted&) {
        response = text_response(204, "", "text/plain");
    } catch (const std::bad_alloc&) {
        response = error_response(500, "There is not enough memory for this picture.");
    } catch (const std::exception& error) {
        response = error_response(500, error.what());
    }
    add_protection(response);
    return response;
}

WebResponse Viewer::answer_unprotected(const WebRequest& request) {
    const std::string path = path_of_target(request.target);
    if (request.method == "GET") {
        if (path == "/stats") return json_response(200, statistics_.json(Clock::now()));
        if (path == "/scene") return scene_controls();
        if (auto file = page_file(path, access_.token())) return std::move(*file);
    } else {
        if (path == "/picture") return picture(request.body);
        if (path == "/pixel") return pixel(request.body, request.target);
        if (path == "/file") return file(request.body, query_value(request.target, "format"));
    }
    return error_response(404, "There is no such page.");
}

WebResponse Viewer::scene_controls() const {
    const Module& module = load_module(scene_.options.isa);
    const HamiltonianInfo& info = module.hamiltonians[hamiltonian_index(module, scene_.description.space.hamiltonian)];
    return json_response(200, controls_json(scene_.description, info));
}

std::shared_ptr<Tab> Viewer::tab_of(const ViewState& state) {
    auto tab = tabs_.find(state.tab, Clock::now());
    if (!tab) throw InputError("too many pages of the viewer are open; close one and try again in some seconds");
    return tab;
}

WebResponse Viewer::picture(const std::string& body) {
    const ViewState state = parse_view_state(body, scene_.description);
    const std::shared_ptr<Tab> tab = tab_of(state);
    const std::uint64_t number = ++tab->newest;
    tab->cancel();
    auto made = std::make_shared<LivePicture>();
    {
        const std::lock_guard lock(tab->making);
        // A page may send a request before it has the answer to the previous one, but earlier ones are obsolete.
        if (number + 1 < tab->newest) throw Interrupted();
        static const std::atomic<bool> never{false};
        if (state.quality == Quality::moving) {
            *made = tab->maker.make(state, never);
        } else {
            const Running running(*tab);
            if (number < tab->newest) throw Interrupted();
            *made = tab->maker.make(state, running.stop());
        }
    }
    return encoded_answer(made, state);
}

WebResponse Viewer::encoded_answer(std::shared_ptr<const LivePicture> picture, const ViewState& state) {
    const auto begin = Clock::now();
    const bool is_moving = state.quality == Quality::moving;
    EncodedPicture encoded = picture->film ? encode_layer(*picture->film, state.layer, is_moving)
                                           : encode_moving(picture->rgb, picture->width, picture->height);
    const double encode_seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    WebResponse response{200, encoded.type, std::move(encoded.bytes)};
    response.headers.emplace_back("X-Kagero", header_text(info_json(*picture, state, encoded)));
    response.sent = [this, picture = std::move(picture), encode_seconds] {
        statistics_.add_delivered(*picture, encode_seconds, Clock::now());
    };
    return response;
}

WebResponse Viewer::pixel(const std::string& body, const std::string& target) {
    ViewState state = parse_view_state(body, scene_.description);
    const std::uint32_t x = coordinate(target, "x", state.width), y = coordinate(target, "y", state.height);
    state.quality = Quality::full;
    const std::shared_ptr<Tab> tab = tab_of(state);
    std::shared_ptr<const Plan> plan;
    {
        const std::lock_guard lock(tab->making);
        const Running running(*tab);
        plan = tab->maker.full_plan(state, running.stop());
    }
    return json_response(200, pixel_json(*plan, x, y));
}

WebResponse Viewer::file(const std::string& body, const std::string& format) {
    ViewState state = parse_view_state(body, scene_.description);
    if (state.quality == Quality::moving) state.quality = Quality::full;
    const std::shared_ptr<Tab> tab = tab_of(state);
    WebResponse response;
    if (format == "toml") {
        response = text_response(200, print_scene(description_of(scene_, state)), "application/toml");
    } else if (format == "png" || format == "exr") {
        LivePicture made;
        {
            const std::lock_guard lock(tab->making);
            const Running running(*tab);
            made = tab->maker.make(state, running.stop());
        }
        if (format == "exr") response.body = encode_film(*made.film, ".exr", made.metadata);
        else response.body = encode_layer(*made.film, state.layer, false).bytes;
        response.type = format == "exr" ? "image/x-exr" : "image/png";
    } else {
        throw InputError("format: the value must be toml, png or exr");
    }
    response.headers.emplace_back("Content-Disposition", "attachment; filename=\"kagero." + format + "\"");
    return response;
}

}  // namespace kagero
