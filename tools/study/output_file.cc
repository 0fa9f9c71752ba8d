#include "tools/study/output_file.h"

#include "tools/cli/whole_file.h"

namespace haptometer::tools {

Result<void> CheckOutput(const std::string& path, bool overwrite) {
  if (path.empty()) return {};
  auto file = cli::WholeFile::Begin(path, overwrite);
  if (!file) return std::unexpected(file.error());
  return {};
}

Result<void> WriteOutput(const std::string& path, std::string_view content, bool overwrite) {
  if (auto free = CheckOutput(path, overwrite); !free) return free;
  return cli::WriteWholeFile(path, content);
}

}  // namespace haptometer::tools
