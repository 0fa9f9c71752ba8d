#include "tools/study/manifest.h"

#include <fmt/core.h>

#include "base/toml.h"

namespace haptometer::tools {
namespace {

TrialGroup ReadGroup(TomlTable& table) {
  TrialGroup group;
  group.files = table.Text("files").value_or("");
  group.pattern = table.Text("pattern").value_or("");
  group.subject = table.Text("subject").value_or("");
  group.condition = table.Text("condition").value_or("");
  group.repeat = table.Text("repeat").value_or("");
  if (group.files.empty()) table.Refuse("files", "is missing", R"(add it, as files = "*.bin")");
  return group;
}

}  // namespace

Result<Manifest> ReadManifest(const std::string& path) {
  auto table = TomlTable::ParseFile(path);
  if (!table) return std::unexpected(table.error());
  Manifest manifest;
  manifest.pattern = table->Text("pattern").value_or("");
  manifest.conditions = table->TextList("conditions");
  manifest.band = table->Text("band").value_or("");
  manifest.order = table->Integer("order");
  manifest.corner = table->Choice("corner", {"whole", "each"}).value_or("");
  manifest.floor = table->Text("floor").value_or("");
  const std::vector<TomlTable*> groups = table->Tables("trials");
  manifest.groups.reserve(groups.size());
  for (TomlTable* group : groups) manifest.groups.push_back(ReadGroup(*group));
  const auto contrasts = table->TextLists("contrasts");
  manifest.contrasts.reserve(contrasts.size());
  for (const auto& pair : contrasts) {
    if (pair.size() != 2 || pair[0].empty() || pair[1].empty() || pair[0] == pair[1]) {
      table->Refuse("contrasts", "holds something else than pairs of two conditions",
                    R"(write it as [["ia1", "stock"]])");
      break;
    }
    manifest.contrasts.push_back({pair[0], pair[1]});
  }
  if (auto done = table->Finish(); !done) return std::unexpected(done.error());
  return manifest;
}

}  // namespace haptometer::tools
