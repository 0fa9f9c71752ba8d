# One function per kind of target, and three that these use: haptometer_join, haptometer_shareable,
# haptometer_rooms_first.

# haptometer_join(TARGET)
# If HAPTOMETER_JOIN_SOURCES is on, compiles the target's sources in groups of files whose names agree
# (dev/source_groups.py). Headers take longer than the files that include them, and a group reads them once.
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
  # g++ takes a source that a group includes for a header, and warns of its unnamed namespaces
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
endfunction()

# haptometer_shareable(TARGET)
# The archive can become part of a shared library, as of the Python module. Its symbols stay within that library,
# so that calls among its functions are as direct as in a program.
function(haptometer_shareable target)
  set_target_properties(${target} PROPERTIES
    POSITION_INDEPENDENT_CODE ON CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
endfunction()

# haptometer_room(NAME HEADERS ... SOURCES ... DEPENDS ... PARTS ...)
# A room: the static library haptometer_NAME with the alias haptometer::NAME. DEPENDS are lower rooms, and
# third-party libraries that its headers include; PARTS are third-party libraries that only its sources use.
# Each header is compiled on its own if CMAKE_VERIFY_INTERFACE_HEADER_SETS is on. What links a room includes
# headers from the tree's root.
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
  haptometer_shareable(${target})
  if(NOT name IN_LIST HAPTOMETER_APART)
    haptometer_join(${target})
  endif()
  install(TARGETS ${target} EXPORT haptometer
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
          FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/haptometer)
endfunction()

# haptometer_rooms_first(TARGET PART...)
# Puts the rooms among the parts, and the rooms that these depend on, ahead of the program's own objects for
# the linker. Of a function that both compile from a header (most of Eigen) the linker keeps the first: a
# program whose own code is not optimised so keeps fast rooms, five times as fast under the sanitizers.
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

# haptometer_test(NAME SOURCES ... DEPENDS ... [TOGETHER ...] [LONG ...] [ALONE])
# The program NAME_test with one ctest entry per GoogleTest case, which is a process of its own; TOGETHER are
# suites with one entry each, whose cases share what takes seconds to compute. It finds fixtures and programs
# through compile definitions, so it runs from any directory, and keeps nothing in the user's cache.
# With sanitizers a process takes longer to begin and end than most cases: there the cases are run by as many
# processes as the program has sources, NAME.1 ..., by one with TOGETHER, and ALONE as without sanitizers. LONG are
# cases (patterns) that repeat for long what others do too, which take up to thirty times as long there, and are
# not run.
function(haptometer_test name)
  cmake_parse_arguments(PARSE_ARGV 1 test "ALONE" "" "SOURCES;DEPENDS;TOGETHER;LONG")
  set(target ${name}_test)
  add_executable(${target} ${test_SOURCES})
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
    target_precompile_headers(${target} REUSE_FROM precompiled_test)
  endif()
  if(HAPTOMETER_SANITIZED AND NOT test_ALONE)
    list(LENGTH test_SOURCES processes)
    if(test_TOGETHER)
      set(processes 1)
    endif()
    haptometer_shards(${name} ${processes} "${test_LONG}")
  else()
    haptometer_cases(${name} "${test_TOGETHER}")
  endif()
endfunction()

# An entry per case, and one for each suite of `together`.
function(haptometer_cases name together)
  set(alone "*")
  if(together)
    list(TRANSFORM together APPEND ".*" OUTPUT_VARIABLE suites)
    list(JOIN suites ":" suites)
    set(alone "-${suites}")
  endif()
  gtest_discover_tests(${name}_test TEST_PREFIX "${name}." NO_PRETTY_VALUES TEST_FILTER "${alone}"
                       PROPERTIES TIMEOUT 600 ENVIRONMENT HAPTOMETER_CACHE=off DISCOVERY_TIMEOUT 60)
  foreach(suite IN LISTS together)
    add_test(NAME ${name}.${suite} COMMAND ${name}_test --gtest_filter=${suite}.*)
    set_tests_properties(${name}.${suite} PROPERTIES TIMEOUT 600 ENVIRONMENT HAPTOMETER_CACHE=off)
  endforeach()
endfunction()

# Entries that share the cases among them, without those of `long`.
function(haptometer_shards name count long)
  list(JOIN long ":" long)
  foreach(number RANGE 1 ${count})
    math(EXPR index "${number} - 1")
    add_test(NAME ${name}.${number} COMMAND ${name}_test --gtest_filter=-${long})
    set_tests_properties(${name}.${number} PROPERTIES TIMEOUT 600
      ENVIRONMENT "GTEST_TOTAL_SHARDS=${count};GTEST_SHARD_INDEX=${index};HAPTOMETER_CACHE=off")
  endforeach()
endfunction()

# haptometer_script_test(NAME SCRIPT ARGUMENT...)
# A test written in Python, run from the tree's root by Debian's interpreter (which has Debian's SciPy). A
# script that ends with status 77 has printed what is missing, and counts as skipped.
function(haptometer_script_test name script)
  add_test(NAME ${name} COMMAND /usr/bin/python3 ${script} ${ARGN}
           WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
  set_tests_properties(${name} PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT 900
    ENVIRONMENT
    "HAPTOMETER_PROGRAMS=${CMAKE_RUNTIME_OUTPUT_DIRECTORY};HAPTOMETER_CACHE=off;PYTHONDONTWRITEBYTECODE=1")
endfunction()

# haptometer_unsanitized_test(NAME SCRIPT ARGUMENT...)
# A script test that the builds with sanitizers do not have: it derives numbers that tests compare with, reads the
# sources, or runs whole programs whose parts the tests written in C++ run there, ten times as fast as it.
function(haptometer_unsanitized_test name script)
  if(NOT HAPTOMETER_SANITIZED)
    haptometer_script_test(${name} ${script} ${ARGN})
  endif()
endfunction()

# haptometer_bench(NAME SOURCES ... DEPENDS ...)
# The Google Benchmark program NAME_bench, and a ctest entry that runs each of its cases once, so that it is
# known to work. No test checks its times.
function(haptometer_bench name)
  cmake_parse_arguments(PARSE_ARGV 1 bench "" "" "SOURCES;DEPENDS")
  set(target ${name}_bench)
  add_executable(${target} ${bench_SOURCES})
  target_link_libraries(${target} PRIVATE ${bench_DEPENDS} benchmark::benchmark_main)
  add_test(NAME bench.${name} COMMAND ${target} --benchmark_min_time=0.001)
endfunction()

# haptometer_fuzz(NAME DEPENDS ...)
# The libFuzzer program NAME_fuzz from fuzz/NAME_fuzz.cc.
function(haptometer_fuzz name)
  cmake_parse_arguments(PARSE_ARGV 1 fuzz "" "" "DEPENDS")
  set(target ${name}_fuzz)
  add_executable(${target} EXCLUDE_FROM_ALL ${name}_fuzz.cc)
  target_link_libraries(${target} PRIVATE ${fuzz_DEPENDS})
  target_link_options(${target} PRIVATE -fsanitize=fuzzer)
  add_dependencies(fuzzers ${target})
endfunction()
