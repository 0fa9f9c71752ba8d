#pragma once

#include <cstdint>

#include "base/finding.h"

namespace haptometer::trial {

/// What a reader finds of a file beside its rows: what is lost of it, and what was assumed while a
/// foreign one was read. The numbers of each kind stand behind it.
enum class FindingKind : std::uint8_t {
  // --- losses (trial/trial_reader.h); numbers: block (or first_block and last_block), from_byte,
  // to_byte (where bytes are there), first_row and last_row or row (rows lost), after_row (where
  // their number is not known)
  kSignatureDamaged,
  kBlocksDamaged,
  kBlocksMissing,
  kBlockOutOfOrder,
  kBlockNoEvent,  ///< of an event, with other content
  kBlockUnfit,    ///< of rows, of another size than the header says
  kEndsInBlock,
  kDamagedFromBlock,  ///< and nothing sound follows
  kNotFinished,       ///< by its writer

  // --- the recording
  kDoubtedAtRecording,  ///< text: what a sensor doubted at the end of it
  kNumbersRefuted,      ///< lines, missing and row (of the first): by its number, not by its time

  // --- tables of other programs
  kFormatFound,       ///< format, title, channels, separator (where it is blanks)
  kFormatGiven,       ///< likewise: by the user
  kFormatNotUsed,     ///< the file has one layout
  kUnitOverridden,    ///< column, file_factor, file_unit / unknown_unit, given_factor, given_unit
  kStatedRowsDiffer,  ///< stated_rows, rows
  kLastLineCutOff,    ///< line: without a line end, and shorter than those before; left out
  kRateContradicted,  ///< rate_hz of the times, stated_hz, stated_by: the user's rate decides
  kTimesInOtherUnit,  ///< rate_hz of the times, stated_hz: a power of 1000 apart
  kRateReplaced,      ///< rate_hz of the user, stated_hz, stated_by
  kStartAssumed,      ///< the first row is put at 0 s
  kRowsMissing,       ///< missing, places, line (behind the first): by the rows' numbers
  kRowNumbersUneven,  ///< line (the first): the rows' numbers do not grow by whole steps; not used
  kRowsExcluded,      ///< excluded, rows, line: with the time of the row before
  kTimesRebuilt,      ///< repeated, rows, rate_hz, rate_uncertainty_hz (standard)
  kChannelsApart,     ///< apart_s: all are put at the first one's times
  kTransitionsOnly,   ///< rows of digital channels are no samples
  kValueUnitAssumed,  ///< title, unit
  kTimeUnitAssumed,   ///< title, unit
  kCalibrationOf,     ///< channel: of several, the one that a calibration turns into a displacement
  kInputTooLarge,     ///< most_v: more than an analog output gives
  kRowsBeginAt,       ///< first, earlier_s
  kNotedAtExport,     ///< text: what an exported file holds of these
};

using Finding = FindingOf<FindingKind>;
using Findings = haptometer::Findings<FindingKind>;

}  // namespace haptometer::trial
