/// What the shared library offers to other programs.
#pragma once

#define KAGERO_PUBLIC __attribute__((visibility("default")))
