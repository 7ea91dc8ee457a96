# What `cmake --install` puts where. Modules lie in lib/kagero both in the build tree and installed, and are found from the program or
# the library.
install(TARGETS kagero RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY ${CMAKE_LIBRARY_OUTPUT_DIRECTORY}/ DESTINATION ${CMAKE_INSTALL_LIBDIR}/kagero
        FILES_MATCHING PATTERN "kagero-*.so")
install(DIRECTORY ${CMAKE_SOURCE_DIR}/scenes/ DESTINATION ${CMAKE_INSTALL_DATADIR}/kagero/scenes USE_SOURCE_PERMISSIONS
        PATTERN CMakeLists.txt EXCLUDE PATTERN *.cpp EXCLUDE PATTERN *.h EXCLUDE PATTERN data EXCLUDE)
install(FILES ${CMAKE_SOURCE_DIR}/LICENSE ${CMAKE_SOURCE_DIR}/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR})

# For other programs: find_package(kagero), then kagero::kagero.
include(CMakePackageConfigHelpers)
set(package ${CMAKE_INSTALL_LIBDIR}/cmake/kagero)
install(TARGETS kagero_shared EXPORT kagero LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT kagero NAMESPACE kagero:: FILE kagero-config.cmake DESTINATION ${package})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/kagero-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/kagero-config-version.cmake DESTINATION ${package})
install(DIRECTORY ${CMAKE_SOURCE_DIR}/src/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/kagero FILES_MATCHING PATTERN "*.h"
        PATTERN cli EXCLUDE)
install(FILES ${CMAKE_SOURCE_DIR}/kernels/abi.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/kagero/kernels)
