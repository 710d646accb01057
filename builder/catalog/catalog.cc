#include "builder/catalog/catalog.h"

#include <fmt/format.h>
#include <sqlite3.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cstring>

#include "builder/catalog/catalog_sql.h"
#include "builder/catalog/hash.h"
#include "builder/error.h"

namespace landfix::catalog {
namespace {

namespace fs = std::filesystem;

// A prepared statement; `step` until false.
class Statement {
 public:
  Statement(sqlite3* database, const char* sql) : database_(database) {
    if (sqlite3_prepare_v2(database, sql, -1, &statement_, nullptr) != SQLITE_OK) fail();
  }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  Statement& bind(int index, int64_t value) { return check(sqlite3_bind_int64(statement_, index, value)); }
  Statement& bind(int index, double value) { return check(sqlite3_bind_double(statement_, index, value)); }
  Statement& bind(int index, const std::string& text) {
    return check(sqlite3_bind_text(statement_, index, text.data(), int(text.size()), SQLITE_TRANSIENT));
  }
  Statement& bind(int index, std::span<const uint8_t> blob) {
    return check(sqlite3_bind_blob(statement_, index, blob.data(), int(blob.size()), SQLITE_TRANSIENT));
  }
  bool step() {
    const int result = sqlite3_step(statement_);
    if (result != SQLITE_ROW && result != SQLITE_DONE) fail();
    return result == SQLITE_ROW;
  }
  void run() {
    step();
    check(sqlite3_reset(statement_));
  }
  int64_t integer(int column) { return sqlite3_column_int64(statement_, column); }
  double real(int column) { return sqlite3_column_double(statement_, column); }
  std::string text(int column) {
    const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
    return bytes ? std::string(bytes, size_t(sqlite3_column_bytes(statement_, column))) : std::string();
  }
  std::span<const uint8_t> blob(int column) {
    return {static_cast<const uint8_t*>(sqlite3_column_blob(statement_, column)),
            size_t(sqlite3_column_bytes(statement_, column))};
  }
  schema::Hash hash(int column) {
    schema::Hash hash{};
    const std::span<const uint8_t> bytes = blob(column);
    if (bytes.size() == sizeof hash.bytes) std::memcpy(hash.bytes, bytes.data(), sizeof hash.bytes);
    return hash;
  }

 private:
  Statement& check(int result) {
    if (result != SQLITE_OK) fail();
    return *this;
  }
  [[noreturn]] void fail() {
    throw Error(ExitCode::kIo,
                fmt::format("{}: {}", sqlite3_db_filename(database_, "main"), sqlite3_errmsg(database_)));
  }
  sqlite3* database_;
  sqlite3_stmt* statement_ = nullptr;
};

// What record_of reads.
constexpr char kSelectTiles[] =
    "SELECT key, offset, length, codec, value_offset, value_step, hash, epoch_set FROM tile ";

schema::TileRecord record_of(Statement& row) {
  schema::TileRecord record{};
  record.key = uint64_t(row.integer(0));
  record.offset = uint64_t(row.integer(1));
  record.length = uint32_t(row.integer(2));
  record.codec = uint8_t(row.integer(3));
  record.value_offset = float(row.real(4));
  record.value_step = float(row.real(5));
  record.hash = row.hash(6);
  record.epoch_set = uint16_t(row.integer(7));
  return record;
}

}  // namespace

FinishedTile finished_tile(std::string layer, const tiles::TileIndex& tile, std::vector<uint8_t> data) {
  FinishedTile out{std::move(layer), tile.level, {}, std::move(data), {}};
  out.record.key = tiles::hilbert_key(tile);
  out.record.length = uint32_t(out.data.size());
  out.record.hash = hash_of(out.data);
  return out;
}

// The connection and the statements of `commit`, prepared once.
class Catalog::Database {
 public:
  // Another process holds the journal: unlike a damaged one, it must not be replaced.
  struct Busy : Error {
    using Error::Error;
  };

  explicit Database(const fs::path& path) : path_(path) {
    sqlite3* opened = nullptr;
    const int result = sqlite3_open(path.c_str(), &opened);
    handle_.reset(opened);
    if (result != SQLITE_OK) fail(result);
    // The exclusive lock, held until the connection closes (also by a kill), keeps a second build away.
    execute(
        "PRAGMA locking_mode = EXCLUSIVE; PRAGMA journal_mode = WAL; PRAGMA synchronous = NORMAL; BEGIN EXCLUSIVE; "
        "COMMIT;");
  }

  sqlite3* handle() const { return handle_.get(); }

  void execute(const char* sql) {
    const int result = sqlite3_exec(handle(), sql, nullptr, nullptr, nullptr);
    if (result != SQLITE_OK) fail(result);
  }

