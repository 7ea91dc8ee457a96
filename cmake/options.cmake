# What every target is compiled with.
add_library(kagero_options INTERFACE)
target_compile_features(kagero_options INTERFACE cxx_std_20)
target_compile_options(kagero_options INTERFACE
  -Wall -Wextra -Wshadow
  # Masks of the scalar strategy are plain bool, combined with the same & and | as those of packets.
  $<$<CXX_COMPILER_ID:Clang>:-Wno-bitwise-instead-of-logical>
  # g++ 13 and newer take every reference that a function with a temporary argument returns for a part of it.
  $<$<AND:$<CXX_COMPILER_ID:GNU>,$<VERSION_GREATER_EQUAL:$<CXX_COMPILER_VERSION>,13>>:-Wno-dangling-reference>
  # Rounding is the same in scalar and packet code: products and sums fuse only where the source says mul_add.
  -ffp-contract=off
  # Not -fno-signed-zeros: with it g++ 12 breaks the signs of xsimd 8.1's sin and cos on AVX2.
  -fno-math-errno -fno-trapping-math
  # g++ need not look for memory to free before it has taken 400 MB: builds are quicker.
  $<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-heapsize=400000>)
target_include_directories(kagero_options INTERFACE ${CMAKE_SOURCE_DIR} ${CMAKE_SOURCE_DIR}/src ${CMAKE_SOURCE_DIR}/include)
# Whether a part, the program or the kernels of an instruction set, checks invariants (KAGERO_ASSERT).
function(check_invariants target part)
  if(part IN_LIST KAGERO_ASSERTIONS OR KAGERO_ASSERTIONS STREQUAL "ON")
    target_compile_definitions(${target} ${ARGN} KAGERO_ASSERTIONS)
  endif()
endfunction()
if(KAGERO_SANITIZE)
  target_compile_options(kagero_options INTERFACE -fsanitize=${KAGERO_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all
    # With these g++ 12 doubts, in constant expressions, that a variable has an address; the address sanitizer stops at null, too.
    $<$<CXX_COMPILER_ID:GNU>:-fno-sanitize=null,nonnull-attribute,returns-nonnull-attribute>)
  target_link_options(kagero_options INTERFACE -fsanitize=${KAGERO_SANITIZE})
endif()
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
