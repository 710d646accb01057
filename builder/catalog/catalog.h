// The journal of a build: which tile jobs are done, where the data of their tiles lies, from which inputs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "builder/catalog/file.h"
#include "schemas/pack_layout.h"
#include "tiles/grid.h"

namespace landfix::catalog {

/// A piece of work that is done as a whole or not at all. See schemas/catalog.sql for the meaning of the fields.
struct Job {
  std::string stage;
  int level = 0;
  uint64_t key = 0;
  auto operator<=>(const Job&) const = default;
};

/// Indices into the pack's epochs (exporter::PackDescription::epochs), strictly ascending.
using EpochSet = std::vector<uint16_t>;

/// A tile as its job hands it over. `record.offset` and `record.epoch_set` are set by the catalog.
struct FinishedTile {
  std::string layer;
  int level = 0;
  schema::TileRecord record{};
  std::vector<uint8_t> data;
  EpochSet epochs = {};  ///< that went into it; empty: not stated
};

/// A tile as its bytes lie in the spool, with key, length and hash of its record; the rest of it as by default.
FinishedTile finished_tile(std::string layer, const tiles::TileIndex& tile, std::vector<uint8_t> data);

/// A folder with `catalog.sqlite` and `tiles.spool`. One process at a time works on it; a killed one leaves it
/// consistent. `commit` and the queries belong to one thread at a time; `read` and `epochs_of` are safe from many. All
/// errors are Error (kIo).
class Catalog {
 public:
  /// Opens or creates the journal. One of another fingerprint, a damaged one, or one whose spool does not hold the
  /// recorded hashes is started over. Throws Error (kIo) where another build holds the folder.
  Catalog(const std::filesystem::path& folder, const std::string& fingerprint);
  ~Catalog();
  Catalog(const Catalog&) = delete;
  Catalog& operator=(const Catalog&) = delete;

  size_t jobs_found() const { return jobs_found_; }  ///< finished jobs taken over from an earlier run
  const std::string& note() const { return note_; }  ///< why a journal that was found is not continued; else empty

  bool is_done(const Job& job) const { return done_.contains(job); }
  /// Appends the data to the spool, then records job and tiles in one transaction. Throws Error (kBadInput) where the
  /// tiles show more different sets of epochs than a pack can hold.
  void commit(const Job& job, std::span<FinishedTile> tiles);

  /// The tiles of a level, ascending by key; offsets are those of the spool, `epoch_set` counts from 1 in epoch_sets().
  std::vector<schema::TileRecord> tiles(const std::string& layer, int level) const;
  /// All sets of epochs that tiles name, each once. Their order depends on that of the jobs; the pack's does not.
  std::vector<EpochSet> epoch_sets() const;
  /// The epochs of a tile that `tiles` gave; empty: not stated.
  EpochSet epochs_of(const schema::TileRecord& record) const;
  /// Data of a tile into `out` of `record.length` bytes.
  void read(const schema::TileRecord& record, std::span<uint8_t> out) const;

  /// Deletes the folder: the build has succeeded. Nothing else may be called afterwards.
  void remove();

 private:
  class Database;
  bool take_over(const std::string& fingerprint);
  void load_epoch_sets();
  void add_epoch_sets(std::vector<EpochSet> sets);
  std::vector<EpochSet> number_epoch_sets(std::span<FinishedTile> tiles) const;
  bool spool_is_intact() const;
  void start_over(const std::string& fingerprint);

  std::filesystem::path folder_;
  std::unique_ptr<Database> database_;
  std::unique_ptr<File> spool_;
  std::set<Job> done_;
  uint64_t spool_end_ = 0;
  size_t jobs_found_ = 0;
  std::string note_;
  mutable std::mutex epoch_mutex_;  // of epoch_sets_: one thread commits while others ask
  std::vector<EpochSet> epoch_sets_;
  std::map<EpochSet, uint16_t> epoch_set_ids_;
};

}  // namespace landfix::catalog
