#include "view/web/web_server.h"

#include "error.h"
#include "modules/module_files.h"

namespace kagero {
namespace {

const WebModule& web_module() {
    static const WebModule& loaded = []() -> const WebModule& {
        const std::string path = module_file("kagero-view.so");
        if (path.empty())
            throw RunError(
                "the web module kagero-view.so was not found in lib/kagero beside the program; it is built where the "
                "headers of Boost.Beast (package libboost-dev) are installed");
        const WebModule* module = reinterpret_cast<WebModuleFunction>(open_module(path, "kagero_web"))();
        if (module->abi != web_abi)
            throw RunError(path + " belongs to another version of kagero; build or install kagero again");
        return *module;
    }();
    return loaded;
}

}  // namespace

std::unique_ptr<WebServer> start_web_server(const std::string& address, std::uint16_t port, const WebLimits& limits,
                                            WebHandler& handler) {
    std::unique_ptr<WebServer> server;
    const std::string reason = web_module().start(address, port, limits, handler, server);
    if (!reason.empty())
        throw RunError("the server cannot listen at " + address + ", port " + std::to_string(port) + ": " + reason +
                       "; choose another address with --bind or another port with --port (0: any free port)");
    return server;
}

}  // namespace kagero
