# `cmake --install`: headers, the library, and a package that gives the target isochor::core.
include(CMakePackageConfigHelpers)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/isochor)

install(TARGETS isochor_core EXPORT isochor-targets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/core DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/isochor
  FILES_MATCHING PATTERN "*.h")
install(EXPORT isochor-targets NAMESPACE isochor:: DESTINATION ${package_folder})
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/isochor-config.cmake.in
  ${PROJECT_BINARY_DIR}/isochor-config.cmake INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/isochor-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/isochor-config.cmake ${PROJECT_BINARY_DIR}/isochor-config-version.cmake
  DESTINATION ${package_folder})
