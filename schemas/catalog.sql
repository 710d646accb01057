-- The journal of one build: `area.lfpack.build/catalog.sqlite`, beside `tiles.spool`, which holds the data of its
-- tiles. It lives from the beginning of a build to its success, so a build that was stopped goes on where it was.

-- One row: what is being built, from which bytes. A journal is continued only where this is equal.
CREATE TABLE build (
  fingerprint TEXT NOT NULL
) STRICT;

-- Finished jobs. A row is written in one transaction with the tiles of its job, after their data.
CREATE TABLE job (
  stage TEXT NOT NULL,      -- 'source': tiles from the sources; 'halved': from the epochs halved to this level (below);
                            -- else the name of the layer whose coarser level the job makes of finer tiles
  level INTEGER NOT NULL,   -- of the window, or of the tiles made
  key INTEGER NOT NULL,     -- Hilbert key of the block of tiles, or of the first tile
  PRIMARY KEY (stage, level, key)
) STRICT, WITHOUT ROWID;

-- Sets of epochs that tiles were made from, each once, in the order in which the jobs that need them ended.
CREATE TABLE epoch_set (
  id INTEGER PRIMARY KEY,   -- counts from 1
  epochs BLOB NOT NULL      -- u16 indices into the pack's epochs, ascending, little-endian
) STRICT;

-- Finished tiles. Without a row here a finished job found no data.
CREATE TABLE tile (
  layer TEXT NOT NULL,      -- of the pack; or 'epoch/N': what epoch N shows, halved to this level: 256 rows of 256 pixels of
                            -- all its bands, then, where not all are valid, as many bytes of mask (255 or 0). These wait
                            -- for the 'halved' jobs of the level and never reach the pack; codec and values are 0
  level INTEGER NOT NULL,
  key INTEGER NOT NULL,     -- Hilbert key at the level
  offset INTEGER NOT NULL,  -- of the data in tiles.spool
  length INTEGER NOT NULL,
  codec INTEGER NOT NULL,   -- as in schemas/FORMAT.md
  value_offset REAL NOT NULL,
  value_step REAL NOT NULL,
  hash BLOB NOT NULL,       -- BLAKE2b-256 of the data
  epoch_set INTEGER NOT NULL,  -- epoch_set.id; 0: not stated
  PRIMARY KEY (layer, level, key)
) STRICT, WITHOUT ROWID;
