/* landfix runtime: memory-maps a map pack and answers questions about the ground below. Plain C, for any language.
 *
 * Units: metres, radians. Frames: easting and northing on the grid of the pack's UTM or UPS zone (WGS84); heights above
 * the WGS84 ellipsoid. Rows of images run from north to south.
 *
 * Threads: any number of threads may call any function on one pack at the same time, except lf_close.
 * Memory: after lf_open, no function allocates, locks or does I/O (but for page faults of the mapping), except
 * lf_prepare, which decodes compressed tiles, and lf_sign, lf_keygen and lf_verify_pack. Raw layers need no lf_prepare.
 * Errors: every function that can fail returns lf_status; outputs are written only on LF_OK unless said otherwise.
 * The file of a mapped pack must not be changed or cut while it is open; where that cannot be guaranteed, open with
 * LF_OPEN_COPY.
 */
#ifndef LANDFIX_LANDFIX_H
#define LANDFIX_LANDFIX_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define LF_API __attribute__((visibility("default")))
#else
#define LF_API
#endif

/* Grows with every incompatible change of this header; equals the SONAME's number. */
#define LF_ABI_VERSION 1

typedef enum lf_status {
  LF_OK = 0,
  LF_INVALID_ARGUMENT = 1, /* null pointer, NaN, covariance that is none, unknown layer index */
  LF_IO = 2,               /* the file cannot be opened, read or mapped; errno is kept */
  LF_NOT_A_PACK = 3,       /* the file does not begin as a pack does */
  LF_UNKNOWN_VERSION = 4,  /* made by a newer landfix: update this library */
  LF_TRUNCATED = 5,        /* the file's length is not what its header says */
  LF_DAMAGED = 6,          /* a hash, an offset or a record is wrong */
  LF_UNSIGNED = 7,         /* trusted keys were given, and the pack bears no signature */
  LF_UNTRUSTED = 8,        /* signed by none of the trusted keys, or the signature is wrong */
  LF_OUT_OF_MEMORY = 9,
  LF_NO_SUCH_LAYER = 10, /* the pack has no layer of this name, or none of the wanted kind */
  LF_OUTSIDE_MAP = 11,   /* the pack has no data there */
  LF_NOT_PREPARED = 12,  /* the layer is compressed there: call lf_prepare for the region first */
  LF_BUFFER_TOO_SMALL = 13,
  LF_REGION_TOO_LARGE = 14, /* more than LF_MAX_REGION_PIXELS: ask with a coarser gsd_m or a smaller ellipse */
  LF_WRONG_TYPE = 15,       /* a call for layers of another pixel type */
  LF_END = 16               /* of an iteration */
} lf_status;

#define LF_MAX_REGION_PIXELS (1u << 28)

typedef struct lf_pack lf_pack;

/* A sentence that says what the status means and what to do about it. Static storage. */
LF_API const char* lf_status_text(lf_status status);
/* "0.1.0", and LF_ABI_VERSION as this library was built. */
LF_API const char* lf_version(void);
LF_API uint32_t lf_abi_version(void);

/* --- opening --- */

enum { LF_OPEN_COPY = 1 /* read the whole file to memory instead of mapping it */ };

typedef struct lf_open_options {
  uint32_t struct_size;              /* sizeof(lf_open_options) */
  uint32_t flags;                    /* LF_OPEN_* */
  const uint8_t (*trusted_keys)[32]; /* Ed25519 public keys; with any given, a pack signed by none of them is refused */
  size_t trusted_key_count;
} lf_open_options;

/* Opens a pack: checks header, manifest and block table, and the signature where keys are given. `options` may be null.
 */
LF_API lf_status lf_open(const char* path, const lf_open_options* options, lf_pack** pack);
/* The same for bytes in memory, 8-byte aligned, which must stay as they are until lf_close. */
LF_API lf_status lf_open_memory(const void* data, size_t size, const lf_open_options* options, lf_pack** pack);
/* Frees the pack and everything that points into it. Null is allowed. */
LF_API void lf_close(lf_pack* pack);

/* --- what is in it --- */
/* Strings point into the pack and live until lf_close; they are never null (absent ones are empty). */

typedef struct lf_info {
  uint16_t version_major, version_minor;
  uint8_t zone;        /* 1 to 60: UTM; 0: UPS */
  uint8_t north;       /* 1: northern hemisphere */
  uint8_t is_signed;   /* bears a signature (checked only against trusted keys) */
  uint8_t has_heights; /* 0: lf_height answers the assumed plane everywhere */
  uint32_t layer_count, source_count, parameter_count, epoch_count;
  double west_m, south_m, east_m, north_m;
  double plane_height_m;          /* assumed ground where there is no height tile */
  double georegistration_error_m; /* one sigma per axis; negative: not stated */
  uint64_t file_length;
  const char* builder;
  uint8_t root[32];       /* identifies the map */
  uint8_t public_key[32]; /* of the signer, if signed */
} lf_info;

