#include "film/codec.h"

#include "error.h"
#include "modules/places.h"

namespace kagero {

const Codec& codec() {
    static const Codec& loaded = []() -> const Codec& {
        const std::string path = module_file("kagero-images.so");
        if (path.empty()) throw RunError("the module that reads and writes images, kagero-images.so, was not found beside the program (lib/kagero)");
        const Codec* offered = reinterpret_cast<KageroCodec>(open_module(path, "kagero_codec"))();
        if (offered->abi != codec_abi) throw RunError(path + " belongs to another version of kagero; build it anew");
        return *offered;
    }();
    return loaded;
}

}  // namespace kagero
