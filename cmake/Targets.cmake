# One function per kind of target.

# haptometer_join(TARGET)
# Where HAPTOMETER_JOIN_SOURCES is on (set by presets), the target's sources are compiled in groups, each
# of files whose names agree (dev/source_groups.py): headers, dearer than what reads them, are read
# once per group.
function(haptometer_join target)
  if(NOT HAPTOMETER_JOIN_SOURCES)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  list(FILTER sources INCLUDE REGEX "\\.cc$")
  list(TRANSFORM sources PREPEND "${CMAKE_CURRENT_SOURCE_DIR}/")
  execute_process(
    COMMAND ${Python3_EXECUTABLE} ${PROJECT_SOURCE_DIR}/dev/source_groups.py ${sources}
    WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
    OUTPUT_VARIABLE groups OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  string(REPLACE "\n" ";" groups "${groups}")
  foreach(line IN LISTS groups)
    string(REPLACE " " ";" line "${line}")
    list(GET line 0 group)
    list(GET line 1 source)
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${group})
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  # g++ takes an unnamed namespace in an included file for one in a header
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
endfunction()

# haptometer_room(NAME HEADERS ... SOURCES ... DEPENDS ... PARTS ...)
# A room: the static library haptometer_NAME, also known as haptometer::NAME. DEPENDS are lower rooms
# and parts that its headers show; PARTS are third-party libraries that only its sources use. Each header
# is compiled on its own when CMAKE_VERIFY_INTERFACE_HEADER_SETS is on.
function(haptometer_room name)
  cmake_parse_arguments(PARSE_ARGV 1 room "" "" "HEADERS;SOURCES;DEPENDS;PARTS")
  set(target haptometer_${name})
  add_library(${target} STATIC ${room_SOURCES})
  add_library(haptometer::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  target_sources(${target} PUBLIC FILE_SET HEADERS BASE_DIRS ${PROJECT_SOURCE_DIR}
                 FILES ${room_HEADERS})
  target_compile_features(${target} PUBLIC cxx_std_23)
  target_link_libraries(${target} PUBLIC ${room_DEPENDS} PRIVATE ${room_PARTS})
  haptometer_join(${target})
  install(TARGETS ${target} EXPORT haptometer
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
          FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/haptometer)
endfunction()

# haptometer_rooms_first(TARGET PART...)
# Has the linker see the rooms among the parts, and those that they show, ahead of the program's own
# objects. What both compile of a header (most of Eigen) is linked as it was seen first: a program whose
# own code is not optimised keeps fast rooms, five times as fast under the sanitizers.
function(haptometer_rooms_first target)
  set(rooms ${ARGN})
  foreach(part IN LISTS ARGN)
    if(part MATCHES "^haptometer::")
      get_target_property(shown ${part} INTERFACE_LINK_LIBRARIES)
      list(APPEND rooms ${shown})
    endif()
  endforeach()
  list(FILTER rooms INCLUDE REGEX "^haptometer::")
  list(REMOVE_ITEM rooms haptometer::tools)
  list(REMOVE_DUPLICATES rooms)
  list(TRANSFORM rooms REPLACE "(.+)" "$<TARGET_FILE:\\1>")
  list(JOIN rooms "," archives)
  target_link_options(${target} PRIVATE "LINKER:--whole-archive,${archives},--no-whole-archive")
endfunction()

# haptometer_test(NAME SOURCES ... DEPENDS ...)
# The program NAME_test with one ctest entry per GoogleTest case. Fixtures and programs are found
# through compile definitions, so a test runs from any directory. HAPTOMETER_TEST_FLAGS and
# HAPTOMETER_PRECOMPILE_TESTS (set by presets) spare compile time: a test's own code need not be fast. (At -O1
# g++ 12 sees std::string write beyond its own buffer when it moves: -Wno-array-bounds.)
function(haptometer_test name)
  cmake_parse_arguments(PARSE_ARGV 1 test "" "" "SOURCES;DEPENDS")
  set(target ${name}_test)
  add_executable(${target} ${test_SOURCES})
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR})
  target_compile_definitions(${target} PRIVATE
    HAPTOMETER_FIXTURES="${PROJECT_SOURCE_DIR}/fixtures"
    HAPTOMETER_PROGRAMS="${CMAKE_RUNTIME_OUTPUT_DIRECTORY}")
  target_link_libraries(${target} PRIVATE ${test_DEPENDS} GTest::gtest_main GTest::gmock)
  if(HAPTOMETER_TEST_FLAGS)
    target_compile_options(${target} PRIVATE ${HAPTOMETER_TEST_FLAGS})
    haptometer_rooms_first(${target} ${test_DEPENDS})
  endif()
  haptometer_join(${target})
  if(HAPTOMETER_PRECOMPILE_TESTS)
    target_precompile_headers(${target} PRIVATE <gmock/gmock.h> <gtest/gtest.h>)
    if("nlohmann_json::nlohmann_json" IN_LIST test_DEPENDS)
      target_precompile_headers(${target} PRIVATE <nlohmann/json.hpp>)
    endif()
  endif()
  gtest_discover_tests(${target} TEST_PREFIX "${name}." NO_PRETTY_VALUES
                       PROPERTIES TIMEOUT 600 DISCOVERY_TIMEOUT 60)
endfunction()

# haptometer_script_test(NAME SCRIPT ... DEPENDS ...)
# A test written in Python, run with Debian's interpreter (the one that sees SciPy). A script that
# exits with 77 says what it misses and counts as skipped.
function(haptometer_script_test name script)
  add_test(NAME ${name} COMMAND /usr/bin/python3 ${script} ${ARGN}
           WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
  set_tests_properties(${name} PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT 900
    ENVIRONMENT "HAPTOMETER_PROGRAMS=${CMAKE_RUNTIME_OUTPUT_DIRECTORY};PYTHONDONTWRITEBYTECODE=1")
endfunction()

# haptometer_bench(NAME SOURCES ... DEPENDS ...)
# The Google Benchmark program NAME_bench, and a ctest entry that runs each of its cases once, so that
# a bench cannot rot. Its times are read by hand, never asserted.
function(haptometer_bench name)
  cmake_parse_arguments(PARSE_ARGV 1 bench "" "" "SOURCES;DEPENDS")
  set(target ${name}_bench)
  add_executable(${target} ${bench_SOURCES})
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${target} PRIVATE ${bench_DEPENDS} benchmark::benchmark_main)
  add_test(NAME bench.${name} COMMAND ${target} --benchmark_min_time=0.001)
endfunction()

# haptometer_fuzz(NAME DEPENDS ...)
# The libFuzzer program NAME_fuzz from fuzz/NAME_fuzz.cc.
function(haptometer_fuzz name)
  cmake_parse_arguments(PARSE_ARGV 1 fuzz "" "" "DEPENDS")
  set(target ${name}_fuzz)
  add_executable(${target} EXCLUDE_FROM_ALL ${name}_fuzz.cc)
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${target} PRIVATE ${fuzz_DEPENDS})
  target_link_options(${target} PRIVATE -fsanitize=fuzzer)
  add_dependencies(fuzzers ${target})
endfunction()
