#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/emulator/device.h"
#include "acquire/emulator/fault.h"
#include "acquire/protocol/keyence/dl_en1.h"
#include "acquire/protocol/keyence/dl_line.h"
#include "acquire/protocol/keyence/dl_rs1a.h"
#include "acquire/protocol/wire.h"
#include "base/error.h"

namespace haptometer::acquire::emulator {

/// What a data number of an amplifier holds; how it is spelled is the communication unit's matter.
struct IlDatum {
  enum class Kind : std::uint8_t { kValue, kNumber, kText, kAnalog };
  Kind kind = Kind::kNumber;
  Value value{};       ///< kValue
  int number = 0;      ///< kNumber; kAnalog: mV
  int digits = 1;      ///< kNumber: as many as a DL-RS1A sends
  std::string text{};  ///< kText
};

/// How a write ended.
enum class IlWriteOutcome : std::uint8_t { kDone, kNoSuchNumber, kReadOnly, kOutOfRange };

/// An IL amplifier with its head: readings, and the data numbers that describe and set it.
///
/// Data 033, 036-040, 042, 054, 098, 132, 133, 136, 152, 159, 193, 195 and 200 (the product name,
/// which is EMULATED) can be read; 098, 132, 133, 136, 152 and 159 written, and 001 and 002 (zero
/// shift and its reset, at the edge from 0 to 1). Sampling and averages take effect; after a change
/// of 132, 133 or 136 the readings are invalid for two response times. Hold and filter are kept and
/// have no effect. Comparator limits are the ends of the measuring range.
///
/// A head that is none of the IL series is taken for an IL-030.
class IlAmplifier {
 public:
  /// `is_main`: the product code is that of a main amplifier.
  IlAmplifier(MovingHead head, bool is_main);

  /// The head's last reading that is complete at `sampled`; `now` decides whether the amplifier
  /// has settled.
  [[nodiscard]] Value ReadingAt(MonotonicNs sampled, MonotonicNs now) const;
  /// The comparator's outputs for `value`: bit 0 HIGH, 1 LOW, 2 GO, 3 alarm.
  [[nodiscard]] static int Outputs(const Value& value);

  /// Nothing for a number that it does not know. `present` is what the P.V. numbers give.
  [[nodiscard]] std::optional<IlDatum> Read(int number, const Value& present) const;
  [[nodiscard]] IlWriteOutcome Write(int number, int code, MonotonicNs now);

  [[nodiscard]] int decimals() const { return type_.decimals; }

 private:
  [[nodiscard]] double CountsOf(const trial::HeadReading& reading) const;
  void ShiftZero(int number, int code, MonotonicNs now);

  MovingHead head_;
  const dl_rs1a::Head& type_;
  bool is_main_;
  std::map<int, int> codes_;     ///< those that can be written, by data number
  std::map<int, int> requests_;  ///< last written to 001 and 002
  double zero_counts_ = 0;       ///< whole; subtracted from readings
  MonotonicNs settled_at_ = 0;
};

/// What the analog output of an amplifier with this head shows for `displacement_m`, in V
/// (AnalogOutput), without the amplifier's error; 5.5 V beyond the measuring range.
[[nodiscard]] double AnalogVolts(const trial::SensorHead& head, double displacement_m);

/// Errors (Cause::kUsage): a sampling cycle or averaging that an IL-1000 does not have, with those
/// it has.
[[nodiscard]] Result<void> ValidateIlHead(const trial::SensorHead& head);

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
  std::string (*format_analog)(int mv);                  ///< as SR carries it
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

/// How an emulated DL-RS1A is set up. The times are the maker's maxima for one amplifier; the
/// refresh of the IL series is not printed, its siblings (IB, GT-70A) say 7 ms.
struct DlRs1aSetup {
  int baud = dl_rs1a::kBauds.front();
  MovingHead head{};                                   ///< an IL-030 (trial::Il030())
  MonotonicNs processing_ns = dl_rs1a::kProcessingNs;  ///< T4 of M0 and MS
  MonotonicNs direct_processing_ns = 13'000'000;       ///< T4 of SR; SW takes 14 ms
  MonotonicNs refresh_ns = dl_rs1a::kRefreshNs;  ///< T2: the buffer is refilled at k * refresh
  FaultPlan faults{};
  std::vector<MovingHead> expansions{};  ///< of the amplifiers 01, 02, ...
  bool is_writable = false;              ///< the R/W switch stands on W
};

/// Errors (Cause::kUsage): a rate, sampling cycle or averaging that the unit or the IL-1000
/// amplifier does not have, with the ones they have; more than 15 amplifiers.
[[nodiscard]] Result<void> Validate(const DlRs1aSetup& setup);

/// A Keyence DL-RS1A with an IL-1000 amplifier (number 00) and its expansions.
///
/// Understands M0, MS, SR, SW and AW. With its R/W switch on R (the default) SW and AW are refused
/// with 67. Data: those of IlAmplifier; others are refused with 22.
///
/// Source: Keyence, DL-RS1A User's Manual (IL Edition), p. 6-15.
class DlRs1aUnit final : public DlUnit {
 public:
  /// `setup` has passed Validate().
  explicit DlRs1aUnit(const DlRs1aSetup& setup);
};

/// How an emulated DL-EN1 is set up. How long it takes for an answer is not in the manual.
struct DlEn1Setup {
  std::vector<MovingHead> heads{};  ///< of the amplifiers 01, 02, ...; at least one
  MonotonicNs processing_ns = 1'000'000;
  MonotonicNs refresh_ns = dl_en1::kRefreshNs;  ///< the maker's for one amplifier
  bool is_writable = false;
  FaultPlan faults{};
};

/// Errors (Cause::kUsage): as of DlRs1aSetup.
[[nodiscard]] Result<void> Validate(const DlEn1Setup& setup);

/// A Keyence DL-EN1 with IL amplifiers from number 01: M0, MS, SR, SW and FR, values without a
/// point. Bytes cross its wire as fast as 100 Mbit/s carry them.
///
/// Source: Keyence, DL-EN1 User's Manual (633GB), chapters 5 and 6. How SR carries the codes of
/// settings is not quite clear there: here as sign and nine digits, like all numbers; a product
/// name as text.
class DlEn1Unit final : public DlUnit {
 public:
  /// `setup` has passed Validate().
  explicit DlEn1Unit(DlEn1Setup setup);
};

}  // namespace haptometer::acquire::emulator
