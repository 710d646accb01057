/* What an aircraft asks of its map, as a template for your own program: opens a pack, asks for the region that a
 * position and its covariance span, and prints the mean gray value there, the height of the ground, and how grid and
 * geodesy relate.
 *
 * C11 and landfix.h, nothing else:   cc onboard_lookup.c $(pkg-config --cflags --libs landfix) -o onboard_lookup
 *
 *   onboard_lookup PACK LATITUDE_DEG LONGITUDE_DEG SIGMA_EAST_M SIGMA_NORTH_M CORRELATION [PUBLIC_KEY_FILE]
 *
 * With a key file, as 'landfix keygen' writes it, a pack that this key did not sign is refused. Exit code 0, 1 for an
 * error, 2 for usage. There is no dynamic memory: after lf_open, and lf_prepare where the pack is compressed, the
 * runtime allocates nothing either. */
#include <landfix/landfix.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define DEGREE 0.017453292519943295
#define SIGMAS 3.0       /* the region holds 98.9 % of where the aircraft may be */
#define WANTED_GSD_M 1.0 /* metres per pixel that the matcher wants */
#define COARSEST_GSD_M 64.0
#define MAX_PIXELS (1024 * 1024)

static uint8_t pixels[MAX_PIXELS];

/* Every call answers a status, and every status has a sentence. */
static int failed(const char* what, lf_status status) {
  if (status == LF_OK) return 0;
  fprintf(stderr, "onboard_lookup: %s: %s\n", what, lf_status_text(status));
  return 1;
}

/* Reads the line "landfix-public-key ed25519 <64 hexadecimal digits>". */
static int read_key(const char* path, uint8_t key[32]) {
  char digits[65] = "";
  FILE* file = fopen(path, "r");
  int found =
      file != NULL && fscanf(file, "landfix-public-key ed25519 %64[0-9a-f]", digits) == 1 && strlen(digits) == 64;
  if (file != NULL) fclose(file);
  for (int i = 0; found && i < 32; ++i) {
    const char byte[3] = {digits[2 * i], digits[2 * i + 1], 0};
    key[i] = (uint8_t)strtoul(byte, NULL, 16);
  }
  if (!found) fprintf(stderr, "onboard_lookup: %s: not a public key file of 'landfix keygen'\n", path);
  return found;
}

/* The region around the position at the wanted resolution, or at the finest that the buffer holds. */
static lf_status find_region(const lf_pack* pack, uint32_t layer, const lf_ellipse* where, lf_region* region) {
  lf_status status = LF_REGION_TOO_LARGE;
  for (double gsd_m = WANTED_GSD_M; gsd_m <= COARSEST_GSD_M; gsd_m *= 2) {
    status = lf_ellipse_region(pack, layer, where, gsd_m, region);
    if (status == LF_OK && (uint64_t)region->width * region->height <= MAX_PIXELS) return LF_OK;
    if (status == LF_OK) status = LF_BUFFER_TOO_SMALL;
    if (status != LF_REGION_TOO_LARGE && status != LF_BUFFER_TOO_SMALL) return status;
  }
  return status;
}

/* Mean gray value of the pixels with data. */
static int print_gray(const lf_pack* pack, const lf_ellipse* where) {
  uint32_t layer;
  lf_layer_info info;
  lf_region region;
  if (failed("gray", lf_find_layer(pack, "gray", &layer)) || failed("gray", lf_get_layer(pack, layer, &info))) return 0;
  if (failed("region", find_region(pack, layer, where, &region))) return 0;
  /* Before the flight, for the whole corridor: verifies, decodes what is compressed, and brings the rest into memory.
   */
  if (failed("prepare", lf_prepare(pack, &region, 0))) return 0;
  /* In flight: only this. */
  if (failed("read", lf_read(pack, &region, pixels, region.width, sizeof pixels))) return 0;
  uint64_t sum = 0, count = 0;
  for (size_t i = 0; i < (size_t)region.width * region.height; ++i)
    if (pixels[i] != info.nodata) sum += pixels[i], ++count;
  printf("region: %u x %u pixels of %g m from east %.1f, north %.1f\n", region.width, region.height, region.gsd_m,
         region.west_m, region.north_m);
  if (count > 0)
    printf("gray: mean %.2f of %llu pixels with data\n", (double)sum / (double)count, (unsigned long long)count);
  else
    printf("gray: no data\n");
  return 1;
}