typedef enum lf_pixel_type {
  LF_U8 = 0,
  LF_I16 = 1,
  LF_BIT = 2,       /* every channel is one bit plane */
  LF_LANDMARKS = 3, /* no pixels but landmarks: lf_find_landmarks */
  LF_ROADS = 4      /* no pixels but roads: lf_find_roads, lf_find_intersections */
} lf_pixel_type;

typedef struct lf_layer_info {
  const char* name;
  const char* description;
  uint8_t pixel_type; /* lf_pixel_type */
  uint8_t channels;   /* 0 where there are no pixels */
  int16_t nodata;
  uint32_t level_count;
} lf_layer_info;

typedef struct lf_level_info {
  int32_t level; /* gsd_m is 2^level */
  uint32_t tile_count;
  double gsd_m;
} lf_level_info;

typedef struct lf_source_info {
  const char *name, *capture_date, *licence, *attribution, *crs, *vertical_datum;
  uint8_t role; /* 0 image, 1 elevation, 2 vector */
  double gsd_m;
  uint8_t sha256[32];
} lf_source_info;

/* A capture date and the images that show it. Epochs count from 0, newest first, undated last. */
typedef struct lf_epoch_info {
  const char* date; /* ISO 8601; empty: undated */
  uint32_t source_count;
  const uint16_t* sources; /* indices for lf_get_source, ascending; they live until lf_close */
} lf_epoch_info;

LF_API lf_status lf_get_info(const lf_pack* pack, lf_info* info);
/* Index of a layer by name: "gray", "overview", "height", "landmarks", ... */
LF_API lf_status lf_find_layer(const lf_pack* pack, const char* name, uint32_t* layer);
LF_API lf_status lf_get_layer(const lf_pack* pack, uint32_t layer, lf_layer_info* info);
/* Levels of a layer, finest first. */
LF_API lf_status lf_get_level(const lf_pack* pack, uint32_t layer, uint32_t index, lf_level_info* info);
LF_API lf_status lf_get_source(const lf_pack* pack, uint32_t index, lf_source_info* info);
LF_API lf_status lf_get_epoch(const lf_pack* pack, uint32_t index, lf_epoch_info* info);
LF_API lf_status lf_get_parameter(const lf_pack* pack, uint32_t index, const char** name, const char** value);

/* --- regions --- */

/* A position as a filter knows it. */
typedef struct lf_ellipse {
  double east_m, north_m;
  double cov_ee, cov_en, cov_nn; /* square metres */
  double k;                      /* how many sigmas */
} lf_ellipse;

/* Rectangle of pixels of one layer at one level. The centre of pixel (column, row), counted from the north-western one,
 * lies at easting west_m + (column + 0.5) gsd_m and northing north_m - (row + 0.5) gsd_m. */
typedef struct lf_region {
  uint32_t layer;
  int32_t level;
  int64_t first_column, first_row; /* global pixels of the level, as in schemas/FORMAT.md and tiles/grid.h */
  uint32_t width, height;          /* pixels */
  double west_m, north_m, gsd_m;
} lf_region;

/* The bounding rectangle of the ellipse {x: (x - mean)' C^-1 (x - mean) <= k^2}, at the coarsest level of the layer
 * that is not coarser than gsd_m; at the finest (coarsest) where all are coarser (finer). LF_OUTSIDE_MAP where the
 * rectangle and the map's bounds do not meet. */
LF_API lf_status lf_ellipse_region(const lf_pack* pack, uint32_t layer, const lf_ellipse* ellipse, double gsd_m,
                                   lf_region* region);
/* The same for a rectangle in metres. */
LF_API lf_status lf_box_region(const lf_pack* pack, uint32_t layer, double west_m, double south_m, double east_m,
                               double north_m, double gsd_m, lf_region* region);

/* Copies the pixels of a region of a u8 layer, channels interleaved, rows `row_bytes` apart, into `out` of `out_bytes`
 * bytes. Pixels without data hold the layer's nodata. After an error the buffer's content is unspecified. */
LF_API lf_status lf_read(const lf_pack* pack, const lf_region* region, void* out, size_t row_bytes, size_t out_bytes);
/* Copies the values of a region of an i16 layer (heights: metres above the ellipsoid) as floats; NaN without data.
 * `row_bytes` is a multiple of sizeof(float). After an error the buffer's content is unspecified. */
LF_API lf_status lf_read_heights(const lf_pack* pack, const lf_region* region, float* out, size_t row_bytes,
                                 size_t out_bytes);

