/// Translation of the exceptions of kagero to those of the Python module.
#pragma once

namespace kagero {

/// Registers the translation: InputError and RunError become the Python exceptions of the same names, and Interrupted
/// becomes KeyboardInterrupt.
void translate_exceptions();

}  // namespace kagero
