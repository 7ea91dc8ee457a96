# Dependencies, which are Debian packages, each with one target name. All differences between Debian 12 and 13 are
# handled in this file.
find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)
find_package(TBB REQUIRED)
find_package(CLI11 REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(ZLIB REQUIRED)
# pkg-config is used for OpenImageIO, because its CMake package requires tools and OpenCV headers that kagero does not
# need.
pkg_check_modules(OpenImageIO REQUIRED IMPORTED_TARGET OpenImageIO)
pkg_check_modules(tomlplusplus REQUIRED IMPORTED_TARGET tomlplusplus)

# Embree 4 or 3. Each version installs rtcore.h in a separate directory, so `#include <rtcore.h>` refers to the version
# that is found here.
find_path(EMBREE_INCLUDE_DIR rtcore.h PATH_SUFFIXES embree4 embree3 REQUIRED)
find_library(EMBREE_LIBRARY NAMES embree4 embree3 REQUIRED)
add_library(kagero_embree INTERFACE)
target_include_directories(kagero_embree SYSTEM INTERFACE ${EMBREE_INCLUDE_DIR})
target_link_libraries(kagero_embree INTERFACE ${EMBREE_LIBRARY})
# The Embree flag of scenes whose queries have a filter function as an argument.
if(EMBREE_LIBRARY MATCHES embree4)
  set(KAGERO_EMBREE_QUERY_FILTER RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS)
else()
  set(KAGERO_EMBREE_QUERY_FILTER RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION)
endif()

# xsimd consists of headers only. Debian's CMake package for it is not used, because it would link xtl.
find_path(XSIMD_INCLUDE_DIR xsimd/xsimd.hpp REQUIRED)
add_library(kagero_xsimd INTERFACE)
target_include_directories(kagero_xsimd SYSTEM INTERFACE ${XSIMD_INCLUDE_DIR})
