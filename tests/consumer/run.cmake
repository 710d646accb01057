# Installs the runtime to a fresh prefix, builds consumers against it outside of the tree (by find_package and by
# pkg-config), runs them on the fixture, and looks at the library's name and symbols. tests/pack/CMakeLists.txt says with
# which variables.
cmake_minimum_required(VERSION 3.25)
set(prefix ${WORK}/prefix)
set(source ${WORK}/source)
set(fixture ${SOURCE}/schemas/fixtures/small.lfpack)
file(REMOVE_RECURSE ${WORK})

# run(WHAT COMMAND...): leaves what it prints in `output`; anything but exit code 0 ends the test.
function(run what)
  execute_process(COMMAND ${ARGN} OUTPUT_VARIABLE out ERROR_VARIABLE err RESULT_VARIABLE result
                  OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${what} failed with ${result}:\n${out}\n${err}")
  endif()
  set(output "${out}" PARENT_SCOPE)
endfunction()

# expect(WHAT REGEX): of `output`.
function(expect what regex)
  if(NOT output MATCHES "${regex}")
    message(FATAL_ERROR "${what}: expected '${regex}', found:\n${output}")
  endif()
endfunction()

run("install" ${CMAKE_COMMAND} --install ${BUILD} --component runtime --prefix ${prefix})
file(GLOB_RECURSE library ${prefix}/*/liblandfix.so)
file(GLOB_RECURSE pc ${prefix}/*/landfix.pc)
cmake_path(GET library PARENT_PATH library_folder)
cmake_path(GET pc PARENT_PATH pc_folder)

# Sources are copied: nothing of the tree can be reached by a relative path.
file(COPY ${SOURCE}/tests/consumer/ ${SOURCE}/tools/examples/onboard_lookup.c DESTINATION ${source})
# A sanitized library needs a program with the same sanitizer.
set(flags "")
if(SANITIZE)
  set(flags -fsanitize=${SANITIZE})
endif()

run("configuring with find_package" ${CMAKE_COMMAND} -S ${source} -B ${WORK}/build -D CMAKE_BUILD_TYPE=Release
    -D CMAKE_PREFIX_PATH=${prefix} -D CMAKE_C_COMPILER=${C_COMPILER} -D CMAKE_CXX_COMPILER=${CXX_COMPILER}
    -D CMAKE_C_FLAGS=${flags} -D CMAKE_CXX_FLAGS=${flags})
run("building with find_package" ${CMAKE_COMMAND} --build ${WORK}/build)

# The gray value follows from gray_hills() of tests/pack/fixture.cc at the map's north-western pixel.
set(answer "^landfix 0\\.1\\.0, ABI 1, gray 156$")
foreach(program consumer_c consumer_cc)
  run(${program} ${WORK}/build/${program} ${fixture})
  expect(${program} "${answer}")
endforeach()

set(ENV{PKG_CONFIG_PATH} ${pc_folder})
run("pkg-config" pkg-config --cflags --libs landfix)
separate_arguments(options UNIX_COMMAND "${output}")
run("pkg-config --modversion" pkg-config --modversion landfix)
expect("version" "^0\\.1\\.0$")
run("pkg-config --variable" pkg-config --variable=abi_version landfix)
expect("ABI version" "^1$")
run("C compiler" ${C_COMPILER} -std=c11 ${flags} ${source}/consumer.c ${options} -o ${WORK}/by_pkg_config_c)
run("C++ compiler" ${CXX_COMPILER} -std=c++20 ${flags} ${source}/consumer.cc ${options} -o ${WORK}/by_pkg_config_cc)
foreach(program by_pkg_config_c by_pkg_config_cc)
  run(${program} ${CMAKE_COMMAND} -E env LD_LIBRARY_PATH=${library_folder} ${WORK}/${program} ${fixture})
  expect(${program} "${answer}")
endforeach()

# The example, 30 m and 15 m around the middle of the raw tile: the numbers follow from tests/pack/fixture.cc.
set(lookup ${WORK}/build/onboard_lookup ${fixture} 45.149446660 8.997967819 10 5 0.5)
run("onboard_lookup" ${lookup} ${SOURCE}/schemas/fixtures/fixture.pub)
expect("grid" "grid: zone 32 north, east 499840\\.250, north 4999552\\.250")
expect("heading" "heading: true = grid -0\\.00144[0-9] degrees; scale 0\\.9996000")
expect("region" "region: 61 x 31 pixels of 1 m from east 499810\\.0, north 4999568\\.0")
expect("gray" "gray: mean 123\\.98 of 1891 pixels with data")
expect("height" "ground: 482\\.31 m above the ellipsoid \\(from the map\\)")
expect("geoid" "geoid: 47\\.41 m above the ellipsoid, so the ground is 434\\.91 m above the geoid")
string(REPEAT "0a" 32 other_key)
file(WRITE ${WORK}/other.pub "landfix-public-key ed25519 ${other_key}\n")
execute_process(COMMAND ${lookup} ${WORK}/other.pub RESULT_VARIABLE result ERROR_VARIABLE output)
if(NOT result EQUAL 1)
  message(FATAL_ERROR "onboard_lookup trusts a key that did not sign")
endif()
expect("untrusted" "trusted keys")
execute_process(COMMAND ${WORK}/build/onboard_lookup ${fixture} 10 10 10 5 0
                RESULT_VARIABLE result ERROR_VARIABLE output)
if(NOT result EQUAL 1)
  message(FATAL_ERROR "onboard_lookup answers outside of the map")
endif()
expect("outside" "no data there")

# ABI: the SONAME carries the ABI version, and nothing but the functions of landfix.h is exported.
run("readelf" ${READELF} -d ${library})
expect("SONAME" "SONAME[^\n]*\\[liblandfix\\.so\\.1\\]")
if(NOT SANITIZE)
  # Nothing under the GPL, and nothing that the design does not name (NOTICE).
  string(REGEX MATCHALL "NEEDED[^\n]*\\[[^]]*\\]" needed "${output}")
  foreach(entry ${needed})
    string(REGEX REPLACE ".*\\[(.*)\\].*" "\\1" name "${entry}")
    if(NOT name MATCHES "^(libGeographicLib|libzstd|libturbojpeg|libsodium|libstdc\\+\\+|libm|libgcc_s|libc|ld-linux[^.]*)\\.so")
      message(FATAL_ERROR "liblandfix.so needs '${name}', which NOTICE does not list")
    endif()
  endforeach()
  run("nm" ${NM} -D --defined-only --format=posix ${library})
  string(REGEX MATCHALL "[^\n]+" symbols "${output}")
  file(READ ${SOURCE}/runtime/pack/include/landfix/landfix.h header)
  list(LENGTH symbols count)
  foreach(symbol ${symbols})
    string(REGEX REPLACE " .*" "" name "${symbol}")
    if(NOT name MATCHES "^lf_" OR NOT header MATCHES "[ *]${name}\\(")
      message(FATAL_ERROR "liblandfix.so exports '${name}', which landfix.h does not declare")
    endif()
  endforeach()
  string(REGEX MATCHALL "LF_API" declared "${header}")
  list(LENGTH declared declarations)
  math(EXPR declarations "${declarations} - 2")  # the macro's own two definitions
  if(NOT count EQUAL declarations)
    message(FATAL_ERROR "landfix.h declares ${declarations} functions, liblandfix.so exports ${count}")
  endif()
endif()
message("consumers built and run outside of the tree")
