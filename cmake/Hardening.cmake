# What makes a defect in a program harder to use: a stack protector and checked buffers in the code, the
# program at an address that is not known, its tables of functions read-only once it runs. For every
# configuration and whoever configures, with presets or without; not under sanitizers, which check more
# and clash with _FORTIFY_SOURCE. tests/system/hardening_test.py reads the programs.
include(CheckCXXCompilerFlag)

string(TOUPPER "${CMAKE_BUILD_TYPE}" configuration)
if("${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_${configuration}}" MATCHES "-fsanitize=")
  return()
endif()

foreach(flag -fstack-protector-strong -fstack-clash-protection -fcf-protection)
  string(MAKE_C_IDENTIFIER "HAPTOMETER_HAS${flag}" known)
  check_cxx_compiler_flag(${flag} ${known})
  if(${known})
    add_compile_options(${flag})
  endif()
endforeach()

# it needs optimised code; a distribution may have set another level
add_compile_options(
  "$<$<CONFIG:Release,RelWithDebInfo,MinSizeRel>:-U_FORTIFY_SOURCE;-D_FORTIFY_SOURCE=2>")

# a target that becomes part of a shared library asks for more by itself
add_compile_options("$<$<NOT:$<BOOL:$<TARGET_PROPERTY:POSITION_INDEPENDENT_CODE>>>:-fPIE>")
add_link_options("$<$<STREQUAL:$<TARGET_PROPERTY:TYPE>,EXECUTABLE>:-pie>"
                 LINKER:-z,relro LINKER:-z,now)
