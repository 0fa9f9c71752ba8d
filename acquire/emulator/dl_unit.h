#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/emulator/asked_unit.h"
#include "acquire/emulator/il_amplifier.h"
#include "acquire/protocol/keyence/dl_line.h"

namespace haptometer::acquire::emulator {

/// What makes an emulated communication unit a DL-RS1A or a DL-EN1.
struct DlModel {
  const dl::Spelling& spelling;
  int first_unit;  ///< identification number of the first amplifier
  std::size_t longest_line;
  int no_such_unit, no_such_number, out_of_range, read_only, write_locked;  ///< error numbers
  int too_long;                                                             ///< of a line
  int faulty;                                            ///< of the fault `error`
  std::string (*format_number)(int number, int digits);  ///< as SR carries it
  std::string (*format_data_value)(const Value& value);  ///< as SR carries it
};

/// How long a unit takes; the makers' maxima where they are known.
struct DlTimes {
  MonotonicNs polled_ns = 0;   ///< M0, MS
  MonotonicNs direct_ns = 0;   ///< SR, SW, FR
  MonotonicNs to_all_ns = 0;   ///< AW
  MonotonicNs refresh_ns = 0;  ///< the buffer that M0 and MS read is refilled at k * refresh
};

/// A Keyence communication unit with IL amplifiers.
///
/// M0 and MS give the buffer's readings at the end of processing, which are the heads' last ones at
/// the latest refresh (the manuals do not say when within the processing time the buffer is read);
/// SR gives the head's last one. SW and AW are refused unless the unit is writable.
class DlUnit : public AskedUnit {
 protected:
  /// `heads`: one an amplifier, the main one first. `model` must outlive the unit.
  DlUnit(const DlModel& model, int baud, std::vector<MovingHead> heads, DlTimes times,
         bool is_writable, FaultPlan faults);

 private:
  [[nodiscard]] MonotonicNs ProcessingNs(std::string_view line) const final;
  [[nodiscard]] std::string AnswerTo(std::string_view line, MonotonicNs now,
                                     const Fault* fault) final;
  [[nodiscard]] std::string AnswerToOverlong(std::string_view line) const final;

  [[nodiscard]] std::string AnswerValues(dl::Command command, MonotonicNs now,
                                         const Fault* fault) const;
  [[nodiscard]] std::string AnswerData(const dl::Request& request, MonotonicNs now,
                                       const Fault* fault) const;
  [[nodiscard]] std::string AnswerDecimals(const dl::Request& request, const Fault* fault) const;
  [[nodiscard]] std::string AnswerWrite(const dl::Request& request, MonotonicNs now);
  [[nodiscard]] std::string Refuse(dl::Command command, int number) const;
  [[nodiscard]] std::optional<std::size_t> PlaceOf(int unit) const;

  const DlModel& model_;
  DlTimes times_;
  bool is_writable_;
  std::vector<IlAmplifier> amplifiers_;
};

}  // namespace haptometer::acquire::emulator
