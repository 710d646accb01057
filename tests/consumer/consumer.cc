// The same in C++.
#include <cstdint>
#include <cstdio>
#include <landfix/landfix.hpp>

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const auto pack = landfix::Pack::open(argv[1]);
  if (!pack) {
    std::fputs(pack.text(), stderr);
    return 1;
  }
  const auto gray = pack->find_layer("gray");
  if (!gray) return 1;
  const auto region = pack->box(*gray, 499712, 4999679, 499713, 4999680, 1);
  uint8_t pixel = 0;
  if (!region || pack->read(*region, {&pixel, 1}, 1) != LF_OK) return 1;
  std::printf("landfix %s, ABI %u, gray %d\n", lf_version(), unsigned(lf_abi_version()), pixel);
}
