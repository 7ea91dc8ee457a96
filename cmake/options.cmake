# Compiler options of all targets.
add_library(kagero_options INTERFACE)
target_compile_features(kagero_options INTERFACE cxx_std_20)
target_compile_options(kagero_options INTERFACE
  -Wall -Wextra -Wshadow
  # Masks of the scalar strategy are bool, and are combined with the operators & and | like the masks of packets.
  $<$<CXX_COMPILER_ID:Clang>:-Wno-bitwise-instead-of-logical>
  # g++ 13 and newer warn of every reference that is returned by a function with a temporary argument.
  $<$<AND:$<CXX_COMPILER_ID:GNU>,$<VERSION_GREATER_EQUAL:$<CXX_COMPILER_VERSION>,13>>:-Wno-dangling-reference>
  # Scalar and packet code round identically: products and sums are fused only where the source calls fma.
  -ffp-contract=off
  # -fno-signed-zeros is not set, because with it g++ 12 breaks the signs of sin and cos of xsimd 8.1 on AVX2.
  -fno-math-errno -fno-trapping-math
  # g++ collects garbage only after it has allocated 400 MB, which makes builds faster.
  $<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-heapsize=400000>)
target_include_directories(kagero_options INTERFACE
  ${CMAKE_SOURCE_DIR} ${CMAKE_SOURCE_DIR}/src ${CMAKE_SOURCE_DIR}/include)
# Makes a target check invariants (KAGERO_ASSERT) if KAGERO_ASSERTIONS selects `part`: "program" or an instruction set.
function(check_invariants target part)
  if(part IN_LIST KAGERO_ASSERTIONS OR KAGERO_ASSERTIONS STREQUAL "ON")
    target_compile_definitions(${target} ${ARGN} KAGERO_ASSERTIONS)
  endif()
endfunction()
if(KAGERO_SANITIZE)
  target_compile_options(kagero_options INTERFACE
    -fsanitize=${KAGERO_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all
    # With these sanitizers g++ 12 rejects addresses of variables in constant expressions. The address sanitizer detects
    # null pointers as well.
    $<$<CXX_COMPILER_ID:GNU>:-fno-sanitize=null,nonnull-attribute,returns-nonnull-attribute>)
  target_link_options(kagero_options INTERFACE -fsanitize=${KAGERO_SANITIZE})
endif()
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
