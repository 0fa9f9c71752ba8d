#include <array>

#include "tools/document/document.h"

// What reading a file finds, in words (trial/findings.h).

namespace haptometer::document {
namespace {

using trial::FindingKind;

constexpr std::size_t kKinds = static_cast<std::size_t>(FindingKind::kNotedAtExport) + 1;
// the first kLosses kinds are losses of rows, which share the ending kLost
constexpr std::size_t kLosses = static_cast<std::size_t>(FindingKind::kDamagedFromBlock) + 1;

// in the order of the kinds
constexpr std::array<Sentence, kKinds> kSentences{{
    {"signature-damaged", "the file's signature is damaged"},
    {"blocks-damaged",
     "[block {block} is damaged][blocks {first_block} to {last_block} are damaged]"},
    {"blocks-missing",
     "[block {block} is missing][blocks {first_block} to {last_block} are missing]"},
    {"block-out-of-order", "block {block} is out of order"},
    {"block-no-event", "block {block} holds no event"},
    {"block-unfit", "block {block} does not fit the header"},
    {"ends-in-block", "the file ends inside block {block}"},
    {"damaged-from-block", "the file is damaged from block {block} on"},
    {"not-finished", "the file was not finished by its writer"},
    {"doubted-at-recording", "at the recording: {text}"},
    {"numbers-refuted",
     "by the number{lines s} of {lines} line{lines s} more lines are missing than the times hold "
     "({missing} before row {row}): a line sent twice, a wrong number or a counter that was reset; "
     "these losses do not count"},
    {"format-found",
     "the file is read as {title} (found; --format {format})[, cells separated by {separator}], "
     "channels {channels}"},
    {"format-given",
     "the file is read as {title} (--format {format})[, cells separated by {separator}], channels "
     "{channels}"},
    {"format-not-used", "the file has a layout of its own; --format is not used"},
    {"unit-overridden",
     "column {column} is in units of[ {file_factor} {file_unit}][ '{unknown_unit}'] by the file "
     "and "
     "of {given_factor} {given_unit} by --columns or --scale, which is used"},
    {"stated-rows-differ", "the file states {stated_rows} rows and holds {rows}"},
    {"last-line-cut-off",
     "line {line}, the last one, has no line end and is shorter than those before: it was cut off "
     "and is excluded; is the file complete?"},
    {"rate-contradicted",
     "the times give {rate_hz} and '{stated_by}' gives {stated_hz}; --rate decides"},
    {"times-in-other-unit",
     "the times give {rate_hz} where the file states {stated_hz}; they are used as they are, but "
     "may be in another unit than their column states"},
    {"rate-replaced", "--rate {rate_hz} replaces {stated_hz} by '{stated_by}'"},
    {"start-assumed", "the time of the first row is not in the file; it is assumed to be 0 s"},
    {"rows-missing",
     "rows are missing by the row numbers in the first column: {missing} in {places} "
     "place{places s}, the first before line {line}"},
    {"row-numbers-uneven",
     "the row numbers in the first column do not grow by whole steps in line {line}: whether rows "
     "are missing is not known; all rows are taken to follow each other"},
    {"rows-excluded",
     "rows with the time of the row before are excluded: {excluded} of {rows}, the first in line "
     "{line}"},
    {"times-rebuilt",
     "{repeated} of {rows} times equal that of the row before, because they have too few digits; "
     "they are replaced by the uniform grid that explains all of them, whose rate is "
     "{rate_hz +-rate_uncertainty_hz}"},
    {"channels-apart",
     "the channels begin up to {apart_s} apart (t0); all are given the times of the first one"},
    {"transitions-only",
     "digital channels list their transitions only: their rows are not samples"},
    {"value-unit-assumed", "the unit of the values is not in the file; {title} writes {unit}"},
    {"time-unit-assumed", "the unit of the times is not in the file; {title} writes {unit}"},
    {"calibration-of", "the calibration is applied to the channel '{channel}'"},
    {"input-too-large",
     "the input of the calibration reaches {most_v}, more than an analog output gives: is its "
     "column in mV? Name it by --columns time_s,voltage_mv, or that of the pairs voltage_mv"},
    {"rows-begin-at",
     "the rows begin at number {first}: times are Start + number x Increment; if Start is the "
     "first row's time, all are {earlier_s} earlier"},
    {"noted-at-export", "{text}"},
}};

// behind each loss: where in the file, and which rows
constexpr std::string_view kLost =
    "[ (bytes {from_byte} to {to_byte})][: row {row} is lost][: rows {first_row} to {last_row} are "
    "lost][: what followed row {after_row} is lost]";

std::array<std::string, kLosses> LossTexts() {
  std::array<std::string, kLosses> texts;
  for (std::size_t k = 0; k < kLosses; ++k) {
    texts[k] = std::string(kSentences[k].text) + std::string(kLost);
  }
  return texts;
}

}  // namespace

Sentence SentenceOf(FindingKind kind) {
  // composed once: sentences refer to their text without owning it
  static const std::array<std::string, kLosses> loss_texts = LossTexts();
  const auto number = static_cast<std::size_t>(kind);
  const Sentence& sentence = kSentences.at(number);
  return number < kLosses ? Sentence{sentence.kind, loss_texts[number]} : sentence;
}

}  // namespace haptometer::document