/* Copies the planes of a region of a bit layer: plane p begins at out + p * plane_words, its row y `row_words` words
 * further for each row, and column x of the region is bit x % 64 (from the lowest) of word x / 64. Bits beyond the
 * region's width in the last word of a row are 0; pixels without data hold the layer's nodata in all planes. `out` has
 * `out_words` words; planes must not overlap. After an error the buffer's content is unspecified. */
LF_API lf_status lf_read_bits(const lf_pack* pack, const lf_region* region, uint64_t* out, size_t row_words,
                              size_t plane_words, size_t out_words);

/* One tile without copying: 256 rows of 256 pixels. `pixels` lives until lf_close and is 8-byte aligned. Bit layers:
 * rows of 32 bytes, plane after plane, 8192 bytes apart; pixel c of a row is bit c % 8 of byte c / 8, so that
 * little-endian words of 64 bits are as those of lf_read_bits. */
typedef struct lf_tile {
  int32_t level, x, y;
  uint32_t row_bytes;
  double west_m, north_m, gsd_m;
  float value_offset, value_step; /* i16 layers: value = value_offset + value_step * pixel */
  const void* pixels;
} lf_tile;

/* LF_OUTSIDE_MAP where the layer has no such tile. */
LF_API lf_status lf_tile_view(const lf_pack* pack, uint32_t layer, int32_t level, int32_t x, int32_t y, lf_tile* tile);
/* Iterates over the tiles of the region that hold data, and where `ellipse` is given only those that it touches. Begin
 * with *cursor = 0; ends with LF_END. */
LF_API lf_status lf_next_tile(const lf_pack* pack, const lf_region* region, const lf_ellipse* ellipse, uint64_t* cursor,
                              lf_tile* tile);

enum { LF_PREPARE_COPY = 1 /* also copy raw tiles to memory, so that no page fault is left */ };
/* Verifies every tile of a region ahead of the flight, decodes what is compressed, and brings the rest into the page
 * cache. What it decodes stays in memory until lf_close. Regions of landmarks and roads are made as those of pixels
 * (gsd_m is of no account), and must be prepared before they are asked for. */
LF_API lf_status lf_prepare(const lf_pack* pack, const lf_region* region, uint32_t flags);

/* --- landmarks and roads --- */

/* What is asked for. Begin with zeros and set struct_size: that asks for everything in a box of no extent. */
typedef struct lf_feature_query {
  uint32_t struct_size;                    /* sizeof(lf_feature_query) */
  uint32_t class_mask;                     /* of landmarks: bit c asks for class c; 0: all classes */
  double west_m, south_m, east_m, north_m; /* a box, its western and southern edge included */
  const lf_ellipse* ellipse;               /* not null: what lies in the ellipse instead of the box */
  float min_confidence;                    /* 0 to 1 */
} lf_feature_query;

typedef enum lf_landmark_class {
  LF_BUILDING = 0,
  LF_FIELD = 1,
  LF_TREE = 2,
  LF_WATER = 3,
  LF_PAVED = 4
} lf_landmark_class;

typedef struct lf_landmark {
  double east_m, north_m;  /* its centre */
  float length_m, width_m; /* of the rectangle around it; length_m >= width_m */
  float orientation_rad;   /* of the length, clockwise from grid north, 0 to pi; NaN where it has none */
  float confidence;        /* probability, 0 to 1, that it is there and of its class */
  float distinctiveness_m; /* nothing of its class and like it in size is nearer than this */
  int32_t source;          /* -1: seen in the images; else the vector source that knows of it, for lf_get_source */
  uint16_t epochs_seen;    /* how many capture dates show it */
  uint8_t landmark_class;  /* lf_landmark_class */
  uint8_t reserved;
} lf_landmark;

/* Landmarks whose centre lies in the region, are of the classes asked for and at least as sure as asked for, each once:
 * tile after tile from north to south and from west to east in a row, within a tile in its own fixed order. `count`
 * tells how many there are, also where LF_BUFFER_TOO_SMALL says that `capacity` is less; the first `capacity` of them
 * are written. `landmarks` may be null where `capacity` is 0. LF_NOT_PREPARED before lf_prepare of the region;
 * LF_OUTSIDE_MAP where it does not meet the map's bounds. */
LF_API lf_status lf_find_landmarks(const lf_pack* pack, uint32_t layer, const lf_feature_query* query,
                                   lf_landmark* landmarks, size_t capacity, size_t* count);

#define LF_MAX_ARMS 8

/* Where three roads or more meet. */
typedef struct lf_intersection {
  double east_m, north_m;
  uint32_t degree;                /* how many roads leave it; the first LF_MAX_ARMS of them are below */
  float confidence;               /* probability, 0 to 1, that at least three do */
  float bearing_rad[LF_MAX_ARMS]; /* in which they leave, clockwise from grid north, 0 to 2 pi, ascending; else 0 */
  float width_m[LF_MAX_ARMS];
} lf_intersection;

