/// The tables of objects, and the paints of objects and skies.
#pragma once

#include "scene/reader.h"

namespace kagero {

/// How `checker` is written: how many squares along u and v, or just `true`.
enum class CheckerKey { counts, flag };
/// The keys color, texture and checker; `fallback` where none of them is there.
Paint load_paint(const Section& section, const Paint& fallback, CheckerKey checker, const std::string& directory);

/// All [[object]] tables of a document.
std::vector<ObjectDescription> load_objects(const Value& root, const std::string& directory);

}  // namespace kagero
