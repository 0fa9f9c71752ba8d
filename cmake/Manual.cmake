# Manual pages and completions, written from the options that the program declares. They need the program and Python: a
# cross build has none of them, and a build with sanitizers is not installed.
find_package(Python3 COMPONENTS Interpreter)
if(CMAKE_CROSSCOMPILING OR HAPTOMETER_SANITIZED OR NOT Python3_FOUND)
  message(STATUS "No manual pages and completions: they are written by the program that is built, with Python")
  return()
endif()

set(manual ${PROJECT_BINARY_DIR}/manual)
set(completions ${PROJECT_BINARY_DIR}/completions)
set(man_pages ${PROJECT_SOURCE_DIR}/packaging/man_pages.py)
set(statuses ${PROJECT_SOURCE_DIR}/docs/reference/common.md)
set(completion ${PROJECT_SOURCE_DIR}/packaging/completion.py)
set(templates ${PROJECT_SOURCE_DIR}/packaging/completion.bash.in ${PROJECT_SOURCE_DIR}/packaging/completion.zsh.in)
add_custom_command(
  OUTPUT ${manual}/haptometer.1 ${completions}/haptometer ${completions}/_haptometer
  COMMAND ${CMAKE_COMMAND} -E rm -rf ${manual} ${completions}
  COMMAND ${Python3_EXECUTABLE} -B ${man_pages} $<TARGET_FILE:haptometer> ${manual} ${HAPTOMETER_OWN_NAMES}
  COMMAND ${Python3_EXECUTABLE} -B ${completion} $<TARGET_FILE:haptometer> ${completions} ${HAPTOMETER_OWN_NAMES}
  DEPENDS haptometer ${man_pages} ${statuses} ${completion} ${templates}
  COMMENT "Writing manual pages and completions" VERBATIM)
add_custom_target(haptometer_manual ALL
  DEPENDS ${manual}/haptometer.1 ${completions}/haptometer ${completions}/_haptometer)

# a build of some targets alone has no pages to install
install(DIRECTORY ${manual}/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 OPTIONAL)
# bash looks for a file of the name of the command
set(of_bash ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
install(FILES ${completions}/haptometer DESTINATION ${of_bash} OPTIONAL)
foreach(name IN LISTS HAPTOMETER_OWN_NAMES)
  install(FILES ${completions}/haptometer DESTINATION ${of_bash} RENAME ${name} OPTIONAL)
endforeach()
install(FILES ${completions}/_haptometer DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions OPTIONAL)