/* As lf_find_landmarks. */
LF_API lf_status lf_find_intersections(const lf_pack* pack, uint32_t layer, const lf_feature_query* query,
                                       lf_intersection* intersections, size_t capacity, size_t* count);

typedef enum lf_road_node {
  LF_ROAD_END = 0,
  LF_ROAD_INTERSECTION = 1,
  LF_ROAD_BORDER = 2, /* of a tile: the road goes on as another one that begins or ends at the same place */
  LF_ROAD_JOINT = 3   /* goes on as another road here, of another width, say */
} lf_road_node;

typedef struct lf_point {
  double east_m, north_m;
} lf_point;

/* A stretch of road between two nodes. */
typedef struct lf_road {
  size_t first_vertex;   /* in the array of vertices of the same answer */
  uint32_t vertex_count; /* 2 or more, both ends among them */
  float width_m, length_m;
  float confidence;   /* probability, 0 to 1, that there is a road */
  int32_t source;     /* as of landmarks */
  uint8_t begin, end; /* lf_road_node */
  uint8_t reserved[2];
} lf_road;

/* Roads that touch the region (a box with all of its edges), whole and not cut to it, in the order of
 * lf_find_landmarks. A road is written with all of its vertices or not at all; where LF_BUFFER_TOO_SMALL says that they
 * do not all fit, the first ones that do are written. The counts are those of all roads. */
LF_API lf_status lf_find_roads(const lf_pack* pack, uint32_t layer, const lf_feature_query* query, lf_road* roads,
                               size_t road_capacity, size_t* road_count, lf_point* vertices, size_t vertex_capacity,
                               size_t* vertex_count);

/* --- how old is the map --- */

/* Which epochs went into a tile: indices for lf_get_epoch, ascending, so the newest first. `count` tells how many there
 * are, also where LF_BUFFER_TOO_SMALL says that `capacity` is less; 0: the pack does not say. `epochs` may be null
 * where `capacity` is 0. LF_OUTSIDE_MAP where the layer has no such tile. */
LF_API lf_status lf_tile_epochs(const lf_pack* pack, uint32_t layer, int32_t level, int32_t x, int32_t y,
                                uint16_t* epochs, uint32_t capacity, uint32_t* count);

/* What went into the tiles of a region. */
typedef struct lf_epoch_range {
  uint32_t newest, oldest; /* indices for lf_get_epoch; both 0 where `dated_tiles` is */
  uint32_t tiles;          /* tiles of the region that hold data */
  uint32_t dated_tiles;    /* those of them whose epochs the pack names */
} lf_epoch_range;

/* LF_OUTSIDE_MAP where no tile of the region holds data. */
LF_API lf_status lf_region_epochs(const lf_pack* pack, const lf_region* region, lf_epoch_range* range);

/* --- heights and geodesy --- */

typedef enum lf_height_source { LF_HEIGHT_LAYER = 0, LF_HEIGHT_PLANE = 1 } lf_height_source;

/* Height of the ground above the ellipsoid, bilinear at the finest level that has data there; the assumed plane where
 * there is none, as `source` (may be null) tells. */
LF_API lf_status lf_height(const lf_pack* pack, double east_m, double north_m, double* height_m,
                           lf_height_source* source);
/* Height of the geoid above the ellipsoid, bilinear in the pack's grid; LF_OUTSIDE_MAP outside of it or without one. */
LF_API lf_status lf_undulation(const lf_pack* pack, double east_m, double north_m, double* undulation_m);

/* Convergence: bearing of grid north clockwise from true north (true heading = grid heading + convergence). Scale: grid
 * distance over true distance. Any of the last two outputs may be null. */
LF_API lf_status lf_grid_from_geodetic(const lf_pack* pack, double latitude_rad, double longitude_rad, double* east_m,
                                       double* north_m, double* convergence_rad, double* scale);
LF_API lf_status lf_geodetic_from_grid(const lf_pack* pack, double east_m, double north_m, double* latitude_rad,
                                       double* longitude_rad, double* convergence_rad, double* scale);

/* --- verifying and signing --- */

/* Checks every block and every tile; with `deep`, also decodes every tile and checks that padding is zero. `tiles` (may
 * be null) counts the tiles checked. */
LF_API lf_status lf_verify_pack(const lf_pack* pack, int deep, uint64_t* tiles);
/* Makes an Ed25519 key pair from the system's randomness. */
LF_API lf_status lf_keygen(uint8_t public_key[32], uint8_t secret_key[64]);
/* Fills the signature slot of a header page (4096 bytes, checked) in place: how `landfix sign` makes a signed copy. */
LF_API lf_status lf_sign_header(void* header_page, const uint8_t secret_key[64]);

#ifdef __cplusplus
}
#endif

#endif /* LANDFIX_LANDFIX_H */
