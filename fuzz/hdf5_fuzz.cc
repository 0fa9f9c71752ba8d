// An HDF5 trial with changed bytes: read or refused, and what is read keeps the promises of a
// record. The input is a list of changes to a file that is exported at the start: libFuzzer finds
// no HDF5 file by itself. Each change takes five bytes: an offset of three, how the byte changes,
// and by what.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "base/error.h"
#include "fuzz/memory_path.h"
#include "trial/export/export.h"
#include "trial/import/readers.h"
#include "trial/trial_reader.h"

namespace {

using namespace haptometer;

// the bytes of a small exported trial
std::string ExportedTrial() {
  constexpr const char* kCsv =
      "# label.subject = 3\n# note\ntime_s,displacement_m,voltage_v,status\n"
      "0,1e-4,0.5,ok\n1e-3,2e-4,0.25,ok\n2e-3,,1,over\n3e-3,1e-4,2,repeated\n9e-3,2e-4,1,ok\n"
      "10e-3,3e-4,1,ok\n";
  trial::Recording recording;
  auto record = trial::ParseCsv(kCsv, "seed");
  HAPTOMETER_CHECK(record.has_value(), "{}", record.error().Text());
  recording.record = *std::move(record);
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("hdf5_fuzz_" + std::to_string(getpid()) + ".h5");
  auto writer = trial::Hdf5Writer::Create(path.string());
  HAPTOMETER_CHECK(writer.has_value(), "{}", writer.error().Text());
  const auto added = writer->Add("trial", recording, nullptr);
  const auto closed = writer->Close();
  HAPTOMETER_CHECK(added && closed, "{} is not written", path.string());
  std::ifstream file(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(file), {}};
  std::filesystem::remove(path);
  return bytes;
}

void Change(const std::uint8_t* change, std::string* bytes) {
  const std::size_t offset = change[0] + 256U * change[1] + 65536U * change[2];
  char& byte = (*bytes)[offset % bytes->size()];
  const auto by = static_cast<char>(change[4]);
  if (change[3] % 3 == 0) byte = by;
  if (change[3] % 3 == 1) byte = static_cast<char>(byte ^ by);
  if (change[3] % 3 == 2) byte = static_cast<char>(byte + by);
}

}  // namespace

// libhdf5 loses memory of its own on damaged files
extern "C" const char* __asan_default_options() { return "detect_leaks=0"; }

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string seed = ExportedTrial();
  constexpr std::size_t kChangeBytes = 5;
  std::string bytes = seed;
  for (std::size_t at = 0; at + kChangeBytes <= size; at += kChangeBytes) Change(data + at, &bytes);
  if (size % kChangeBytes == 1) bytes.resize(bytes.size() * (1U + data[size - 1]) / 256);
  const fuzz::MemoryPath file(bytes);
  const auto read = trial::ReadHdf5(file.path(), "");
  if (!read) {
    fuzz::Require(!read.error().Text().empty());
    return 0;
  }
  std::size_t covered = 0;
  for (const auto& stretch : read->record.stretches) {
    HAPTOMETER_CHECK(stretch.first_row == covered && stretch.rows > 0 && stretch.rate_hz > 0,
                     "stretch at row {} of {}", stretch.first_row, covered);
    covered += stretch.rows;
  }
  HAPTOMETER_CHECK(covered == read->record.rows, "{} of {} rows", covered, read->record.rows);
  for (const auto& channel : read->record.channels) {
    HAPTOMETER_CHECK(channel.values.size() == covered && channel.statuses.size() == covered,
                     "{} values", channel.values.size());
  }
  return 0;
}
