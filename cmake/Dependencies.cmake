# All third-party libraries, each with the name of its Debian package (tools/install-packages installs
# them). cmake/haptometerConfig.cmake.in repeats those that the installed libraries need.
find_package(Threads REQUIRED)
find_package(PkgConfig REQUIRED)
find_package(fmt REQUIRED)                 # libfmt-dev
find_package(ZLIB REQUIRED)                # zlib1g-dev: crc32
find_package(nlohmann_json REQUIRED)       # nlohmann-json3-dev
find_package(Eigen3 REQUIRED NO_MODULE)    # libeigen3-dev
find_package(Boost 1.74 REQUIRED)          # libboost-dev: headers only
find_package(Ceres REQUIRED)               # libceres-dev
pkg_check_modules(tomlplusplus REQUIRED IMPORTED_TARGET tomlplusplus)    # libtomlplusplus-dev
pkg_check_modules(fftw3 REQUIRED IMPORTED_TARGET fftw3)                  # libfftw3-dev
pkg_check_modules(libserialport REQUIRED IMPORTED_TARGET libserialport)  # libserialport-dev
pkg_check_modules(libmodbus REQUIRED IMPORTED_TARGET libmodbus)          # libmodbus-dev
pkg_check_modules(hdf5 REQUIRED IMPORTED_TARGET hdf5-serial)             # libhdf5-dev
pkg_check_modules(matio REQUIRED IMPORTED_TARGET matio)                  # libmatio-dev
pkg_check_modules(libcrypto REQUIRED IMPORTED_TARGET libcrypto)          # libssl-dev: SHA-256
pkg_check_modules(libsystemd REQUIRED IMPORTED_TARGET libsystemd)        # libsystemd-dev
find_package(CLI11 REQUIRED)               # libcli11-dev

# HDF5, matio and libcrypto are linked from their archives where these exist, as in Debian's packages. The
# shared HDF5 also reads Amazon's S3 and so loads libcurl with 30 libraries at every start of the program,
# which takes 7 ms; the shared libcrypto takes 3 ms of every start, the archive 0.3 ms.
find_library(hdf5_archive libhdf5.a HINTS ${hdf5_LIBRARY_DIRS})
find_library(matio_archive libmatio.a HINTS ${matio_LIBRARY_DIRS})
find_library(crypto_archive libcrypto.a HINTS ${libcrypto_LIBRARY_DIRS})
find_library(szip_library sz)              # libaec-dev, which libhdf5-dev brings
if(hdf5_archive AND matio_archive AND szip_library)
  add_library(hdf5_archive STATIC IMPORTED)
  set_target_properties(hdf5_archive PROPERTIES IMPORTED_LOCATION ${hdf5_archive}
    INTERFACE_LINK_LIBRARIES "${szip_library};ZLIB::ZLIB;${CMAKE_DL_LIBS};m")
  add_library(matio_archive STATIC IMPORTED)
  set_target_properties(matio_archive PROPERTIES IMPORTED_LOCATION ${matio_archive}
    INTERFACE_LINK_LIBRARIES "hdf5_archive;ZLIB::ZLIB")
  set_target_properties(PkgConfig::hdf5 PROPERTIES INTERFACE_LINK_LIBRARIES hdf5_archive)
  set_target_properties(PkgConfig::matio PROPERTIES INTERFACE_LINK_LIBRARIES matio_archive)
endif()
if(crypto_archive)
  set_target_properties(PkgConfig::libcrypto PROPERTIES INTERFACE_LINK_LIBRARIES
    "${crypto_archive};${CMAKE_DL_LIBS};Threads::Threads")
endif()
mark_as_advanced(hdf5_archive matio_archive szip_library crypto_archive)

# libsundials-dev: its CMake package needs OpenMP, which clang lacks. CVODES, not CVODE: it has the same
# functions under the same names, and integrals too; a program can link only one of the two.
foreach(part cvodes nvecserial sunlinsoldense sunmatrixdense generic)
  find_library(SUNDIALS_${part} NAMES sundials_${part} REQUIRED)
  # by name, so that the installed package does not contain the paths of the machine that built it
  list(APPEND SUNDIALS_LIBRARIES sundials_${part})
endforeach()

if(BUILD_TESTING)
  find_package(GTest REQUIRED)             # libgtest-dev libgmock-dev
  find_package(rapidcheck REQUIRED)        # librapidcheck-dev
  find_package(benchmark REQUIRED)         # libbenchmark-dev
endif()
if(HAPTOMETER_JOIN_SOURCES)
  find_package(Python3 REQUIRED COMPONENTS Interpreter)                  # python3
endif()
