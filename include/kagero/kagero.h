/// All public headers. The names are those of the Python module: load, override, render and trace.
#pragma once

#include <kagero/error.h>
#include <kagero/options.h>
#include <kagero/picture.h>
#include <kagero/rays.h>
#include <kagero/scene.h>
