# Cross compilation for AArch64 by Debian's g++-aarch64-linux-gnu (preset arm64). HAPTOMETER_SYSROOT is a folder with the
# arm64 packages, which `tests/long/arm64.py --sysroot` makes; tests are run by qemu's user emulation.
set(HAPTOMETER_SYSROOT ${CMAKE_CURRENT_LIST_DIR}/../build/arm64-sysroot CACHE PATH "Folder with the arm64 packages")
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES HAPTOMETER_SYSROOT)

set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_SYSROOT ${HAPTOMETER_SYSROOT})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
foreach(kind LIBRARY INCLUDE PACKAGE)
  set(CMAKE_FIND_ROOT_PATH_MODE_${kind} ONLY)
endforeach()
set(ENV{PKG_CONFIG_SYSROOT_DIR} ${HAPTOMETER_SYSROOT})
set(ENV{PKG_CONFIG_LIBDIR}
    ${HAPTOMETER_SYSROOT}/usr/lib/aarch64-linux-gnu/pkgconfig:${HAPTOMETER_SYSROOT}/usr/share/pkgconfig)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64-static -L ${HAPTOMETER_SYSROOT})
