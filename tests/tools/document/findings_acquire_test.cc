// What sensors find, in sentences: one for each kind.
#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "tools/document/document.h"

namespace haptometer::document {
namespace {

using enum acquire::FindingKind;

struct Case {
  acquire::FindingKind kind;
  std::vector<FindingNumber> numbers;
  std::string sentence;
};

const std::vector<Case> kCases{
    {kUnitRate,
     {{"device", "DL-RS1A"},
      {"rate_hz", 122.45},
      {"observable_hz", 19.53},
      {"baud", 38400},
      {"new_rate_hz", 50.0}},
     "a DL-RS1A at 38400 baud gives readings at 122.5 Hz at most, new ones at 50 Hz: motion up to "
     "19.53 Hz can be observed (rate / 2.56)"},
    {kUnitTooSlow,
     {{"device", "DL-EN1"}, {"rate_hz", 128.2}, {"needed_hz", 1280.0}},
     "20-500 Hz cannot be observed through a DL-EN1: it gives readings at 128.2 Hz at most and "
     "1280 Hz are needed; record the amplifier's analog output with a DAQ, or a head that sends "
     "lines by itself (--sensor stream)"},
    {kLkgRate,
     {{"baud", 9600}, {"rate_hz", 64.0}, {"observable_hz", 25.0}},
     "an LK-G at 9600 baud gives readings at less than 64 Hz: motion up to 25 Hz at best can be "
     "observed (rate / 2.56); its data storage and its analog output are faster"},
    {kLinesRate,
     {{"baud", 921600}, {"characters", 9}, {"rate_hz", 10240.0}, {"observable_hz", 4000.0}},
     "921600 baud carry lines of 9 characters at 10240 Hz at most: motion up to 4000 Hz can be "
     "observed if the sensor sends that fast (rate / 2.56)"},
    {kLinesTooSlow,
     {{"needed_hz", 1280.0}},
     "20-500 Hz needs lines at 1280 Hz: set the sensor to a higher baud rate"},
    {kLinesNumbered,
     {{"last", 99}},
     "the lines are numbered 0 to 99: the number of lost lines is exact up to 99 in a row"},
    {kStatedRate,
     {{"rate_hz", 1000.0}, {"observable_hz", 390.6}, {"half_rate_hz", 500.0}},
     "rows at 1000 Hz, as stated: motion up to 390.6 Hz can be observed (rate / 2.56) if nothing "
     "above 500 Hz reaches the converter"},
    {kRegistersRate,
     {{"profile", "om70"},
      {"baud", 57600},
      {"registers", 5},
      {"wire_s", 4.93e-3},
      {"rate_hz", 203.0},
      {"observable_hz", 79.2}},
     "om70 at 57600 baud: 5 registers take 4.93 ms on the wire, readings at 203 Hz at most: motion "
     "up to 79.2 Hz can be observed (rate / 2.56)"},
    {kRegistersTooSlow,
     {{"rate_hz", 285.7}, {"needed_hz", 1280.0}},
     "20-500 Hz cannot be observed over Modbus RTU at any baud rate: two silent intervals of 1.75 "
     "ms leave readings at 285.7 Hz and 1280 Hz are needed; use the sensor's own stream (--sensor "
     "stream) or its analog output with a DAQ"},
    {kProfileRate,
     {{"profile", "om70"}, {"rate_hz", 1000.0}, {"observable_hz", 390.6}},
     "om70 measures at 1000 Hz: motion up to 390.6 Hz can be observed (rate / 2.56)"},
    {kProfileRateUnknown,
     {{"profile", "om70"}},
     "the rate at which om70 measures is not known: motion can be observed up to that rate / 2.56; "
     "the rate of replies does not show it"},
    {kLatencyTimer,
     {{"port", "ttyUSB3"}, {"latency_s", 0.016}, {"rate_hz", 41.4}, {"rate_at_1_ms_hz", 109.1}},
     "the adapter keeps short replies for 16 ms: readings at 41.4 Hz at most in place of 109.1 Hz; "
     "set 1 ms with: echo 1 | sudo tee /sys/bus/usb-serial/devices/ttyUSB3/latency_timer"},
    {kSettingChanged,
     {{"setting", "sampling"}, {"before", "1ms"}, {"after", "0.33ms"}},
     "changed sampling 1ms -> 0.33ms"},
    {kNotSettled,
     {},
     "the amplifier has shown no value since its settings were changed: check the target"},
    {kAveragingCorner,
     {{"averages", 16}, {"sampling_s", 1e-3}, {"corner_hz", 27.69}},
     "the amplifier averages 16 samples of 1 ms: a vibration at 27.69 Hz is 3 dB too small"},
    {kDifferenceFilter,
     {},
     "the amplifier's difference-count filter is on: it suppresses small steps"},
    {kHighPassFilter, {{"corner_hz", 10.0}}, "the amplifier's high-pass filter at 10 Hz is on"},
    {kHold,
     {{"hold", "peak"}},
     "the amplifier holds (peak): readings are not the present displacement"},
    {kAmplifierError, {{"flags", "00004"}}, "the amplifier reports an error (flags 00004)"},
    {kSettingsNotRead,
     {},
     "the controller's sampling, averaging and filters are not read: note them with --label"},
    {kOtherSettings,
     {},
     "the device came back with another averaging, sampling period or head, which this recording's "
     "header does not hold for: begin a new recording"},
    {kTcpProfile,
     {{"profile", "om70"}},
     "the profile om70 is for TCP, and the port is a serial one"},
    {kNoCheckRequest,
     {{"profile", "om70"}, {"longest_reply_s", 1.0}},
     "om70 does not answer the check request of its profile with registers: replies later than 1 s "
     "cannot be distinguished from the next (longest_reply_s, check_address and check_count)"},
    {kIdealSensor,
     {{"rate_hz", 1e4}},
     "the scene has no sensor: an ideal one on the skin at 10000 Hz is assumed"},
    {kHeadingLines,
     {{"lines", 2}, {"first", "volts"}},
     "2 lines before the first row are not rows: \"volts\""},
    {kLinesTooSoon,
     {{"lines", 100}, {"elapsed_s", 0.5}, {"baud", 9600}, {"wire_s", 1.0}},
     "100 lines came in 500 ms, and 9600 baud carry them in 1 s at least: the port is not a serial "
     "line of this rate, or the sensor has another baud rate"},
    {kRowRateDiffers,
     {{"rate_hz", 1e4}, {"elapsed_s", 1.65}, {"stated_hz", 5e3}},
     "rows came at 10000 Hz in 1.65 s by the clock of this computer, and 5000 Hz is stated: if the "
     "source sends them as it measures them, --rate or --channels is wrong, and with it every "
     "frequency"},
    {kSurplusReplies,
     {{"replies", 3}},
     "replies to requests that had been answered were discarded (3): the device answers more than "
     "once"},
    {kRepliesTooSoon,
     {{"too_soon", 3}, {"replies", 9}, {"wire_s", 0.01667}, {"rate_hz", 60.0}},
     "3 of 9 replies came sooner than the stated baud rate carries request and reply (16.67 ms): "
     "the port is not a serial line of this rate, or the device has another baud rate; readings "
     "were taken at 60 Hz at most, as the stated rate allows"},
    {kWireErrors, {{"errors", "1 timeout"}}, "errors on the wire: 1 timeout"},
    {kReplayCutShort, {}, "the trial was cut short"},
    {kReplayLosses,
     {{"losses", 1}, {"rows_lost", 10}},
     "1 part of the trial cannot be read, with 10 rows"},
    {kFellSilent,
     {{"last_reading_s", 2.498}, {"length_s", 8.0}},
     "the last reading came at 2.498 s of 8 s: the source stopped sending, or sent "
     "nothing that is a reading"},
    {kOtherForm,
     {{"replies", 12}, {"example", "M0,+001.23"}},
     "replies in another form than at the start are no readings (12, the first \"M0,+001.23\"): "
     "the "
     "decimals or the amplifiers were changed; begin a new recording"},
    {kEcho,
     {{"echoes", 180}},
     "requests come back on the wire (180), as through an RS-485 adapter that receives what it "
     "sends, or where its transmit and receive lines are joined; they were ignored"},
    {kCanAnswer,
     {{"rate_hz", 10240.0}, {"limit", "the wire"}, {"observable_hz", 4000.0}},
     "new readings at 10240 Hz (the wire) show motion up to 4000 Hz"},
    {kRateTooLow,
     {{"rate_hz", 1279.0},
      {"limit", "the wire"},
      {"observable_hz", 499.6},
      {"asked_hz", 500.0},
      {"needed_hz", 1280.0}},
     "new readings at 1279 Hz (the wire) show motion up to 499.6 Hz; 500 Hz needs 1280 Hz"},
    {kAveragingTooLong,
     {{"averages", 4}, {"sampling_s", 0.33e-3}, {"gain", 0.4421}, {"asked_hz", 500.0}},
     "4 averages at 0.33 ms leave 0.4421 of 500 Hz: set fewer"},
    {kStepsTooLarge,
     {{"step_m", 0.01}, {"wanted_m", 1e-6}},
     "the steps are 10 mm; 1 um are required"},
    {kRouteAnswers,
     {{"record_s", 18.4}, {"half_interval", 0.00998}},
     "a record of 18.4 s has an interval of +-0.998 %"},
    {kNoiseNotStated,
     {},
     "its rate is sufficient, but its maker states no noise, so no length can be promised: measure "
     "it with --check and give --noise"},
    {kReadingsTooOld,
     {{"uncertainty_s", 5.967e-3}, {"upper_hz", 18.0}, {"limit_s", 5.556e-3}},
     "the time of a reading is known to 5.967 ms only; 18 Hz needs 5.556 ms"},
    {kFloorTooHigh,
     {{"half_interval", 0.0118}, {"accuracy", 0.01}, {"limit", "the calibration"}},
     "the interval is +-1.18 % at any length, because of the calibration; +-1 % is wanted"},
    {kImagesFold,
     {{"daq_rate_hz", 3000.0},
      {"image_hz", 2805.303},
      {"folded_hz", 194.697},
      {"relative", 0.0802},
      {"others", 1},
      {"better_hz", 10000.0}},
     "the amplifier's output is a staircase: at 3000 Hz the DAQ folds its image at 2805 Hz to "
     "194.7 Hz, 8.02 % of the drive's amplitude, and 1 smaller one; sample at 10000 Hz "
     "(--daq-rate), or put a low-pass before the DAQ"},
    {kUnseenByAnalyze,
     {{"relative", 0.0032}},
     "values are repeated until the unit renews them, which takes 0.32 % off the RMS: the "
     "interval of analyze does not contain that, the length stated here does"},
    {kPromiseRests,
     {{"coverage", 1.959964}, {"calibration", 0.003}},
     "accuracy is half of the 95 % interval that analyze prints (coverage factor 1.96), as a part "
     "of the RMS; it is promised for a drive that is on throughout, white noise, a target without "
     "tremor, and analyze --floor where a record without drive is stated, with a calibration of "
     "relative standard uncertainty 0.3 %"},
};

TEST(FindingsOfSensors, EachKindHasItsSentence) {
  std::set<std::string_view> names;
  for (std::size_t k = 0; k < kCases.size(); ++k) {
    const auto& [kind, numbers, sentence] = kCases[k];
    EXPECT_EQ(static_cast<std::size_t>(kind), k) << "every kind once, in their order";
    EXPECT_EQ(Fill(SentenceOf(kind).text, numbers), sentence);
    EXPECT_TRUE(names.insert(SentenceOf(kind).kind).second) << SentenceOf(kind).kind;
  }
  EXPECT_EQ(kCases.size(), static_cast<std::size_t>(kPromiseRests) + 1);
}

// 10240 has five digits, of which four are exact
TEST(FindingsOfSensors, SayTheSmallestRmsWhereItIsKnown) {
  EXPECT_EQ(Fill(SentenceOf(kCanAnswer).text, {{"rate_hz", 3000.0},
                                               {"limit", "the unit"},
                                               {"observable_hz", 1172.0},
                                               {"noise_m", 2e-6},
                                               {"smallest_m", 1.2e-6},
                                               {"record_s", 10.0}}),
            "new readings at 3000 Hz (the unit) show motion up to 1172 Hz; with noise of 2 um in "
            "the band an RMS of 1.2 um can be reported to 10 % in 10 s");
}

}  // namespace
}  // namespace haptometer::document
