#pragma once

#include <cstddef>

#include "fuzz/require.h"
#include "trial/record.h"

namespace haptometer::fuzz {

/// What each reader of recordings promises of a record (trial/record.h).
inline void RequireSound(const trial::Record& record) {
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
