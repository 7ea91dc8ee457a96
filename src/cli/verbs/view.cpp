// kagero view: serves a page that shows a scene and changes it.
#include "cli/interrupt.h"
#include "cli/output.h"
#include "cli/verb.h"
#include "error.h"
#include "view/viewer.h"

#include <arpa/inet.h>
#include <malloc.h>

#include <chrono>
#include <ostream>
#include <thread>

namespace kagero {

namespace {

void declare_view(CLI::App& app, Arguments& arguments) {
    add_scene(app, arguments);
    add_option(app, "--port", arguments.port,
               "Port at which the server listens, 0 to 65535; 0: a free port. Default: 8080", "N");
    add_option(app, "--bind", arguments.bind,
               "Address at which the server listens. At another address than 127.0.0.1, everybody who has the token "
               "can use it over the network, and the connection is not encrypted. Default: 127.0.0.1",
               "ADDRESS");
    add_execution(app, arguments);
    add_lanes(app, arguments);
    add_messages(app, arguments);
}

/// Makes the C library return the memory of pictures and plans to the system. By default, each thread gets a heap of
/// its own, and large blocks are taken from these heaps, whose memory is then scattered over many pictures. The viewer,
/// which runs for hours, would grow to three times the memory that it needs.
void return_free_memory() {
    constexpr int large = 1 << 19;  // bytes
    mallopt(M_ARENA_MAX, 2);
    mallopt(M_MMAP_THRESHOLD, large);
    mallopt(M_TRIM_THRESHOLD, large);
}

/// Throws InputError unless the text is an IP address.
void check_address(const std::string& text) {
    in6_addr address{};
    for (const int family : {AF_INET, AF_INET6})
        if (inet_pton(family, text.c_str(), &address) == 1) return;
    throw InputError("--bind: '" + text +
                     "' is not an IP address, such as 127.0.0.1, ::1, or 0.0.0.0 for all "
                     "addresses of this machine");
}

int run_view(const Arguments& arguments, const Terminal& terminal) {
    return_free_memory();
    check_address(arguments.bind);
    const Options options = options_of(arguments);
    const std::uint32_t port = count_of("--port", arguments.port, 65535, 0);
    if (arguments.scene.empty()) scene_of(arguments, options);  // reports that no scene was given
    Viewer viewer(load_view_scene(arguments.scene, overrides_of(arguments), options), arguments.bind);
    const InterruptGuard guard;
    const auto server = start_web_server(arguments.bind, static_cast<std::uint16_t>(port), {}, viewer);
    const std::string url = viewer.url(server->port());
    write_output("-", [&](std::ostream& out) { out << url << std::endl; });
    terminal.note("open this address in a browser; Ctrl-C ends the viewer");
    while (!*InterruptGuard::requested()) std::this_thread::sleep_for(std::chrono::milliseconds(50));
    viewer.cancel();
    return exit_done;
}

}  // namespace

const Verb view_verb{"view", "Show a scene in the browser, and change it there", declare_view, run_view};

}  // namespace kagero
