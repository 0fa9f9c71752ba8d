#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tools/study/text_table.h"

namespace haptometer::tools {

/// A condition of a generated matching test: matched over reference voltage at each level, the
/// geometric mean over the subjects.
struct GeneratedMatch {
  std::string condition;
  std::map<double, double> ratio_at_v;
};

/// The settings of eight subjects, at each level one started high and one low, as the table that
/// `study matching` reads. The logarithm of a setting's ratio is the truth's plus the subject's own
/// at that level (standard deviation 0.10, centred), ln 1.05 more or less by its start, and the
/// setting's (0.03).
[[nodiscard]] TextTable GenerateSettings(const std::vector<GeneratedMatch>& matches,
                                         std::uint64_t seed);

}  // namespace haptometer::tools
