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

# haptometer_install_filled(TEMPLATE DESTINATION)
# Installs TEMPLATE.in with the folders of the prefix that is chosen at that time in place of @BINDIR@, @LIBDIR@ and
# @INCLUDEDIR@.
function(haptometer_install_filled template destination)
  cmake_path(GET template FILENAME name)
  set(filled ${PROJECT_BINARY_DIR}/packaging/${name})
  install(CODE "
    get_filename_component(BINDIR \"${CMAKE_INSTALL_BINDIR}\" ABSOLUTE BASE_DIR \"\${CMAKE_INSTALL_PREFIX}\")
    get_filename_component(LIBDIR \"${CMAKE_INSTALL_LIBDIR}\" ABSOLUTE BASE_DIR \"\${CMAKE_INSTALL_PREFIX}\")
    get_filename_component(INCLUDEDIR \"${CMAKE_INSTALL_INCLUDEDIR}\" ABSOLUTE BASE_DIR \"\${CMAKE_INSTALL_PREFIX}\")
    set(PROJECT_VERSION \"${PROJECT_VERSION}\")
    set(PROJECT_DESCRIPTION \"${PROJECT_DESCRIPTION}\")
    configure_file(\"${PROJECT_SOURCE_DIR}/${template}.in\" \"${filled}\" @ONLY)")
  install(FILES ${filled} DESTINATION ${destination})
endfunction()

haptometer_install_filled(packaging/haptometer.pc ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
# The daemon's unit and its user, and the rules for USB adapters. systemd and udev look in these
# places below /usr and below /usr/local.
haptometer_install_filled(packaging/systemd/haptometer-acquire@.service lib/systemd/system)
install(FILES packaging/systemd/haptometer.conf DESTINATION lib/sysusers.d)
install(FILES packaging/udev/60-haptometer.rules DESTINATION lib/udev/rules.d)