  void prepare() {
    insert_job = std::make_unique<Statement>(handle(), "INSERT INTO job VALUES (?, ?, ?)");
    insert_epoch_set = std::make_unique<Statement>(handle(), "INSERT INTO epoch_set VALUES (?, ?)");
    insert_tile = std::make_unique<Statement>(handle(), "INSERT INTO tile VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  }

 private:
  [[noreturn]] void fail(int result) const {
    if (result == SQLITE_BUSY || result == SQLITE_LOCKED)
      throw Busy(ExitCode::kIo,
                 fmt::format("{}: another build is writing this pack; wait for it or choose another output",
                             path_.parent_path().string()));
    throw Error(ExitCode::kIo,
                fmt::format("{}: {}", path_.string(), handle() ? sqlite3_errmsg(handle()) : "out of memory"));
  }

  struct Close {
    void operator()(sqlite3* handle) const { sqlite3_close(handle); }
  };
  fs::path path_;
  std::unique_ptr<sqlite3, Close> handle_;

 public:
  std::unique_ptr<Statement> insert_job, insert_epoch_set, insert_tile;  // after the handle: finalized before it closes
};

Catalog::Catalog(const fs::path& folder, const std::string& fingerprint) : folder_(folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw Error(ExitCode::kIo, fmt::format("{}: cannot create this folder: {}", folder.string(), error.message()));
  const fs::path database = folder / "catalog.sqlite";
  const bool found = fs::exists(database);
  bool continued = false;
  try {
    database_ = std::make_unique<Database>(database);
    spool_ = std::make_unique<File>(folder / "tiles.spool", File::Open::kReadWrite);
    continued = found && take_over(fingerprint);
  } catch (const Database::Busy&) {
    throw;
  } catch (const Error&) {
    if (!found) throw;
    note_ = "the journal is damaged";
  }
  if (!continued) start_over(fingerprint);
  database_->prepare();
}

Catalog::~Catalog() = default;

// Reads what an earlier run left; false (and a note) where it cannot be continued.
bool Catalog::take_over(const std::string& fingerprint) {
  sqlite3* handle = database_->handle();
  Statement tables(handle, "SELECT count(*) FROM sqlite_master WHERE name IN ('build', 'epoch_set', 'job', 'tile')");
  tables.step();
  if (tables.integer(0) != 4) return false;  // killed before it had begun
  Statement build(handle, "SELECT fingerprint FROM build");
  if (!build.step() || build.text(0) != fingerprint) {
    note_ = "inputs, parameters or version differ from those of the journal";
    return false;
  }
  load_epoch_sets();
  if (!spool_is_intact()) {
    note_ = "the spooled tiles are damaged";
    return false;
  }
  for (Statement job(handle, "SELECT stage, level, key FROM job"); job.step();)
    done_.insert({job.text(0), int(job.integer(1)), uint64_t(job.integer(2))});
  jobs_found_ = done_.size();
  Statement end(handle, "SELECT coalesce(max(offset + length), 0) FROM tile");
  end.step();
  spool_end_ = uint64_t(end.integer(0));
  return true;
}

void Catalog::load_epoch_sets() {
  std::vector<EpochSet> sets;
  for (Statement row(database_->handle(), "SELECT epochs FROM epoch_set ORDER BY id"); row.step();) {
    const std::span<const uint8_t> bytes = row.blob(0);
    EpochSet set(bytes.size() / sizeof(uint16_t));
    if (!set.empty()) std::memcpy(set.data(), bytes.data(), set.size() * sizeof(uint16_t));
    sets.push_back(std::move(set));
  }
  add_epoch_sets(std::move(sets));
}

void Catalog::add_epoch_sets(std::vector<EpochSet> sets) {
  const std::lock_guard lock(epoch_mutex_);
  for (EpochSet& set : sets) {
    epoch_set_ids_.emplace(set, uint16_t(epoch_sets_.size() + 1));
    epoch_sets_.push_back(std::move(set));
  }
}

bool Catalog::spool_is_intact() const {
  std::vector<schema::TileRecord> records;
  for (Statement row(database_->handle(), (std::string(kSelectTiles) + "ORDER BY offset").c_str()); row.step();)
    records.push_back(record_of(row));
  const uint64_t size = spool_->size();
  std::atomic<bool> intact = true;
  tbb::parallel_for(tbb::blocked_range<size_t>(0, records.size(), 64), [&](const tbb::blocked_range<size_t>& range) {
    std::vector<uint8_t> data;
    for (size_t i = range.begin(); i < range.end() && intact; ++i) {
      const schema::TileRecord& record = records[i];
      if (record.length > schema::kMaxTileBytes || record.offset > size || record.length > size - record.offset ||
          record.epoch_set > epoch_sets_.size()) {
        intact = false;
        return;
      }
      data.resize(record.length);
      spool_->read_at(record.offset, data);
      if (hash_of(data) != record.hash) intact = false;
    }
  });
  return intact;
}

void Catalog::start_over(const std::string& fingerprint) {
  done_.clear();
  jobs_found_ = 0;
  spool_end_ = 0;
  epoch_sets_.clear();
  epoch_set_ids_.clear();
  database_.reset();
  spool_.reset();
  for (const char* name : {"catalog.sqlite", "catalog.sqlite-wal", "catalog.sqlite-shm", "tiles.spool"})
    fs::remove(folder_ / name);
  database_ = std::make_unique<Database>(folder_ / "catalog.sqlite");
  spool_ = std::make_unique<File>(folder_ / "tiles.spool", File::Open::kTruncate);
  database_->execute("BEGIN");
  database_->execute(kCatalogSql);
  Statement(database_->handle(), "INSERT INTO build VALUES (?)").bind(1, fingerprint).run();
  database_->execute("COMMIT");
}

// Gives every tile the number of its set of epochs; returns the sets that no tile had before.
std::vector<EpochSet> Catalog::number_epoch_sets(std::span<FinishedTile> tiles) const {
  std::vector<EpochSet> added;
  for (FinishedTile& tile : tiles) {
    tile.record.epoch_set = 0;
    if (tile.epochs.empty()) continue;
    if (const auto known = epoch_set_ids_.find(tile.epochs); known != epoch_set_ids_.end()) {
      tile.record.epoch_set = known->second;
      continue;
    }
    const auto place = std::find(added.begin(), added.end(), tile.epochs);
    const size_t id = epoch_sets_.size() + size_t(place - added.begin()) + 1;
    if (id > schema::kMaxEpochs)
      throw Error(ExitCode::kBadInput,
                  fmt::format("the tiles show more than {} different sets of capture dates, more than a pack can name; "
                              "give fewer dates or make several packs",
                              schema::kMaxEpochs));
    if (place == added.end()) added.push_back(tile.epochs);
    tile.record.epoch_set = uint16_t(id);
  }
  return added;
}

void Catalog::commit(const Job& job, std::span<FinishedTile> tiles) {
  std::vector<EpochSet> added = number_epoch_sets(tiles);
  uint64_t end = spool_end_;
  for (FinishedTile& tile : tiles) {
    spool_->write_at(end, tile.data);
    tile.record.offset = end;
    end += tile.data.size();
  }
  database_->execute("BEGIN");
  try {
    for (size_t i = 0; i < added.size(); ++i) {
      const auto* bytes = reinterpret_cast<const uint8_t*>(added[i].data());
      database_->insert_epoch_set->bind(1, int64_t(epoch_sets_.size() + i + 1))
          .bind(2, std::span(bytes, added[i].size() * sizeof(uint16_t)))
          .run();
    }
    for (const FinishedTile& tile : tiles) {
      const schema::TileRecord& r = tile.record;
      database_->insert_tile->bind(1, tile.layer)
          .bind(2, int64_t(tile.level))
          .bind(3, int64_t(r.key))
          .bind(4, int64_t(r.offset));
      database_->insert_tile->bind(5, int64_t(r.length)).bind(6, int64_t(r.codec)).bind(7, double(r.value_offset));
      database_->insert_tile->bind(8, double(r.value_step)).bind(9, std::span<const uint8_t>(r.hash.bytes));
      database_->insert_tile->bind(10, int64_t(r.epoch_set)).run();
    }
    database_->insert_job->bind(1, job.stage).bind(2, int64_t(job.level)).bind(3, int64_t(job.key)).run();
    database_->execute("COMMIT");
  } catch (...) {
    sqlite3_exec(database_->handle(), "ROLLBACK", nullptr, nullptr, nullptr);
    throw;
  }
  add_epoch_sets(std::move(added));
  spool_end_ = end;
  done_.insert(job);
}

std::vector<schema::TileRecord> Catalog::tiles(const std::string& layer, int level) const {
  Statement row(database_->handle(),
                (std::string(kSelectTiles) + "WHERE layer = ? AND level = ? ORDER BY key").c_str());
  row.bind(1, layer).bind(2, int64_t(level));
  std::vector<schema::TileRecord> records;
  while (row.step()) records.push_back(record_of(row));
  return records;
}

std::vector<EpochSet> Catalog::epoch_sets() const {
  const std::lock_guard lock(epoch_mutex_);
  return epoch_sets_;
}

EpochSet Catalog::epochs_of(const schema::TileRecord& record) const {
  const std::lock_guard lock(epoch_mutex_);
  return record.epoch_set == 0 ? EpochSet{} : epoch_sets_.at(record.epoch_set - 1u);
}

void Catalog::read(const schema::TileRecord& record, std::span<uint8_t> out) const {
  spool_->read_at(record.offset, out);
}

void Catalog::remove() {
  database_.reset();
  spool_.reset();
  std::error_code error;
  fs::remove_all(folder_, error);
  if (error)
    throw Error(ExitCode::kIo, fmt::format("{}: cannot remove this folder: {}", folder_.string(), error.message()));
}

}  // namespace landfix::catalog
