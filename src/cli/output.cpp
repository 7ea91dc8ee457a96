#include "cli/verb.h"
#include "error.h"
#include "film/partial_file.h"

#include <fstream>
#include <iostream>

namespace kagero {

void check_output(const std::string& path) {
    if (!path.empty() && path != "-") check_file_writable(path);
}

void write_output(const std::string& path, const std::function<void(std::ostream&)>& write) {
    if (path == "-") {
        write(std::cout);
        if (!std::cout.flush()) throw RunError("cannot write all of the result to stdout");
        return;
    }
    PartialFile file(path);
    std::ofstream out(file.temporary(), std::ios::binary);
    write(out);
    out.close();
    if (!out) throw RunError("cannot write '" + path + "': is the disk full?");
    file.complete();
}

}  // namespace kagero
