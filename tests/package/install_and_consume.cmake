# The consumer is built with the flags of the build, so that sanitized libraries find their runtime.
# cmake -P: install, configure the consumer, build it, run it; stops at the first failure.
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${ARGN}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${SCRATCH})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${SCRATCH}/prefix)
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${SCRATCH}/build -G Ninja -D CMAKE_CXX_COMPILER=${COMPILER}
    -D CMAKE_BUILD_TYPE=Release "-DCMAKE_CXX_FLAGS_RELEASE=${FLAGS}" -D CMAKE_PREFIX_PATH=${SCRATCH}/prefix)
run(${CMAKE_COMMAND} --build ${SCRATCH}/build)
run(${SCRATCH}/build/consumer ${FIXTURES}/lra_adapter.toml)
if(NOT output MATCHES "0\\.200176")
  message(FATAL_ERROR "the consumer answered ${output}, not the adapter's 0.200176 mm")
endif()
foreach(verb acquire analyze fit-lra)
  run(${SCRATCH}/prefix/bin/${verb} --version)
endforeach()
