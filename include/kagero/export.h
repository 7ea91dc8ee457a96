/// Marks the functions and classes that the shared library exports.
#pragma once

#define KAGERO_PUBLIC __attribute__((visibility("default")))
