# All third-party libraries, each with the name of its Debian package (tools/install-packages installs
# them). cmake/haptometerConfig.cmake.in repeats those that the installed libraries need.
# Debian's Python, whatever other stands ahead of it on the PATH: the module is for it, and it has Debian's packages
if(NOT DEFINED Python3_EXECUTABLE AND EXISTS /usr/bin/python3)
  set(Python3_EXECUTABLE /usr/bin/python3)
endif()
find_package(Threads REQUIRED)
find_package(PkgConfig REQUIRED)
find_package(fmt REQUIRED)                 # libfmt-dev
find_package(nlohmann_json REQUIRED)       # nlohmann-json3-dev
find_package(Eigen3 REQUIRED NO_MODULE)    # libeigen3-dev
find_package(Boost 1.74 REQUIRED)          # libboost-dev: headers only
find_package(Ceres REQUIRED)               # libceres-dev
pkg_check_modules(zlib REQUIRED IMPORTED_TARGET zlib)                    # zlib1g-dev: crc32
pkg_check_modules(tomlplusplus REQUIRED IMPORTED_TARGET tomlplusplus)    # libtomlplusplus-dev
pkg_check_modules(fftw3 REQUIRED IMPORTED_TARGET fftw3)                  # libfftw3-dev
pkg_check_modules(libserialport REQUIRED IMPORTED_TARGET libserialport)  # libserialport-dev
pkg_check_modules(libmodbus REQUIRED IMPORTED_TARGET libmodbus)          # libmodbus-dev
pkg_check_modules(hdf5 REQUIRED IMPORTED_TARGET hdf5-serial)             # libhdf5-dev
pkg_check_modules(matio REQUIRED IMPORTED_TARGET matio)                  # libmatio-dev
pkg_check_modules(libcrypto REQUIRED IMPORTED_TARGET libcrypto)          # libssl-dev: SHA-256
find_package(CLI11 REQUIRED)               # libcli11-dev

# Programs link archives where they exist, as in Debian's packages, in place of shared libraries: each of these
# takes 0.3 ms of every start of the program, also where the command calls nothing of it. HDF5 would also load
# libcurl with 30 libraries (it reads Amazon's S3), Ceres 20 for sparse problems, which fit/ does not have.
# Shared libraries and modules, as of Python, cannot hold Debian's archives and link the shared libraries.

# haptometer_archives(TARGET ARCHIVE... [ALSO LIBRARY...])
# What links the imported target is given, where it is a program, these archives, each found by its name, and then
# LIBRARY...; elsewhere, and where an archive is missing, what the target links itself.
function(haptometer_archives target)
  cmake_parse_arguments(PARSE_ARGV 1 target "" "" "ALSO")
  foreach(name IN LISTS target_UNPARSED_ARGUMENTS)
    set(archive "")
    find_library(${name}_archive lib${name}.a PATH_SUFFIXES hdf5/serial)
    if(${name}_archive)
      set(archive ${${name}_archive})
    else()
      # the compiler's own: of Fortran and of OpenMP
      execute_process(COMMAND ${CMAKE_CXX_COMPILER} -print-file-name=lib${name}.a
                      OUTPUT_VARIABLE archive OUTPUT_STRIP_TRAILING_WHITESPACE)
    endif()
    if(NOT EXISTS "${archive}")
      message(STATUS "${target}: no lib${name}.a, so the shared library")
      return()
    endif()
    list(APPEND archives ${archive})
    mark_as_advanced(${name}_archive)
  endforeach()
  set(is_program "$<STREQUAL:$<TARGET_PROPERTY:TYPE>,EXECUTABLE>")
  get_target_property(shared ${target} INTERFACE_LINK_LIBRARIES)
  list(TRANSFORM shared REPLACE "(.+)" "$<$<NOT:${is_program}>:\\1>")
  list(APPEND archives ${target_ALSO})
  list(TRANSFORM archives REPLACE "(.+)" "$<${is_program}:\\1>")
  set_target_properties(${target} PROPERTIES INTERFACE_LINK_LIBRARIES "${archives};${shared}")
endfunction()

option(HAPTOMETER_SHARED_ZLIB "Link the shared zlib, as Debian asks of its packages" OFF)
if(HAPTOMETER_SHARED_ZLIB)
  set(shared_zlib z)
else()
  set(zlib_archive z)
  haptometer_archives(PkgConfig::zlib z)
endif()
haptometer_archives(PkgConfig::fftw3 fftw3 ALSO m)
haptometer_archives(PkgConfig::libserialport serialport)
haptometer_archives(PkgConfig::hdf5 hdf5 sz aec ${zlib_archive} ALSO ${shared_zlib} ${CMAKE_DL_LIBS} m)
haptometer_archives(PkgConfig::matio matio hdf5 sz aec ${zlib_archive} ALSO ${shared_zlib} ${CMAKE_DL_LIBS} m)
haptometer_archives(PkgConfig::libcrypto crypto ALSO ${CMAKE_DL_LIBS} Threads::Threads)
# Ceres' own target is an archive, which a module cannot hold; METIS and libunwind, which CHOLMOD and glog call, have
# no archives
find_library(ceres_library NAMES libceres.so ceres)
find_library(metis_library NAMES libmetis.so.5 metis)
find_library(unwind_library NAMES unwind)
mark_as_advanced(ceres_library metis_library unwind_library)
add_library(Ceres::linked INTERFACE IMPORTED)
get_target_property(ceres_include Ceres::ceres INTERFACE_INCLUDE_DIRECTORIES)
set_target_properties(Ceres::linked PROPERTIES
  INTERFACE_INCLUDE_DIRECTORIES "${ceres_include}"
  INTERFACE_LINK_LIBRARIES "${ceres_library};glog::glog;Eigen3::Eigen")
if(metis_library AND unwind_library)
  haptometer_archives(Ceres::linked ceres glog gflags spqr cholmod amd camd ccolamd colamd suitesparseconfig cxsparse
    lapack f77blas cblas atlas gfortran quadmath gomp
    ALSO ${metis_library} ${unwind_library} Eigen3::Eigen Threads::Threads ${CMAKE_DL_LIBS} m)
endif()

if(BUILD_TESTING)
  find_package(GTest REQUIRED)             # libgtest-dev libgmock-dev
  find_package(rapidcheck REQUIRED)        # librapidcheck-dev
  find_package(benchmark REQUIRED)         # libbenchmark-dev
  # libsundials-dev, a peer in bench/: its CMake package needs OpenMP, which clang lacks. CVODES, not CVODE: it
  # has the same functions under the same names; a program can link only one of the two.
  foreach(part cvodes nvecserial sunlinsoldense sunmatrixdense generic)
    find_library(SUNDIALS_${part} NAMES sundials_${part} REQUIRED)
    list(APPEND SUNDIALS_LIBRARIES sundials_${part})
  endforeach()
endif()
if(HAPTOMETER_JOIN_SOURCES)
  find_package(Python3 REQUIRED COMPONENTS Interpreter)                  # python3
endif()
