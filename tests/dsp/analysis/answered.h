#pragma once

#include <gtest/gtest.h>

#include "dsp/analysis/band_analysis.h"

namespace haptometer::dsp {

/// The analysis of a record that can be read; a failed expectation and nothing where it cannot.
inline BandAnalysis Answer(const trial::Record& record, const BandQuestion& question = {}) {
  auto analysis = AnalyzeBand(record, question);
  EXPECT_TRUE(analysis) << (analysis ? "" : analysis.error().Text());
  return analysis ? *analysis : BandAnalysis{};
}

}  // namespace haptometer::dsp
