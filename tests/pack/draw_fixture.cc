// Draws what lies in the tree, and says what is in a pack:
//   landfix_draw_fixture draw FILE       schemas/fixtures/small.lfpack
//   landfix_draw_fixture seeds FOLDER    seeds for tests/pack/fuzz
//   landfix_draw_fixture describe FILE   JSON of every field, to compare with schemas/fixtures/read_pack.py
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>

#include "tests/pack/draw.h"
#include "tests/pack/fixture.h"

int main(int argc, char** argv) try {
  using namespace landfix::tests;
  const std::string verb = argc == 3 ? argv[1] : "";
  if (verb == "draw") {
    write_file(argv[2], draw_fixture());
  } else if (verb == "seeds") {
    for (const auto& [name, bytes] : draw_fuzz_seeds()) write_file(std::filesystem::path(argv[2]) / name, bytes);
  } else if (verb == "describe") {
    std::puts(describe(read_file(argv[2])).c_str());
  } else {
    std::fputs("usage: landfix_draw_fixture draw FILE | seeds FOLDER | describe FILE\n", stderr);
    return 2;
  }
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "landfix_draw_fixture: %s\n", e.what());
  return 1;
}
