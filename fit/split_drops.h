#pragma once

#include <vector>

#include "fit/impulse_record.h"

namespace haptometer::fit {

/// The drops of a record that holds several, each with the quiet part before it; else the record.
///
/// A further drop begins where the amplitude at the strongest frequency, fallen below a tenth of
/// its largest for a period, rises beyond three tenths; what follows a blow sooner is a second
/// impact of the same drop (disturbances.h). Pieces are named "FILE, drop 2". A stated drop height
/// is that of the first drop: whether the others fell as far, nobody knows. Nothing is split where
/// a piece would hold fewer than 6 periods.
[[nodiscard]] std::vector<ImpulseRecord> SplitDrops(const ImpulseRecord& record);

}  // namespace haptometer::fit
