# penumbra_discover_suites(PROGRAM [PROPERTY VALUE]…): a ctest entry with these properties for every suite of a
# GoogleTest program, found when the program has been built. Not one for every test: a program takes 0.4 s to start,
# which is more than most tests do.
if(NOT CMAKE_SCRIPT_MODE_FILE)
  set(suites_script ${CMAKE_CURRENT_LIST_FILE})
  function(penumbra_discover_suites program)
    set(list ${CMAKE_CURRENT_BINARY_DIR}/${program}_suites.cmake)
    add_custom_command(TARGET ${program} POST_BUILD
      COMMAND ${CMAKE_COMMAND} -Dprogram=$<TARGET_FILE:${program}> -Dlist=${list} "-Dproperties=${ARGN}"
              -P ${suites_script}
      VERBATIM)
    set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${list})
  endfunction()
  return()
endif()

execute_process(COMMAND ${program} --gtest_list_tests OUTPUT_VARIABLE lines COMMAND_ERROR_IS_FATAL ANY)
# Tests are indented below their suite, whose line is `Name.` and what its parameter is.
string(REGEX MATCHALL "\n[A-Za-z0-9_/]+\\." suites "\n${lines}")
string(REPLACE ";" " " properties "${properties}")
set(text "")
foreach(suite ${suites})
  string(REGEX REPLACE "\n(.*)\\." "\\1" name "${suite}")
  string(APPEND text "add_test([=[${name}]=] [=[${program}]=] --gtest_brief=1 [=[--gtest_filter=${name}.*]=])\n"
                     "set_tests_properties([=[${name}]=] PROPERTIES ${properties})\n")
endforeach()
file(WRITE ${list} "${text}")
