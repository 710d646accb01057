// Options that several commands share.
#include "tools/landfix/commands.h"

namespace landfix::tools {

void add_bands(CLI::App& command, std::string& bands) {
  command
      .add_option("--bands", bands,
                  "What the image's bands show where the file does not say: nir,red,green; '-' leaves one out")
      ->type_name("ROLES");
}

}  // namespace landfix::tools
