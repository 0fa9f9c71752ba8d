# The pages as HTML and the reference of the public headers: targets `pages` and `reference`, which nothing else
# needs. What they have made is installed.
set(pages ${PROJECT_BINARY_DIR}/pages)
set(reference ${PROJECT_BINARY_DIR}/reference)
set(reference_main docs/reference/library.md)
foreach(room IN ITEMS base trial acquire dsp sim fit)
  get_target_property(headers haptometer_${room} HEADER_SET)
  foreach(header IN LISTS headers)
    cmake_path(ABSOLUTE_PATH header BASE_DIRECTORY ${PROJECT_SOURCE_DIR}/${room})
    string(APPEND reference_headers " \"${header}\"")
  endforeach()
endforeach()
configure_file(cmake/Doxyfile.in Doxyfile @ONLY)

find_program(HAPTOMETER_DOXYGEN doxygen)
find_program(HAPTOMETER_PANDOC pandoc)
mark_as_advanced(HAPTOMETER_DOXYGEN HAPTOMETER_PANDOC)
if(HAPTOMETER_DOXYGEN)
  add_custom_target(reference
    COMMAND ${CMAKE_COMMAND} -E rm -rf ${reference}
    COMMAND ${HAPTOMETER_DOXYGEN} ${PROJECT_BINARY_DIR}/Doxyfile
    COMMENT "Writing the reference of the public headers" VERBATIM)
endif()
if(HAPTOMETER_PANDOC AND Python3_FOUND)
  add_custom_target(pages
    COMMAND ${CMAKE_COMMAND} -E rm -rf ${pages}
    COMMAND ${Python3_EXECUTABLE} -B ${PROJECT_SOURCE_DIR}/packaging/pages/pages.py ${PROJECT_SOURCE_DIR} ${pages}
    COMMENT "Writing the pages as HTML" VERBATIM)
endif()
install(DIRECTORY ${pages}/ DESTINATION ${CMAKE_INSTALL_DOCDIR}/html COMPONENT documentation OPTIONAL)
install(DIRECTORY ${reference}/ DESTINATION ${CMAKE_INSTALL_DOCDIR}/reference COMPONENT documentation OPTIONAL)
