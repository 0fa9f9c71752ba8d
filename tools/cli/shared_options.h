#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "dsp/analysis/band_question.h"
#include "tools/cli/options.h"
#include "trial/import/import_options.h"

namespace haptometer::cli {

/// Reads an accuracy, "1%", "0.01" or "1e-2". Errors (Cause::kUsage), naming --accuracy: not above
/// 0, below `least`, or above `most`.
[[nodiscard]] Result<double> ReadAccuracy(std::string_view text, double least, double most);

/// A band of frequencies, as said on the command line.
struct Band {
  double lower_hz = 0;
  double upper_hz = 0;
};

/// Reads "20-500Hz", "20Hz-0.5kHz": a lower corner without a unit takes that of the upper one.
/// Whether the two make a band is not asked. Errors (Cause::kUsage), naming --band.
[[nodiscard]] Result<Band> ParseBand(const std::string& text);

/// What is said of the filter; empty: as BandQuestion has it.
struct BandWords {
  std::string band;  ///< "20-500Hz"
  std::optional<std::int64_t> order;
  std::string corner;  ///< "whole" or "each"
};

/// Declares --band, --order (shown where `order_shown` says) and --corner.
void DeclareBand(Options* options, BandWords* words, Shown order_shown);

/// The question about that band, everything else as BandQuestion has it. Errors (Cause::kUsage): no
/// band-pass, before any file is read.
[[nodiscard]] Result<dsp::BandQuestion> BandQuestionOf(const BandWords& words);

/// What the command line says of a foreign table.
struct ImportWords {
  std::string columns;
  std::optional<double> rate_hz;
  std::optional<double> scale_m;
  std::optional<double> scale_v;
  std::string calibration;
  std::string format;
  std::string channel;
  std::optional<std::int64_t> segment;
};

/// What a verb reads of a table, which --scale is then about.
enum class Scaled : std::uint8_t { kDisplacement, kVoltage };

/// Declares --columns, --rate, --scale, --calibration, --format, --channel and --segment, shown by
/// --help-all, for any verb that reads recordings. A verb that has a --format of its own says so by
/// `has_format`.
void DeclareImport(Options* options, ImportWords* words, Scaled scaled = Scaled::kDisplacement,
                   bool has_format = false);

/// `files`: all that the command reads, floors too; they apply to the tables among them. Errors
/// (Cause::kUsage): a scale of 0, an empty name among the columns, a format that is not known; none
/// of `files` is a table, so that all of it would be passed over.
[[nodiscard]] Result<trial::ImportOptions> ImportOf(const ImportWords& words,
                                                    std::span<const std::string> files);

/// One of several parts of a work: items number - 1, number - 1 + count, ... from 0.
struct Shard {
  std::uint64_t number = 1;  ///< 1 to count
  std::uint64_t count = 1;

  /// How many of `items` items are its own.
  [[nodiscard]] std::uint64_t RowsOf(std::uint64_t items) const {
    return items < number ? 0 : (items - number) / count + 1;
  }
  /// The item in its row `row`, both from 0.
  [[nodiscard]] std::uint64_t PointOf(std::uint64_t row) const { return number - 1 + row * count; }
};

/// Reads "2/7"; the whole of an empty text. Errors (Cause::kUsage), naming --shard.
[[nodiscard]] Result<Shard> ReadShard(const std::string& text);

/// Threads as asked for, otherwise as many as there are cores, `most` at most.
[[nodiscard]] int ThreadsOf(const std::optional<std::int64_t>& asked, std::int64_t most);

/// "subject=3" and its like, split at the first '='.
///
/// Errors (Cause::kUsage), naming `option`: a word without '=' or without a key, with `example` of
/// one that has both; a key twice.
[[nodiscard]] Result<std::map<std::string, std::string>> ReadKeyValues(
    const std::vector<std::string>& words, std::string_view option, std::string_view example);

}  // namespace haptometer::cli
