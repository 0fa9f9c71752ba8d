// A sweep's table as --resume, --merge and the summary read it: gone on with or refused, and what
// is gone on with holds the rows of its question. The seed is the table that the question makes.
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "base/error.h"
#include "base/input_file.h"
#include "fuzz/memory_path.h"
#include "fuzz/seeds.h"
#include "tools/sweep/sweep.h"

namespace {

using namespace haptometer;

constexpr std::string_view kScene =
    "[actuator]\nmodel = 'thesis-c10-100'\n[skin]\nstiffness_n_per_m = 600\ndamping_n_s_per_m = "
    "0.75\n[drive]\nkind = 'sine'\namplitude_v = 5\nfrequency_hz = 225\n";

const tools::SweepQuestion& Question() {
  static const fuzz::MemoryPath scene(kScene);
  static const auto question = [] {
    tools::SweepWords words;
    words.scenes = {scene.path()};
    words.vary = {"drive.frequency_hz=200,225,250"};
    words.output = "t.csv";
    return tools::ReadQuestion(words);
  }();
  HAPTOMETER_CHECK(question.has_value(), "{}", question.error().Text());
  return *question;
}

std::string Whole() {
  std::string table = tools::HeaderOf(Question(), {}).Text();
  for (std::uint64_t point = 0; point < 3; ++point) table += tools::RowOf(Question(), point);
  return table;
}

tools::SweepWords Merged(const std::string& output) {
  tools::SweepWords words;
  words.output = output;
  words.overwrite = true;
  words.command = {"sweep"};
  return words;
}

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned random) {
  static const std::string whole = Whole();
  const std::array<std::string_view, 1> seeds{whole};
  return fuzz::MutateFromSeeds(seeds, 0, {data, max_size}, size, random);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string whole = Whole();
  // a path in memory ends with its file: what was read before is no input of this merge
  ForgetInputs();
  const fuzz::MemoryPath file({reinterpret_cast<const char*>(data), size});
  [[maybe_unused]] const auto summary = tools::Summarise(file.path(), {});
  const std::string merged =
      std::filesystem::temp_directory_path() / ("sweep_table_fuzz_" + std::to_string(getpid()));
  if (tools::MergeTables({file.path()}, Merged(merged))) std::filesystem::remove(merged);
  const auto resumed =
      tools::TableFile::Resume(file.path(), tools::HeaderOf(Question(), {}), Question(), true);
  if (!resumed) {
    fuzz::Require(!resumed.error().Text().empty());
    return 0;
  }
  // what stands there now is the beginning of the whole table
  fuzz::Require(resumed->rows() <= 3);
  auto reader = tools::TableReader::Open(file.path());
  if (!reader) return 0;
  for (auto row = reader->Next(); row; row = reader->Next()) {
    fuzz::Require(whole.find("\n" + *row + "\n") != std::string::npos);
  }
  return 0;
}
