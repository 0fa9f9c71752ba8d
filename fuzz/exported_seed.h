#pragma once

#include <string>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "trial/import/readers.h"
#include "trial/trial_reader.h"

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

}  // namespace haptometer::fuzz
