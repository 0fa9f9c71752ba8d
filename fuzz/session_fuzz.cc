// A session's plan and log: whatever they hold, they are read or refused, and what is read is
// written as the same.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "base/text.h"
#include "fuzz/require.h"
#include "fuzz/seeds.h"
#include "tools/cli/raw_terminal.h"
#include "tools/session/session_log.h"
#include "tools/session/session_plan.h"
#include "tools/session/watched_folder.h"

namespace {

constexpr std::array<std::string_view, 3> kSeeds{
    "subjects = [\"1\", \"2\"]\nconditions = [\"stock\", \"cone\"]\nrepeats = 2\norder = "
    "\"random\"\nseed = 7\nfloor = \"per-subject\"\nduration_s = 4\nexpect = "
    "\"tone=225Hz+-1Hz\"\nsource = [\"--port\", \"/dev/ttyUSB0\"]\n",
    "utc,event,subject,condition,repeat,attempt,file,verdict,reason,crc32\n"
    "2026-11-24T18:53:22.936Z,begin,1,cone,1,1,a.bin,,,a5bf0132\n",
    "SHA-256 0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef, 12 bytes, modified "
    "1764185074123456789, run 1.csv"};

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned random) {
  return haptometer::fuzz::MutateFromSeeds(kSeeds, 0, {data, max_size}, size, random);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace haptometer;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  if (const auto plan = tools::ParsePlan(text, "session.toml")) {
    const std::string toml = tools::TomlOf(*plan);
    const auto again = tools::ParsePlan(toml, "session.toml");
    fuzz::Require(again.has_value() && tools::TomlOf(*again) == toml);
    const auto cells = tools::CellsOf(*plan);
    const auto counts = tools::CountCells(cells, {});
    fuzz::Require(counts.planned + counts.floors == cells.size() && counts.next.has_value());
  } else {
    fuzz::Require(!plan.error().Text().empty());
  }
  // a file of a folder is written as it was read
  if (const auto file = tools::ReadFolderFile(text)) {
    const auto again = tools::ReadFolderFile(tools::TextOf(*file));
    fuzz::Require(again.has_value() && tools::TextOf(*again) == tools::TextOf(*file));
  }
  // any bytes are keys, and what may be part of one is short of it
  std::string bytes(text);
  for (const bool is_all : {false, true}) {
    for (const cli::Key& key : cli::TakeKeys(bytes, is_all)) {
      fuzz::Require(key.kind != cli::Key::Kind::kText || IsPrintable(key.text));
    }
  }
  fuzz::Require(bytes.empty());
  // any text is a log; behind it a new attempt counts
  const tools::SessionCell cell{"1", "cone", 1};
  const std::string more = tools::TextOf(
      {"", tools::SessionEvent::kEnd, cell, 1, "fuzz.bin", tools::SessionVerdict::kGood, ""});
  const auto before = tools::ReadLog(text);
  const auto after = tools::ReadLog(std::string(text) + "\n" + more);
  fuzz::Require(after.attempts.size() >= before.attempts.size());
  fuzz::Require(after.Latest(cell) != nullptr);
  return 0;
}
