#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "base/error.h"
#include "dsp/analysis/band_analysis.h"
#include "dsp/analysis/band_filtering.h"
#include "dsp/analysis/window/window_choice.h"
#include "dsp/readings/clean_rows.h"
#include "dsp/readings/raw_summary.h"
#include "dsp/readings/segments.h"
#include "trial/record.h"

/// The steps of AnalyzeBand that come before any filter.
namespace haptometer::dsp {

/// The number of the channel that an analysis is of: trial::DisplacementChannel.
/// Errors (Cause::kCannotAnswer), naming what is there: there is none, or none in metres.
[[nodiscard]] Result<std::size_t> AnalyzedChannel(const trial::Record& head);

/// Adds a note where the record holds further displacements beside `channel`, which is analysed.
void NoteOtherDisplacements(const trial::Record& head, std::size_t channel, Findings* findings);

/// Fills `analysis.record` and says what was left out or handed out again. `summary` and `segments`
/// are of the record whose head is given.
void DescribeRecord(const trial::Record& head, const Segments& segments, const RawSummary& summary,
                    BandAnalysis* analysis);

/// Refuses a record whose new readings are fewer than 2.56 a period of the upper corner, by more
/// than a clock may be off (kOneRate).
void CheckNewReadings(const BandPass& band, BandAnalysis* analysis);

/// Adds to `analysis.reasons` what speaks against the band before any filtering: too few new
/// readings, or times of unknown age.
void CheckObservable(const trial::Record& head, const Segments& segments, const BandPass& band,
                     BandAnalysis* analysis);

/// "late 100, over 20": every status that is no measurement, and values that are no numbers.
[[nodiscard]] std::string Unmeasured(const RecordFacts& facts);

/// Adds a note for each code, and a finding for each kind of fault of which there is any: a doubt
/// where it is not corrected for.
void RemarkArtifacts(const CleanChannel& clean, BandAnalysis* analysis);

/// Why the readings of a part cannot be of a vibration: fewer changes from reading to reading than
/// two a period of the lower corner. Reads the part only where the whole record has that few.
/// Errors: as RowSource::Read.
[[nodiscard]] Result<std::optional<Finding>> WhyStuck(const Displacement& displacement,
                                                      const ChosenPart& part,
                                                      const BandAnalysis& analysis);

/// Fits a tone whose frequency f is known (the question's, or the file's drive) to the readings,
/// with a straight line beside it, where a reading's time is known to 0.1 / f (one standard
/// deviation, of every stretch) or by itself (Record::times_are_known); never to a polled sensor's
/// readings, which are of unknown age.
///
/// Above half the rate of new readings the tone is seen as an alias: other motion at the alias is
/// then taken for it, and a note says so. At a multiple of the rate, where all readings see one
/// phase, nothing is fitted. Reads 2^21 rows at most. Errors: as RowSource::Read.
[[nodiscard]] Result<void> FitKnownTone(const Displacement& displacement,
                                        const BandQuestion& question, BandAnalysis* analysis);

}  // namespace haptometer::dsp
