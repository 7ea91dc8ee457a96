// Fuzz target for the reader of rays: any text must be read as rays or refused by an InputError.
#include "error.h"
#include "report/csv/read_rays.h"
#include "target.h"

#include <sstream>

const char* const fuzz_words =
    "x y z dx dy dz x,y,z,dx,dy,dz , \" \"\" ; 1e308 -1e-320 nan inf -inf 0x1p3 1e 1e+ . - + \\r\\n # \xef\xbb\xbf";

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    std::istringstream in(std::string(reinterpret_cast<const char*>(data), size));
    try {
        kagero::read_rays(in, "rays");
        return 0;
    } catch (const kagero::InputError&) {
        return -1;
    }
}
