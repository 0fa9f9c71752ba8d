#pragma once

#include "tools/plot/gnuplot.h"
#include "trial/record.h"

namespace haptometer::tools {

/// `channel` of `record` over time: its measurements about their mean (a length in um, the mean in
/// the title), broken at gaps and bad samples, and a mark at the lower edge for each bad sample.
///
/// Programmer's errors: a record without rows. Cost: one pass; memory: four doubles a row.
[[nodiscard]] plot::Panel PanelOf(const trial::Record& record, const trial::Channel& channel);

}  // namespace haptometer::tools
