# Debian packages, each under one target name. Differences between Debian 12 and 13 end here.
find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)
find_package(TBB REQUIRED)
find_package(CLI11 REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(ZLIB REQUIRED)
find_package(assimp REQUIRED)
# OpenImageIO's own CMake package asks for tools and OpenCV headers that nobody here needs.
pkg_check_modules(OpenImageIO REQUIRED IMPORTED_TARGET OpenImageIO)
pkg_check_modules(tomlplusplus REQUIRED IMPORTED_TARGET tomlplusplus)

# Embree 4, or 3. Both put rtcore.h in a directory of their own, so that `#include <rtcore.h>` means the one found here.
find_path(EMBREE_INCLUDE_DIR rtcore.h PATH_SUFFIXES embree4 embree3 REQUIRED)
find_library(EMBREE_LIBRARY NAMES embree4 embree3 REQUIRED)
add_library(kagero_embree INTERFACE)
target_include_directories(kagero_embree SYSTEM INTERFACE ${EMBREE_INCLUDE_DIR})
target_link_libraries(kagero_embree INTERFACE ${EMBREE_LIBRARY})
# The flag of scenes whose queries bring a filter along.
if(EMBREE_LIBRARY MATCHES embree4)
  set(KAGERO_EMBREE_QUERY_FILTER RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS)
else()
  set(KAGERO_EMBREE_QUERY_FILTER RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION)
endif()

# xsimd is headers alone; Debian's CMake package wants to link xtl, which nothing here uses.
find_path(XSIMD_INCLUDE_DIR xsimd/xsimd.hpp REQUIRED)
add_library(kagero_xsimd INTERFACE)
target_include_directories(kagero_xsimd SYSTEM INTERFACE ${XSIMD_INCLUDE_DIR})
