#include "tools/cli/recording_files.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <set>
#include <string_view>
#include <system_error>

#include "tools/cli/csv_cell.h"
#include "tools/document/keys.h"

namespace haptometer::cli {
namespace {

namespace fs = std::filesystem;

// enough for the header of a CSV, without the whole file
constexpr std::size_t kMostHeaderBytes = std::size_t{1} << 16U;

// in lower case: oscilloscopes write F0001CH1.CSV
std::string EndingOf(const fs::path& path) {
  std::string ending = path.extension();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return std::tolower(c); });
  return ending;
}

bool IsRecording(const fs::path& path) {
  const std::string ending = EndingOf(path);
  return ending == ".bin" || ending == ".csv" || ending == ".lvm";
}

// whether a CSV is a table of results and not a recording, by the names in its header
bool IsTableOfResults(const std::string& path) {
  if (EndingOf(path) != ".csv") return false;
  std::ifstream file(path, std::ios::binary);
  std::string beginning(kMostHeaderBytes, '\0');
  file.read(beginning.data(), static_cast<std::streamsize>(beginning.size()));
  beginning.resize(static_cast<std::size_t>(file.gcount()));
  // the first line that is no comment
  std::string_view rest = beginning;
  while (rest.starts_with('#') && rest.find('\n') != std::string_view::npos) {
    rest.remove_prefix(rest.find('\n') + 1);
  }
  const auto names = CellsOf(rest.substr(0, rest.find_first_of("\r\n")));
  const auto has = [&](std::string_view name) { return std::ranges::count(names, name) > 0; };
  // columns of analyze, study, matching and sweeps; a frequency without time is a spectrum
  return has(document::kSubject.name) || has(document::kRms.name) || has(document::kBandRms.name) ||
         has("matched_v") || (has(document::kFrequency.name) && !has(document::kTime.name));
}

}  // namespace

Result<std::vector<RecordingFile>> RecordingsIn(const std::string& folder) {
  std::vector<RecordingFile> files;
  std::error_code error;
  fs::path last = folder;
  for (auto at = fs::recursive_directory_iterator(folder, error);
       !error && at != fs::recursive_directory_iterator(); at.increment(error)) {
    std::error_code ignored;
    last = at->path();
    // what a file manager or a disk keeps for itself is no recording of the study
    const std::string name = last.filename();
    const bool is_hidden = name.starts_with('.') || name == "lost+found";
    if (is_hidden) at.disable_recursion_pending();
    // a link to nothing, or to itself, stays in the list: reading it tells that it is lost
    const bool is_lost_link = at->is_symlink(ignored) && !fs::exists(last, ignored);
    const bool is_file = at->is_regular_file(ignored) || is_lost_link;
    if (!is_hidden && is_file && IsRecording(last)) files.push_back({last});
  }
  if (error) {
    return Failed(last, "cannot be listed: " + error.message(),
                  "make it readable, or name the files");
  }
  // the order of the folder is arbitrary; a link to one of the files is no further recording
  std::ranges::sort(files, {}, &RecordingFile::path);
  const auto is_link = [](const RecordingFile& file) {
    std::error_code lost;
    return fs::is_symlink(file.path, lost);
  };
  const auto behind_links = [](const RecordingFile& file) {
    std::error_code lost;
    return fs::canonical(file.path, lost);
  };
  std::set<fs::path> own;
  for (const RecordingFile& file : files) {
    if (!is_link(file)) own.insert(behind_links(file));
  }
  std::erase_if(files, [&](const RecordingFile& file) {
    return is_link(file) && own.contains(behind_links(file));
  });
  for (RecordingFile& file : files) file.is_table = IsTableOfResults(file.path);
  if (std::ranges::all_of(files, &RecordingFile::is_table)) {
    return CannotAnswer(folder, "holds no recording", "recordings end in .bin, .csv or .lvm");
  }
  return files;
}

}  // namespace haptometer::cli
