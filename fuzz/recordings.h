#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "fuzz/require.h"
#include "trial/import/readers.h"
#include "trial/trial_reader.h"

/// What the fuzzers of files that hold whole recordings begin with, and what they require.
namespace haptometer::fuzz {

/// A small recording to be exported as the seed of a reader: two channels; with `has_gap` a reading
/// that is none and a gap too.
inline trial::Recording SeedRecording(bool has_gap) {
  const std::string_view csv =
      has_gap ? "# label.subject = 3\n# note\ntime_s,displacement_m,voltage_v,status\n"
                "0,1e-4,0.5,ok\n1e-3,2e-4,0.25,ok\n2e-3,,1,over\n3e-3,1e-4,2,repeated\n"
                "9e-3,2e-4,1,ok\n10e-3,3e-4,1,ok\n"
              : "# note\ntime_s,displacement_m,voltage_v,status\n0,1e-4,0.5,ok\n1e-3,2e-4,0.25,ok\n"
                "2e-3,3e-4,1,repeated\n";
  auto record = trial::ParseCsv(csv, "seed");
  HAPTOMETER_CHECK(record.has_value(), "{}", record.error().Text());
  return {.record = *std::move(record), .report = {}};
}

/// The bytes that `write` hands to its sink for the recording.
template <typename Write>
[[nodiscard]] std::string Exported(const Write& write, bool has_gap) {
  std::string bytes;
  const auto done = write(SeedRecording(has_gap), [&](std::string_view piece) -> Result<void> {
    bytes += piece;
    return {};
  });
  Require(done.has_value());
  return bytes;
}

/// What each reader of recordings promises: an error that says something, or a record whose
/// stretches cover its rows (trial/record.h).
inline void RequireSound(const Result<trial::Recording>& read) {
  if (!read) {
    Require(!read.error().Text().empty());
    return;
  }
  const trial::Record& record = read->record;
  std::size_t covered = 0;
  for (const trial::Stretch& stretch : record.stretches) {
    Require(stretch.first_row == covered && stretch.rows > 0 && stretch.rate_hz > 0);
    covered += stretch.rows;
  }
  Require(covered == record.rows);
  for (const trial::Channel& channel : record.channels) {
    Require(channel.values.size() == covered && channel.statuses.size() == covered);
  }
  Require(record.raw_times_s.empty() || record.raw_times_s.size() == covered);
}

}  // namespace haptometer::fuzz
