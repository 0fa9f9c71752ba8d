#pragma once

#include <string>

#include "dsp/analysis/band_analysis.h"
#include "dsp/analysis/raw_summary.h"
#include "dsp/analysis/segments.h"
#include "trial/record.h"

/// The steps of AnalyzeBand that come before any filter.
namespace haptometer::dsp {

/// Fills `analysis.record` and says what was left out or handed out again. `summary` and `segments`
/// are of the record whose head is given.
void DescribeRecord(const trial::Record& head, const Segments& segments, const RawSummary& summary,
                    BandAnalysis* analysis);

/// Adds to `analysis.reasons` what speaks against the band before any filtering: too few new
/// readings, or times of unknown age.
void CheckObservable(const trial::Record& head, const Segments& segments, const BandPass& band,
                     BandAnalysis* analysis);

/// "late 100, over 20": every status that is no measurement, and values that are no numbers.
[[nodiscard]] std::string Unmeasured(const RecordFacts& facts);

/// Adds a remark for each kind of fault, of which `analysis.faults` has any.
void RemarkFaults(const trial::Record& head, BandAnalysis* analysis);

}  // namespace haptometer::dsp
