# Installation and packaging. Kernel modules are in lib/kagero, in the build tree and after installation. The program
# and the library search for this folder relative to their own paths.
install(TARGETS kagero RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY ${CMAKE_LIBRARY_OUTPUT_DIRECTORY}/ DESTINATION ${CMAKE_INSTALL_LIBDIR}/kagero
        FILES_MATCHING PATTERN "kagero-*.so" PATTERN "kagero-mpi.so" EXCLUDE)
# The module for MPI is a package of its own, because the other files do not need an MPI library.
if(TARGET kagero-mpi)
  install(PROGRAMS $<TARGET_FILE:kagero-mpi> DESTINATION ${CMAKE_INSTALL_LIBDIR}/kagero COMPONENT mpi)
endif()
install(DIRECTORY ${CMAKE_SOURCE_DIR}/scenes/ DESTINATION ${CMAKE_INSTALL_DATADIR}/kagero/scenes USE_SOURCE_PERMISSIONS
        PATTERN CMakeLists.txt EXCLUDE PATTERN *.cpp EXCLUDE PATTERN *.h EXCLUDE PATTERN data EXCLUDE)
install(FILES ${CMAKE_SOURCE_DIR}/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES ${CMAKE_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME copyright)

# The Python package is where Debian's interpreter searches for packages. Its module finds the kernel modules relative
# to its own path.
if(KAGERO_PYTHON)
  install(DIRECTORY ${CMAKE_BINARY_DIR}/python/kagero DESTINATION ${KAGERO_PYTHON_DIR}
          PATTERN __pycache__ EXCLUDE)
endif()

# CMake package for other programs: find_package(kagero) provides the target kagero::kagero.
include(CMakePackageConfigHelpers)
set(package ${CMAKE_INSTALL_LIBDIR}/cmake/kagero)
install(TARGETS kagero_shared EXPORT kagero LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT kagero NAMESPACE kagero:: FILE kagero-config.cmake DESTINATION ${package})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/kagero-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/kagero-config-version.cmake DESTINATION ${package})
install(DIRECTORY ${CMAKE_SOURCE_DIR}/include/kagero DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
        FILES_MATCHING PATTERN "*.h")

# The man page and the bash completion are generated from the help texts of the program.
if(Python3_Interpreter_FOUND)
  set(manual ${CMAKE_BINARY_DIR}/manual)
  add_custom_command(OUTPUT ${manual}/kagero.1.gz ${manual}/kagero.bash
    COMMAND Python3::Interpreter ${CMAKE_SOURCE_DIR}/cmake/manual.py $<TARGET_FILE:kagero> ${manual}
    DEPENDS kagero ${CMAKE_SOURCE_DIR}/cmake/manual.py COMMENT "Writing the man page and bash completion")
  add_custom_target(manual ALL DEPENDS ${manual}/kagero.1.gz ${manual}/kagero.bash)
  install(FILES ${manual}/kagero.1.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
  install(FILES ${manual}/kagero.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME kagero)
endif()

# `cpack` in the build directory builds Debian packages for the Debian release of the machine: kagero, and kagero-mpi if
# the module for MPI is built. Their dependencies are derived from the linked libraries.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME kagero)
set(CPACK_PACKAGE_CONTACT "The kagero team <kagero@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY ${PROJECT_DESCRIPTION})
string(CONCAT CPACK_PACKAGE_DESCRIPTION
  "kagero renders scenes in which light bends, for example around black holes and through mirages. "
  "The rays follow a Hamiltonian. The package contains the program, its scenes, and the library with its headers.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_NAME kagero)
set(CPACK_DEBIAN_MPI_PACKAGE_NAME kagero-mpi)
set(CPACK_DEBIAN_MPI_PACKAGE_DEPENDS "kagero (= ${PROJECT_VERSION})")
set(CPACK_COMPONENT_UNSPECIFIED_DESCRIPTION ${CPACK_PACKAGE_DESCRIPTION})
set(CPACK_COMPONENT_MPI_DESCRIPTION
    "This package contains the module with which kagero divides its work among the processes of mpirun or srun.")
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
if(KAGERO_PYTHON)
  set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_RECOMMENDS "python3-numpy")  # The program does not need the Python module.
endif()
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${CMAKE_BINARY_DIR}/lib ${CMAKE_LIBRARY_OUTPUT_DIRECTORY})
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS OFF)
file(WRITE ${CMAKE_BINARY_DIR}/triggers "activate-noawait ldconfig\n")  # updates the cache of the dynamic linker
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA ${CMAKE_BINARY_DIR}/triggers)
set(CPACK_STRIP_FILES ON)
include(CPack)
