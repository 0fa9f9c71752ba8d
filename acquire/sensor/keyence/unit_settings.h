#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "acquire/protocol/keyence/dl_rs1a.h"
#include "trial/trial_format.h"

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

  /// How long one reading takes: averages x sampling period, in s; 0 where they are not known.
  [[nodiscard]] double ResponseSeconds() const;

  /// What these settings do to a recording, in sentences; empty where nothing is unusual or known.
  [[nodiscard]] std::vector<std::string> Remarks() const;

  /// Whether the product name says that this is an emulator.
  [[nodiscard]] bool is_emulated() const;

 private:
  [[nodiscard]] std::string Text(int number) const;
  [[nodiscard]] std::optional<int> Code(int number) const;
  [[nodiscard]] std::optional<double> SamplingSeconds() const;
  [[nodiscard]] std::optional<int> Averages() const;

  std::map<int, std::string> data_;
};

}  // namespace haptometer::acquire
