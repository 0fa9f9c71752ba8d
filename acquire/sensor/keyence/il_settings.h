#pragma once

#include <array>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "acquire/findings.h"
#include "acquire/protocol/keyence/dl_rs1a.h"
#include "acquire/sensor/keyence/il_unit.h"
#include "base/clock.h"
#include "base/error.h"
#include "trial/trial_format.h"

/// The settings of an IL amplifier by name: what a user writes, and what the codes mean.
namespace haptometer::acquire::il_setting {

/// A code for a data number.
struct Write {
  std::string key;  ///< "sampling"
  int number = 0;   ///< of the data
  int code = 0;
  std::optional<int> only_where{};  ///< written only where the data holds this code now

  friend bool operator==(const Write&, const Write&) = default;
};

/// Reads KEY=VALUE; what has to be written, in order:
///   sampling=default|0.33ms|1ms|2ms|5ms              data 132
///   averaging=1|2|4|...|4096|difference|high-pass    data 133
///   hold=sample|peak|bottom|peak-to-peak|auto-peak|auto-bottom    data 136
///   high-pass=0.1Hz|0.2Hz|...|100Hz                  data 159, and 133 to the high-pass filter
///   high-pass=off                                    data 133 to no averaging, where it is the
///   filter
/// A space and a dash are the same. Errors (Cause::kUsage): no such key or value, with those that
/// exist.
[[nodiscard]] Result<std::vector<Write>> Parse(std::string_view text);

/// `code` of data `number` in the words of Parse(): "0.33ms"; the code itself where it has none.
[[nodiscard]] std::string Describe(int number, int code);

}  // namespace haptometer::acquire::il_setting

namespace haptometer::acquire {

/// What an IL amplifier said of itself, by data number, as sent.
class UnitSettings {
 public:
  /// The data numbers worth reading, in this order.
  static constexpr std::array<int, 9> kNumbers = {
      dl_rs1a::kConnectedHead, dl_rs1a::kProductName, dl_rs1a::kSamplingCycle,
      dl_rs1a::kAveraging,     dl_rs1a::kHold,        dl_rs1a::kHighPassCutoff,
      dl_rs1a::kErrorFlags,    dl_rs1a::kBank,        dl_rs1a::kZeroShiftMemory};

  void Set(int number, std::string data) { data_[number] = std::move(data); }

  /// The connected head, where it is known.
  [[nodiscard]] const dl_rs1a::Head* head() const;

  /// Puts what is known into `metadata`: head, sampling, averages, hold.
  void Describe(trial::Metadata& metadata) const;

  /// Adds every answer as it came, under its number and `suffix`: `keyence_data_133_01`.
  void AddFields(trial::Metadata& metadata, std::string_view suffix) const;

  /// How long one reading takes at most: averages x sampling period, in s; 0 where the averages are
  /// not known.
  [[nodiscard]] double ResponseSeconds() const;

  /// What these settings do to a recording, in sentences; empty where nothing is unusual or known.
  [[nodiscard]] Findings Found() const;

  /// Whether the product name says that this is an emulator.
  [[nodiscard]] bool is_emulated() const;

 private:
  [[nodiscard]] std::string Text(int number) const;
  [[nodiscard]] std::optional<int> Code(int number) const;
  [[nodiscard]] std::optional<double> SamplingSeconds() const;
  [[nodiscard]] std::optional<int> Averages() const;

  std::map<int, std::string> data_;
};

/// "amplifier 00"
[[nodiscard]] std::string AmplifierName(int unit);

/// Something in an amplifier that was changed because the user asked for it.
struct IlChange {
  int unit = 0;     ///< identification number of the amplifier
  std::string key;  ///< "sampling", "zero"
  std::string before;
  std::string after;  ///< as read back

  /// "amplifier 00: sampling 1ms -> 0.33ms"
  [[nodiscard]] std::string Text() const;
};

/// Writes each of `writes` to each of `units` and reads it back. What holds the code already is not
/// written, and is no change.
///
/// Data are written with as many digits as they are read. Errors (Cause::kCannotAnswer): a write
/// was refused (a locked unit: with the remedy) or did not take; what had been changed by then is
/// named, and stays.
[[nodiscard]] Result<std::vector<IlChange>> WriteSettings(
    IlTalk& talk, std::span<const int> units, std::span<const il_setting::Write> writes);

/// Shifts the zero of each of `units` to where its target is now: data 001 is written 0, 1 and 0
/// again (some models act on the edge, some on the level). The change is the P.V. as sent.
///
/// The shift is lost when the amplifier is switched off, unless its data 152 says otherwise. Errors
/// (Cause::kCannotAnswer): as WriteSettings; the amplifier says that it failed (data 054).
[[nodiscard]] Result<std::vector<IlChange>> ShiftZeros(IlTalk& talk, std::span<const int> units,
                                                       Clock& clock);

/// Waits until no amplifier shows -99.998, as it does after a setting was written, at most
/// `longest_ns`. Returns whether that came about: without a target it never does.
[[nodiscard]] Result<bool> WaitUntilValid(IlTalk& talk, MonotonicNs refresh_ns,
                                          MonotonicNs longest_ns, Clock& clock);

}  // namespace haptometer::acquire
