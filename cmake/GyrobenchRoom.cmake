# gyrobench_room(<name> SOURCES ... [DEPENDS room...] [LINK target...] [SHOWS target...])
# gyrobench_program(<name> ROOM <room> SOURCES ... [DEPENDS room...] [LINK target...])
# gyrobench_test(<name> SOURCES ... DEPENDS room... [LINK target...])
# gyrobench_benchmark(<name> SOURCES ... DEPENDS room... [LINK target...])
# gyrobench_rooms_as_one(<name> room...)
#
# A room is one static library, gyrobench::<name>, in the folder of that name; one in another's folder is
# <outer>/<inner>, its library gyrobench::<outer>_<inner>. DEPENDS are rooms that it uses, LINK other libraries. SHOWS
# are those of them that its headers include: who uses the room sees them as well, and nothing else.
#
# Which room may use which is the one table below; configuring fails where DEPENDS breaks it. Every room has an include
# directory of its own, in which its folder is all there is, so that the header of a room that is not linked is not
# found. The test `layers` reads the #include lines against the same table (cmake/layers.txt), and compares it with the
# documents.

file(STRINGS ${PROJECT_SOURCE_DIR}/cmake/layers.txt gyrobench_layer_lines REGEX "^[a-z]")
foreach(line IN LISTS gyrobench_layer_lines)
  string(REGEX MATCH "^([a-z_/]+):(.*)$" _ "${line}")
  string(STRIP "${CMAKE_MATCH_2}" allowed)
  string(REPLACE " " ";" GYROBENCH_LAYER_${CMAKE_MATCH_1} "${allowed}")
  set(GYROBENCH_HAS_LAYER_${CMAKE_MATCH_1} TRUE)
endforeach()

add_library(gyrobench_flags INTERFACE)
target_compile_options(gyrobench_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Wnon-virtual-dtor
  -Wold-style-cast -Woverloaded-virtual -Wdouble-promotion -Wformat=2)
if(GYROBENCH_WARNINGS_AS_ERRORS)
  target_compile_options(gyrobench_flags INTERFACE -Werror)
endif()
# How much longer tests may take: a sanitizer slows what they run.
set(GYROBENCH_TEST_SLOWNESS 1)
if(GYROBENCH_UNITY)
  # It warns of anonymous types in the fields of a class that an included file has; here every source is included.
  target_compile_options(gyrobench_flags INTERFACE -Wno-subobject-linkage)
