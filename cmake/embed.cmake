# Writes the bytes of FILE as the array NAME of namespace landfix::landmarks into HEADER.
file(READ ${FILE} hex HEX)
string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${hex}")
file(WRITE ${HEADER} "#pragma once\n#include <cstdint>\nnamespace landfix::landmarks {\n"
                     "inline constexpr uint8_t ${NAME}[] = {${bytes}};\n}\n")
