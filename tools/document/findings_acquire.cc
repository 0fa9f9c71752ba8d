#include <array>

#include "tools/document/document.h"

// What sensors find, in words (acquire/findings.h).

namespace haptometer::document {
namespace {

using acquire::FindingKind;

// the last kind sets the number: a sentence without a kind does not compile
constexpr std::size_t kKinds = static_cast<std::size_t>(FindingKind::kPromiseRests) + 1;

// in the order of the kinds
constexpr std::array<Sentence, kKinds> kSentences{{
    // what a wire carries
    {"unit-rate",
     "a {device}[ at {baud} baud] gives readings at {rate_hz} at most[, new ones at "
     "{new_rate_hz}]: motion up to {observable_hz} can be observed (rate / 2.56)"},
    {"unit-too-slow",
     "20-500 Hz cannot be observed through a {device}: it gives readings at {rate_hz} at most and "
     "{needed_hz} are needed; record the amplifier's analog output with a DAQ, or a head that "
     "sends lines by itself (--sensor stream)"},
    {"lkg-rate",
     "an LK-G at {baud} baud gives readings at less than {rate_hz}: motion up to {observable_hz} "
     "at best can be observed (rate / 2.56); its data storage and its analog output are faster"},
    {"lines-rate",
     "{baud} baud carry lines of {characters} characters at {rate_hz} at most: motion up to "
     "{observable_hz} can be observed if the sensor sends that fast (rate / 2.56)"},
    {"lines-too-slow",
     "20-500 Hz needs lines at {needed_hz}: set the sensor to a higher baud rate"},
    {"lines-numbered",
     "the lines are numbered 0 to {last}: the number of lost lines is exact up to {last} in a "
     "row"},
    {"stated-rate",
     "rows at {rate_hz}, as stated: motion up to {observable_hz} can be observed (rate / 2.56) if "
     "nothing above {half_rate_hz} reaches the converter"},
    {"registers-rate",
     "{profile} at {baud} baud: {registers} registers take {wire_s} on the wire, readings at "
     "{rate_hz} at most[, new ones at {new_rate_hz}]: motion up to {observable_hz} can be observed "
     "(rate / 2.56)"},
    {"registers-too-slow",
     "20-500 Hz cannot be observed over Modbus RTU at any baud rate: two silent intervals of 1.75 "
     "ms leave readings at {rate_hz} and {needed_hz} are needed; use the sensor's own stream "
     "(--sensor stream) or its analog output with a DAQ"},
    {"profile-rate",
     "{profile} measures at {rate_hz}: motion up to {observable_hz} can be observed (rate / 2.56)"},
    {"profile-rate-unknown",
     "the rate at which {profile} measures is not known: motion can be observed up to that rate / "
     "2.56; the rate of replies does not show it"},
    {"latency-timer",
     "the adapter keeps short replies for {latency_s}: readings at {rate_hz} at most in place of "
     "{rate_at_1_ms_hz}; set 1 ms with: echo 1 | sudo tee "
     "/sys/bus/usb-serial/devices/{port}/latency_timer"},

    // settings of the device
    {"setting-changed", "changed {setting} {before} -> {after}"},
    {"not-settled",
     "the amplifier has shown no value since its settings were changed: check the target"},
    {"averaging-corner",
     "the amplifier averages {averages} samples of {sampling_s}: a vibration at {corner_hz} is 3 "
     "dB too small"},
    {"difference-filter",
     "the amplifier's difference-count filter is on: it suppresses small steps"},
    {"high-pass-filter", "the amplifier's high-pass filter at {corner_hz} is on"},
    {"hold", "the amplifier holds ({hold}): readings are not the present displacement"},
    {"amplifier-error", "the amplifier reports an error (flags {flags})"},
    {"settings-not-read",
     "the controller's sampling, averaging and filters are not read: note them with --label"},
    {"other-settings",
     "the device came back with another averaging, sampling period or head, which this recording's "
     "header does not hold for: begin a new recording"},
    {"tcp-profile", "the profile {profile} is for TCP, and the port is a serial one"},
    {"no-check-request",
     "{profile} does not answer the check request of its profile with registers: replies later "
     "than {longest_reply_s} cannot be distinguished from the next (longest_reply_s, check_address "
     "and check_count)"},
    {"ideal-sensor", "the scene has no [sensor]: an ideal one on the skin at {rate_hz} is assumed"},

    // what was observed during a recording
    {"heading-lines", "{lines} lines before the first row are not rows: \"{first}\""},
    {"lines-too-soon",
     "{lines} lines came in {elapsed_s}, and {baud} baud carry them in {wire_s} at least: the port "
     "is not a serial line of this rate, or the sensor has another baud rate"},
    {"row-rate-differs",
     "rows came at {rate_hz} in {elapsed_s} by the clock of this computer, and {stated_hz} is "
     "stated: if the source sends them as it measures them, --rate or --channels is wrong, and "
     "with it every frequency"},
    {"surplus-replies",
     "replies to requests that had been answered were discarded ({replies}): the device answers "
     "more than once"},
    {"replies-too-soon",
     "{too_soon} of {replies} replies came sooner than the stated baud rate carries request and "
     "reply ({wire_s}): the port is not a serial line of this rate, or the device has another baud "
     "rate; readings were taken at {rate_hz} at most, as the stated rate allows"},
    {"wire-errors", "errors on the wire: {errors}"},
    {"replay-cut-short", "the trial was cut short"},
    {"replay-losses",
     "{losses} part{losses s} of the trial cannot be read[, with {rows_lost} row{rows_lost s}]"},
    {"fell-silent",
     "the last reading came at {last_reading_s} of {length_s}: the source stopped sending, or sent "
     "nothing that is a reading"},
    {"other-form",
     "replies in another form than at the start are no readings ({replies}, the first "
     "\"{example}\"): "
     "the decimals or the amplifiers were changed; begin a new recording"},
    {"echo",
     "requests come back on the wire ({echoes}), as through an RS-485 adapter that receives what "
     "it "
     "sends, or where its transmit and receive lines are joined; they were ignored"},

    // whether a sensor can answer a question
    {"can-answer",
     "new readings at {rate_hz} ({limit}) show motion up to {observable_hz}[; with noise of "
     "{noise_m} in the band an RMS of {smallest_m} can be reported to 10 % in {record_s}]"},
    {"rate-too-low",
     "new readings at {rate_hz} ({limit}) show motion up to {observable_hz}; {asked_hz} needs "
     "{needed_hz}"},
    {"averaging-too-long",
     "{averages} averages at {sampling_s} leave {gain} of {asked_hz}: set fewer"},
    {"steps-too-large", "the steps are {step_m}; {wanted_m} are required"},

    // whether a route can answer to an accuracy
    {"route-answers", "a record of {record_s} has an interval of +-{half_interval %}"},
    {"noise-not-stated",
     "its rate is sufficient, but its maker states no noise, so no length can be promised: measure "
     "it with --check and give --noise"},
    {"readings-too-old",
     "the time of a reading is known to {uncertainty_s} only; {upper_hz} needs {limit_s}"},
    {"floor-too-high",
     "the interval is +-{half_interval %} at any length, because of {limit}; +-{accuracy %} is "
     "wanted"},
    {"images-fold",
     "the amplifier's output is a staircase: at {daq_rate_hz} the DAQ folds its image at "
     "{image_hz} to {folded_hz}, {relative %} of the drive's amplitude[, and {others} smaller "
     "one{others s}]; sample at {better_hz} (--daq-rate), or put a low-pass before the DAQ"},
    {"unseen-by-analyze",
     "values are repeated until the unit renews them, which takes {relative %} off the RMS: "
     "the "
     "interval of analyze "
     "does not contain that, the length stated here does"},
    {"promise-rests",
     "accuracy is half of the 95 % interval that analyze prints (coverage factor {coverage}), as a "
     "part of the RMS; it is promised for a drive that is on throughout, white noise, a target "
     "without tremor, and analyze --floor where a record without drive is stated[, with a "
     "calibration of relative standard uncertainty "
     "{calibration %}]"},
}};

}  // namespace

Sentence SentenceOf(FindingKind kind) { return kSentences.at(static_cast<std::size_t>(kind)); }

}  // namespace haptometer::document