endif()
if(GYROBENCH_SANITIZE)
  set(GYROBENCH_TEST_SLOWNESS 10)
  target_link_options(gyrobench_flags INTERFACE -fsanitize=${GYROBENCH_SANITIZE})
  # Apart from the flags, as some rooms can do without (GYROBENCH_SANITIZE_NOT).
  add_library(gyrobench_sanitizers INTERFACE)
  target_compile_options(gyrobench_sanitizers INTERFACE
    -fsanitize=${GYROBENCH_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  # gcc 12 reports false "may be uninitialized" findings once the sanitizers instrument a file.
  target_compile_options(gyrobench_sanitizers INTERFACE -Wno-maybe-uninitialized)
  # Where a function is called by a pointer to a member, as LCM calls its handlers, gcc 12 checks the type of another
  # object than the one that is called.
  # Checks at every use of a pointer double the time of compiling. The address sanitizer ends at a null pointer and
  # outside of an object as well, and the processors that the bench runs on read at any address.
  if(GYROBENCH_SANITIZE MATCHES "undefined")
    target_compile_options(gyrobench_sanitizers INTERFACE
      -fno-sanitize=vptr,null,alignment,object-size,pointer-overflow)
  endif()
  # Boost.Asio has fences, which the thread sanitizer does not follow.
  if(GYROBENCH_SANITIZE MATCHES "thread")
    target_compile_options(gyrobench_sanitizers INTERFACE -Wno-tsan)
  endif()
endif()

math(EXPR GYROBENCH_TEST_TIMEOUT_S "300 * ${GYROBENCH_TEST_SLOWNESS}")

foreach(room IN LISTS GYROBENCH_SANITIZE_NOT)
  if(NOT GYROBENCH_HAS_LAYER_${room})
    message(FATAL_ERROR "GYROBENCH_SANITIZE_NOT: there is no room '${room}' (cmake/layers.txt)")
  endif()
endforeach()

function(gyrobench_check_layers room)
  if(NOT GYROBENCH_HAS_LAYER_${room})
    message(FATAL_ERROR "room '${room}' has no line in cmake/layers.txt: add one that says which rooms it may use")
  endif()
  foreach(used IN LISTS ARGN)
    if(NOT used IN_LIST GYROBENCH_LAYER_${room})
      message(FATAL_ERROR "room '${room}' may not use room '${used}' (cmake/layers.txt allows: ${GYROBENCH_LAYER_${room}})")
    endif()
  endforeach()
endfunction()

# The libraries of rooms, in place of their names.
function(gyrobench_libraries variable)
  set(out)
  foreach(name IN LISTS ARGN)
    if(GYROBENCH_HAS_LAYER_${name})
      string(REPLACE "/" "_" target ${name})
      list(APPEND out gyrobench::${target})
    else()
      list(APPEND out ${name})
    endif()
  endforeach()
  set(${variable} ${out} PARENT_SCOPE)
endfunction()

function(gyrobench_link target)
  gyrobench_libraries(libraries ${ARGN})
  target_link_libraries(${target} PRIVATE ${libraries} gyrobench_flags)
  gyrobench_sanitize(${target})
endfunction()

# Instruments the target, unless its room is one of GYROBENCH_SANITIZE_NOT.
function(gyrobench_sanitize target)
  file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
  if(GYROBENCH_SANITIZE AND NOT folder IN_LIST GYROBENCH_SANITIZE_NOT)
    target_link_libraries(${target} PRIVATE gyrobench_sanitizers)
  endif()
endfunction()

function(gyrobench_compile_together target batch)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${GYROBENCH_UNITY} UNITY_BUILD_BATCH_SIZE ${batch})
endfunction()

# What belongs to the tests sees everything of the rooms that it links, and the tests' own headers.
function(gyrobench_link_for_tests target)
  gyrobench_libraries(libraries ${ARGN})
  target_link_libraries(${target} PUBLIC ${libraries} PRIVATE gyrobench_flags)
  gyrobench_sanitize(${target})
  target_include_directories(${target} PUBLIC ${PROJECT_SOURCE_DIR})
endfunction()

function(gyrobench_room name)
  cmake_parse_arguments(arg "" "" "SOURCES;DEPENDS;LINK;SHOWS" ${ARGN})
  gyrobench_check_layers(${name} ${arg_DEPENDS})
  string(REPLACE "/" "_" target ${name})
  add_library(gyrobench_${target} STATIC ${arg_SOURCES})
  add_library(gyrobench::${target} ALIAS gyrobench_${target})
  gyrobench_link(gyrobench_${target} ${arg_DEPENDS} ${arg_LINK})
  foreach(shown IN LISTS arg_SHOWS)
    if(NOT shown IN_LIST arg_DEPENDS AND NOT shown IN_LIST arg_LINK)
      message(FATAL_ERROR "room '${name}' SHOWS '${shown}', which is neither in its DEPENDS nor in its LINK")
    endif()
  endforeach()
  gyrobench_libraries(shown ${arg_SHOWS})
  target_link_libraries(gyrobench_${target} INTERFACE ${shown})

  set(door ${PROJECT_BINARY_DIR}/rooms/${target})
  get_filename_component(outer ${door}/${name} DIRECTORY)
  file(MAKE_DIRECTORY ${outer})
  file(CREATE_LINK ${CMAKE_CURRENT_SOURCE_DIR} ${door}/${name} SYMBOLIC)
  target_include_directories(gyrobench_${target} PUBLIC ${door})
  gyrobench_compile_together(gyrobench_${target} 12)
endfunction()

# For those outside who want the whole of a room that is made of rooms.
function(gyrobench_rooms_as_one name)
  add_library(gyrobench_${name} INTERFACE)
  add_library(gyrobench::${name} ALIAS gyrobench_${name})
  gyrobench_libraries(libraries ${ARGN})
  target_link_libraries(gyrobench_${name} INTERFACE ${libraries})
endfunction()

function(gyrobench_program name)
  cmake_parse_arguments(arg "" "ROOM" "SOURCES;DEPENDS;LINK" ${ARGN})
  set(others ${arg_DEPENDS})
  list(REMOVE_ITEM others ${arg_ROOM})
  gyrobench_check_layers(${arg_ROOM} ${others})
  add_executable(${name} ${arg_SOURCES})
  gyrobench_link(${name} ${arg_DEPENDS} ${arg_LINK})
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
endfunction()

function(gyrobench_test name)
  cmake_parse_arguments(arg "" "" "SOURCES;DEPENDS;LINK" ${ARGN})
  add_executable(${name} ${arg_SOURCES})
  gyrobench_compile_together(${name} 8)
  gyrobench_link_for_tests(${name} ${arg_DEPENDS} ${arg_LINK} GTest::gmock GTest::gtest_main)
  target_compile_definitions(${name} PRIVATE GYROBENCH_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  # gtest_discover_tests would run each binary at build time; one entry a binary keeps ctest quick.
  add_test(NAME ${name} COMMAND ${name})
  set_tests_properties(${name} PROPERTIES TIMEOUT ${GYROBENCH_TEST_TIMEOUT_S})
endfunction()

function(gyrobench_benchmark name)
  if(NOT GYROBENCH_BENCHMARKS)
    return()
  endif()
  cmake_parse_arguments(arg "" "" "SOURCES;DEPENDS;LINK" ${ARGN})
  add_executable(${name} ${arg_SOURCES})
  gyrobench_link_for_tests(${name} ${arg_DEPENDS} ${arg_LINK})
  target_compile_definitions(${name} PRIVATE GYROBENCH_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
endfunction()
