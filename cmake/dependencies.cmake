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
# Without OpenEXR or libpng, OpenImageIO writes their formats, and small pictures take longer, because it is loaded.
pkg_check_modules(OpenEXR IMPORTED_TARGET OpenEXR)
pkg_check_modules(libpng IMPORTED_TARGET libpng)
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

# Boost.Beast serves the pages of `kagero view`. It consists of headers only.
find_path(BOOST_BEAST_INCLUDE_DIR boost/beast.hpp)

# MPI is needed only by its module. Without MPI, the module is not built, and --mpi is refused.
set(MPI_CXX_SKIP_MPICXX ON)
find_package(MPI QUIET COMPONENTS CXX)
if(NOT MPI_CXX_FOUND)
  message(STATUS "The MPI module is not built, because MPI was not found; its Debian package is mpi-default-dev")
endif()

# AsmJit is needed only by the module that compiles formulas. Without that module, formulas are interpreted.
if(KAGERO_COMPILER)
  find_path(ASMJIT_INCLUDE_DIR asmjit/x86.h)
  find_library(ASMJIT_LIBRARY asmjit)
  if(NOT ASMJIT_INCLUDE_DIR OR NOT ASMJIT_LIBRARY)
    message(STATUS "The compiler of formulas is not built, because AsmJit was not found; its Debian package is "
                   "libasmjit-dev")
    set(KAGERO_COMPILER OFF)
  else()
    include(CheckCXXSourceCompiles)
    set(CMAKE_REQUIRED_INCLUDES ${ASMJIT_INCLUDE_DIR})
    set(CMAKE_REQUIRED_LIBRARIES ${ASMJIT_LIBRARY})
    check_cxx_source_compiles([[
      #include <asmjit/x86.h>
      namespace x86 = asmjit::x86;
      int main() {
          asmjit::CodeHolder code;
          code.init(asmjit::Environment::host());
          x86::Assembler a(&code);
          x86::Mem number = x86::ptr(a.newLabel(), 0, 8);
          number.setBroadcast(x86::Mem::Broadcast::k1To8);
          a.k(x86::k1).emit(x86::Inst::kIdVblendmpd, x86::zmm(1), x86::zmm(2), x86::zmm(3));
          a.emit(x86::Inst::kIdVaddpd, x86::zmm(1), x86::zmm(2), number);
          a.long_().sub(x86::rsp, 64);
          return a.setOffset(0) || code.flatten() || code.relocateToBase(0) || code.copyFlattenedData(nullptr, 0);
      }]] KAGERO_ASMJIT_IS_KNOWN)
    unset(CMAKE_REQUIRED_INCLUDES)
    unset(CMAKE_REQUIRED_LIBRARIES)
    if(NOT KAGERO_ASMJIT_IS_KNOWN)
      message(STATUS "The compiler of formulas is not built, because this version of AsmJit has another interface")
      set(KAGERO_COMPILER OFF)
    endif()
  endif()
endif()

# Python runs scripts, and the Python module is built for it. The interpreter of the system is preferred, because other
# ones that PATH may contain, such as those of pyenv, have no headers of Debian's packages. -DPython3_EXECUTABLE=FILE
# selects another one.
if(NOT Python3_EXECUTABLE AND EXISTS /usr/bin/python3)
  set(Python3_EXECUTABLE /usr/bin/python3)
endif()
find_package(Python3 COMPONENTS Interpreter OPTIONAL_COMPONENTS Development.Module)
if(KAGERO_PYTHON)
  find_path(PYBIND11_INCLUDE_DIR pybind11/pybind11.h)
  if(NOT Python3_Development.Module_FOUND OR NOT PYBIND11_INCLUDE_DIR)
    message(STATUS "The Python module is not built: the headers of Python or pybind11 are missing; "
                   "`.ci/setup test` installs their packages python3-dev and pybind11-dev")
    set(KAGERO_PYTHON OFF)
  endif()
endif()
set(KAGERO_PYTHON_DIR lib/python3/dist-packages CACHE STRING
    "Folder of the Python package, relative to the prefix; two folders below it")
