// landfix verify: is every byte of a pack as it was built, and is it signed by somebody trusted?
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "builder/hex.h"
#include "tools/common/open_pack.h"
#include "tools/landfix/commands.h"

namespace landfix::tools {
namespace {

struct VerifyOptions {
  std::string pack;
  std::vector<std::string> keys;
  bool deep = false, json = false;
};

void verify(const VerifyOptions& o) {
  const Pack pack = open_pack(o.pack, o.keys);
  const Result<uint64_t> tiles = pack.verify(o.deep);
  check(tiles.status(), o.pack);
  const lf_info info = pack.info();
  const bool trusted = !o.keys.empty();
  if (o.json) {
    const nlohmann::ordered_json out{{"pack", o.pack},         {"ok", true},
                                     {"deep", o.deep},         {"tiles", *tiles},
                                     {"root", hex(info.root)}, {"signed", info.is_signed != 0},
                                     {"trusted", trusted}};
    fmt::print("{}\n", out.dump(2));
    return;
  }
  const char* signature = trusted          ? "signed by a trusted key"
                          : info.is_signed ? "signed, but not checked: give --key"
                                           : "not signed";
  fmt::print("{}: ok, {} tiles checked{}, {}\n", o.pack, *tiles, o.deep ? " and decoded" : "", signature);
}

}  // namespace

void add_verify(CLI::App& app) {
  auto o = std::make_shared<VerifyOptions>();
  CLI::App* c = app.add_subcommand("verify", "Check every byte of a pack, and its signature");
  c->add_option("pack", o->pack, "the pack")->required();
  c->add_option("--key", o->keys, "trusted public key file (may be repeated); refuse a pack that none of them signed")
      ->allow_extra_args(false);
  c->add_flag("--deep", o->deep, "decode every tile and check that padding is zero, too");
  c->add_flag("--json", o->json, "print JSON");
  c->footer(
      "Examples:\n  landfix verify --deep area.lfpack\n  landfix verify --key mission.pub area.lfpack\n\n"
      "Exit codes: 0 good, 4 damaged or not a pack, 5 unsigned or untrusted, 7 cannot be read.");
  c->callback([o] { verify(*o); });
}

}  // namespace landfix::tools