static int print_height(const lf_pack* pack, double east_m, double north_m) {
  uint32_t layer;
  lf_region around;
  double height_m, undulation_m;
  lf_height_source source;
  if (lf_find_layer(pack, "height", &layer) == LF_OK &&
      lf_box_region(pack, layer, east_m - 50, north_m - 50, east_m + 50, north_m + 50, WANTED_GSD_M, &around) ==
          LF_OK &&
      failed("prepare", lf_prepare(pack, &around, 0)))
    return 0;
  if (failed("height", lf_height(pack, east_m, north_m, &height_m, &source))) return 0;
  printf("ground: %.2f m above the ellipsoid (%s)\n", height_m,
         source == LF_HEIGHT_LAYER ? "from the map" : "assumed plane");
  if (lf_undulation(pack, east_m, north_m, &undulation_m) == LF_OK)
    printf("geoid: %.2f m above the ellipsoid, so the ground is %.2f m above the geoid\n", undulation_m,
           height_m - undulation_m);
  return 1;
}

static int look_up(const lf_pack* pack, char** arguments) {
  double east_m, north_m, convergence_rad, scale;
  lf_info info;
  if (failed("info", lf_get_info(pack, &info))) return 0;
  if (failed("position", lf_grid_from_geodetic(pack, atof(arguments[0]) * DEGREE, atof(arguments[1]) * DEGREE, &east_m,
                                               &north_m, &convergence_rad, &scale)))
    return 0;
  printf("grid: zone %u %s, east %.3f, north %.3f\n", info.zone, info.north ? "north" : "south", east_m, north_m);
  printf("heading: true = grid %+.6f degrees; scale %.9f\n", convergence_rad / DEGREE, scale);
  const double sigma_east_m = atof(arguments[2]), sigma_north_m = atof(arguments[3]), correlation = atof(arguments[4]);
  const lf_ellipse where = {.east_m = east_m,
                            .north_m = north_m,
                            .cov_ee = sigma_east_m * sigma_east_m,
                            .cov_en = correlation * sigma_east_m * sigma_north_m,
                            .cov_nn = sigma_north_m * sigma_north_m,
                            .k = SIGMAS};
  return print_gray(pack, &where) && print_height(pack, east_m, north_m);
}

int main(int argc, char** argv) {
  if (argc != 7 && argc != 8) {
    fprintf(stderr,
            "usage: onboard_lookup PACK LATITUDE_DEG LONGITUDE_DEG SIGMA_EAST_M SIGMA_NORTH_M CORRELATION "
            "[PUBLIC_KEY_FILE]\n");
    return 2;
  }
  if (lf_abi_version() != LF_ABI_VERSION) {
    fprintf(stderr, "onboard_lookup: built against another version of the library\n");
    return 1;
  }
  uint8_t keys[1][32];
  if (argc == 8 && !read_key(argv[7], keys[0])) return 1;
  const lf_open_options options = {.struct_size = sizeof options,
                                   .flags = 0,
                                   .trusted_keys = argc == 8 ? (const uint8_t(*)[32])keys : NULL,
                                   .trusted_key_count = argc == 8 ? 1 : 0};
  lf_pack* pack = NULL;
  if (failed(argv[1], lf_open(argv[1], &options, &pack))) return 1;
  const int done = look_up(pack, argv + 2);
  lf_close(pack);
  return done ? 0 : 1;
}
