// landfix keygen, landfix sign: who vouches for a map.
#include "tools/common/keys.h"

#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <memory>

#include "builder/hex.h"
#include "tools/common/files.h"
#include "tools/common/open_pack.h"
#include "tools/landfix/commands.h"

namespace landfix::tools {
namespace {

constexpr size_t kHeaderPage = 4096;

struct KeygenOptions {
  std::string name;
};

struct SignOptions {
  std::string pack, key, output;
};

void keygen(const KeygenOptions& o) {
  const std::string secret_file = o.name + ".key", public_file = o.name + ".pub";
  for (const std::string& file : {secret_file, public_file})
    if (std::filesystem::exists(file))
      throw Error(ExitCode::kBadInput, file + ": exists already; a key is never overwritten, choose another name");
  PublicKey public_key;
  SecretKey secret_key;
  check(lf_keygen(public_key.data(), secret_key.data()), "keygen");
  write_text(secret_file, secret_key_line(secret_key), 0600);
  write_text(public_file, public_key_line(public_key));
  fmt::print("{}: secret, signs packs; keep it to yourself\n{}: public, for everyone who is to trust them\n",
             secret_file, public_file);
}

void sign(const SignOptions& o) {
  const SecretKey key = read_secret_key(o.key);
  check(open_pack(o.pack).verify(false).status(), o.pack);  // nobody vouches for a damaged map
  const std::string output = o.output.empty() ? o.pack : o.output;
  write_atomically(output, [&](const std::string& temporary) {
    std::error_code failure;
    std::filesystem::copy_file(o.pack, temporary, std::filesystem::copy_options::overwrite_existing, failure);
    if (failure) throw Error(ExitCode::kIo, output + ": cannot be written: " + failure.message());
    std::fstream file(temporary, std::ios::binary | std::ios::in | std::ios::out);
    std::array<char, kHeaderPage> page;
    file.read(page.data(), page.size());
    check(lf_sign_header(page.data(), key.data()), o.pack);
    file.seekp(0);
    file.write(page.data(), page.size());
    file.close();
    if (!file) throw Error(ExitCode::kIo, output + ": cannot be written; is the disk full?");
  });
  fmt::print("{}: signed by {}\n", output, hex(open_pack(output).info().public_key));
}

}  // namespace

void add_keygen(CLI::App& app) {
  auto o = std::make_shared<KeygenOptions>();
  CLI::App* c = app.add_subcommand("keygen", "Make a key pair to sign packs with");
  c->add_option("name", o->name, "writes NAME.key (secret) and NAME.pub (public)")->required();
  c->footer(
      "Example:\n  landfix keygen mission\n  landfix sign --key mission.key area.lfpack\n  landfix verify --key "
      "mission.pub area.lfpack");
  c->callback([o] { keygen(*o); });
}

void add_sign(CLI::App& app) {
  auto o = std::make_shared<SignOptions>();
  CLI::App* c = app.add_subcommand("sign", "Sign a pack, so that a runtime with trusted keys accepts it");
  c->add_option("pack", o->pack, "the pack")->required();
  c->add_option("--key", o->key, "secret key file, made by 'landfix keygen'")->required();
  c->add_option("-o,--output", o->output, "where the signed pack goes (default: it replaces the unsigned one)");
  c->footer("Example:\n  landfix sign --key mission.key area.lfpack -o signed.lfpack");
  c->callback([o] { sign(*o); });
}

}  // namespace landfix::tools
