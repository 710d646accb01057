/* The least that a consumer in C does: opens the pack, reads one pixel, says what it is linked to. */
#include <landfix/landfix.h>
#include <stdio.h>

int main(int argc, char** argv) {
  lf_pack* pack = NULL;
  lf_region region;
  unsigned char pixel = 0;
  uint32_t gray;
  if (argc != 2 || lf_abi_version() != LF_ABI_VERSION) return 2;
  if (lf_open(argv[1], NULL, &pack) != LF_OK) return 1;
  if (lf_find_layer(pack, "gray", &gray) != LF_OK) return 1;
  if (lf_box_region(pack, gray, 499712, 4999679, 499713, 4999680, 1, &region) != LF_OK) return 1;
  if (lf_read(pack, &region, &pixel, 1, 1) != LF_OK) return 1;
  printf("landfix %s, ABI %u, gray %d\n", lf_version(), (unsigned)lf_abi_version(), pixel);
  lf_close(pack);
  return 0;
}
