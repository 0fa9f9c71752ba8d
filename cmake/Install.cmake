# install() and the exported package: find_package(haptometer) gives haptometer::base, ::trial,
# ::acquire, ::dsp, ::sim and ::fit.
include(CMakePackageConfigHelpers)
configure_package_config_file(
  cmake/haptometerConfig.cmake.in ${PROJECT_BINARY_DIR}/haptometerConfig.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/haptometer)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/haptometerConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(EXPORT haptometer NAMESPACE haptometer::
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/haptometer FILE haptometerTargets.cmake)
install(FILES ${PROJECT_BINARY_DIR}/haptometerConfig.cmake
              ${PROJECT_BINARY_DIR}/haptometerConfigVersion.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/haptometer)

# The daemon's unit and its user, and the rules for USB adapters. systemd and udev look in these
# places below /usr and below /usr/local.
configure_file(packaging/systemd/haptometer-acquire@.service.in
               ${PROJECT_BINARY_DIR}/packaging/haptometer-acquire@.service @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/packaging/haptometer-acquire@.service
        DESTINATION lib/systemd/system)
install(FILES packaging/systemd/haptometer.conf DESTINATION lib/sysusers.d)
install(FILES packaging/udev/60-haptometer.rules DESTINATION lib/udev/rules.d)
