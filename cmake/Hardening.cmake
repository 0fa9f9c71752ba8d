# Flags that make a defect in a program harder to exploit: a stack protector, checked buffers, a random load
# address, tables of functions that are read-only once the program runs. They apply to every configuration,
# with presets or without, except under sanitizers, which check more and clash with _FORTIFY_SOURCE.
# tests/system/hardening_test.py checks the programs.
include(CheckCXXCompilerFlag)

if(HAPTOMETER_SANITIZED)
  return()
endif()

foreach(flag -fstack-protector-strong -fstack-clash-protection -fcf-protection)
  string(MAKE_C_IDENTIFIER "HAPTOMETER_HAS${flag}" known)
  check_cxx_compiler_flag(${flag} ${known})
  if(${known})
    add_compile_options(${flag})
  endif()
endforeach()

# _FORTIFY_SOURCE needs optimised code; -U because a distribution may have set another level
add_compile_options(
  "$<$<CONFIG:Release,RelWithDebInfo,MinSizeRel>:-U_FORTIFY_SOURCE;-D_FORTIFY_SOURCE=2>")

# a target that becomes part of a shared library has -fPIC instead
add_compile_options("$<$<NOT:$<BOOL:$<TARGET_PROPERTY:POSITION_INDEPENDENT_CODE>>>:-fPIE>")
add_link_options("$<$<STREQUAL:$<TARGET_PROPERTY:TYPE>,EXECUTABLE>:-pie>"
                 LINKER:-z,relro LINKER:-z,now)
