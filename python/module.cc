// haptometer._native: what the package haptometer (python/haptometer) is made of. Everything that
// computes runs without Python's lock. Errors of the outside world become haptometer's exceptions
// in the package.
#include <fmt/format.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <toml++/toml.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <future>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "base/band.h"
#include "base/error.h"
#include "dsp/filter/butterworth.h"
#include "dsp/filter/zero_phase.h"
#include "dsp/spectrum/sine_fit.h"
#include "dsp/spectrum/tone.h"
#include "dsp/spectrum/welch.h"
#include "tools/document/document.h"
#include "tools/document/render.h"
#include "tools/simulate/simulated_trial.h"
#include "tools/verb_call.h"
#include "trial/import/read_recording.h"
#include "trial/record.h"

namespace py = pybind11;

namespace haptometer::python {
namespace {

using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

// an Error on its way to Python: (exit status, text)
struct Raised : std::exception {
  explicit Raised(const Error& error) : status(ExitStatus(error.cause)), text(error.Text()) {}
  const char* what() const noexcept override { return text.c_str(); }
  int status;
  std::string text;
};

template <typename T>
T ValueOf(Result<T> result) {
  if (!result) throw Raised(result.error());
  return *std::move(result);
}

// Without Python's lock. Where the interpreter ends meanwhile, it ends a thread that wants the lock
// back by unwinding it, so that this destructor throws, which that of py::gil_scoped_release must
// not.
class WithoutLock {
 public:
  WithoutLock() : state_(PyEval_SaveThread()) {}
  ~WithoutLock() noexcept(false) { PyEval_RestoreThread(state_); }
  WithoutLock(const WithoutLock&) = delete;
  WithoutLock& operator=(const WithoutLock&) = delete;

 private:
  PyThreadState* state_;
};

// --- arrays ---

// a view of memory that `owner` keeps, which cannot be written
template <typename T>
py::array ViewOf(const T* data, std::size_t size, const py::object& owner) {
  py::array_t<T> view(static_cast<py::ssize_t>(size), data, owner);
  view.attr("setflags")(py::arg("write") = false);
  return view;
}

// an array that owns the vector's memory
py::array ArrayOf(std::vector<double> values) {
  auto kept = std::make_unique<std::vector<double>>(std::move(values));
  const double* const data = kept->data();
  const std::size_t size = kept->size();
  const py::capsule owner(kept.release(),
                          [](void* vector) { delete static_cast<std::vector<double>*>(vector); });
  return py::array_t<double>(static_cast<py::ssize_t>(size), data, owner);
}

std::span<const double> SpanOf(const Numbers& numbers) {
  if (numbers.ndim() != 1) throw py::value_error("the array is to have one dimension");
  return {numbers.data(), static_cast<std::size_t>(numbers.size())};
}

// --- verbs and their documents ---

struct Answer {
  int status = 0;
  std::string json{};
  std::string errors{};
  std::shared_ptr<const document::Document> document{};
};

py::object ObjectOf(const document::Value& value) {
  return std::visit(
      [](const auto& known) -> py::object {
        using T = std::decay_t<decltype(known)>;
        if constexpr (std::is_same_v<T, std::monostate>) {
          return py::none();
        } else if constexpr (std::is_same_v<T, document::Range>) {
          return py::make_tuple(known.lower, known.upper);
        } else {
          return py::cast(known);
        }
      },
      static_cast<const document::AnyValue&>(value));
}

py::dict ItemOf(const document::Item& item) {
  py::dict made;
  made["name"] = item.name;
  made["label"] = item.label;
  made["unit"] = std::string(item.unit.symbol);
  made["value"] = item.value.IsKnown() ? ObjectOf(item.value) : py::none();
  made["u"] = item.standard_uncertainty;
  made["interval"] = item.interval
                         ? py::object(py::make_tuple(item.interval->lower, item.interval->upper))
                         : py::none();
  made["at_most"] = item.at_most;
  made["note"] = item.note;
  return made;
}

py::dict SectionOf(const document::Section& section) {
  py::list items;
  for (const document::Item& item : section.items) {
    if (!item.name.empty()) items.append(ItemOf(item));
  }
  py::list sections;
  for (const document::Section& within : section.sections) sections.append(SectionOf(within));
  py::dict made;
  made["name"] = std::string(section.name);
  made["heading"] = section.heading;
  made["is_list"] = section.shape != document::Section::Shape::kObject;
  made["is_known"] = section.is_known;
  made["items"] = items;
  made["sections"] = sections;
  return made;
}

py::dict SeriesOf(const plot::Series& series) {
  py::dict made;
  made["title"] = series.title;
  made["is_line"] = series.style.mark == plot::Mark::kLines;
  made["is_box"] = series.style.mark == plot::Mark::kBoxes;
  made["rgb"] = series.style.colour.rgb;
  made["width"] = series.style.width;
  made["x"] = ArrayOf(series.x);
  made["y"] = ArrayOf(series.y);
  made["y_error"] = ArrayOf(series.y_error);
  return made;
}

py::dict PanelOf(const plot::Panel& panel) {
  py::list series;
  for (const plot::Series& one : panel.series) series.append(SeriesOf(one));
  py::list shades;
  for (const plot::Shade& shade : panel.shades) {
    shades.append(py::make_tuple(shade.title, shade.colour.rgb, shade.intervals));
  }
  py::list ticks;
  for (const plot::Tick& tick : panel.ticks) ticks.append(py::make_tuple(tick.x, tick.name));
  const bool both = panel.log_axes == plot::LogAxes::kBoth;
  py::dict made;
  made["title"] = panel.title;
  made["x_label"] = panel.x_label;
  made["y_label"] = panel.y_label;
  made["x_is_log"] = both || panel.log_axes == plot::LogAxes::kX;
  made["y_is_log"] = both || panel.log_axes == plot::LogAxes::kY;
  made["x_range"] = panel.x_range;
  made["y_range"] = panel.y_range;
  made["equal_axes"] = panel.equal_axes;
  made["series"] = series;
  made["shades"] = shades;
  made["ticks"] = ticks;
  return made;
}

// the panels of all figures, with the captions of their figures
py::list PanelsOf(const document::Document& document) {
  py::list made;
  for (const document::Section* section : document::AllSections(document.root)) {
    for (const document::Figure& figure : section->figures) {
      for (const plot::Panel& panel : figure.panels) made.append(PanelOf(panel));
    }
  }
  return made;
}

std::string Html(const Answer& answer) {
  const WithoutLock released;
  return ValueOf(document::HtmlOf(*answer.document));
}

std::string Text(const Answer& answer) {
  const WithoutLock released;
  return document::TextOf(*answer.document, document::Detail::kAll);
}

// The verb runs on a thread of its own; this one looks at Python's signals ten times a second.
// After Ctrl-C the verb is told to end until it has, from when it is its turn.
Answer Call(const std::vector<std::string>& words, bool has_figures) {
  constexpr std::chrono::milliseconds kLook{100};
  std::atomic<bool> has_begun = false;
  bool is_interrupted = false;
  tools::VerbAnswer answer;
  {
    const WithoutLock released;
    auto running = std::async(std::launch::async, [&] {
      return tools::CallVerb(words, has_figures, [&] { has_begun = true; });
    });
    while (running.wait_for(kLook) != std::future_status::ready) {
      if (!is_interrupted) {
        const py::gil_scoped_acquire acquired;
        is_interrupted = PyErr_CheckSignals() != 0;
      }
      if (is_interrupted && has_begun) tools::InterruptVerb();
    }
    answer = running.get();
  }
  if (is_interrupted) throw py::error_already_set();
  std::shared_ptr<const document::Document> document;
  if (answer.document) {
    document = std::make_shared<const document::Document>(*std::move(answer.document));
  }
  return {answer.status, std::move(answer.output), std::move(answer.errors), std::move(document)};
}

// --- records ---

using RecordPointer = std::shared_ptr<trial::Record>;

RecordPointer Read(const std::string& path, const trial::ImportOptions& options) {
  const WithoutLock released;
  RecordPointer record;
  tools::BesideVerbs([&] {
    record = std::make_shared<trial::Record>(ValueOf(trial::ReadRecording(path, options)).record);
  });
  return record;
}

py::array TimesOf(const trial::Record& record) {
  std::vector<double> times_s;
  {
    const WithoutLock released;
    times_s.reserve(record.rows);
    for (const trial::Stretch& stretch : record.stretches) {
      for (std::size_t k = 0; k < stretch.rows; ++k) {
        times_s.push_back(stretch.start_s + static_cast<double>(k) / stretch.rate_hz);
      }
    }
  }
  return ArrayOf(std::move(times_s));
}

py::dict MetadataOf(const trial::Metadata& data) {
  py::dict made;
  made["source"] = data.source;
  made["sensor"] = data.sensor;
  made["head"] = data.head;
  made["sampling_s"] = data.sampling_s;
  made["averages"] = data.averages;
  made["hold"] = data.hold;
  made["nominal_rate_hz"] = data.nominal_rate_hz;
  made["laser_spot"] = data.laser_spot;
  made["drive_frequency_hz"] = data.drive_frequency_hz;
  made["drive_amplitude_v"] = data.drive_amplitude_v;
  made["tare_m"] = data.tare_m;
  made["utc_start"] = data.utc_start;
  made["host"] = data.host;
  made["command_line"] = data.command_line;
  made["fields"] = data.fields;
  made["notes"] = data.notes;
  return made;
}

py::list SegmentsOf(const trial::Record& record) {
  py::list made;
  for (const trial::Stretch& s : record.stretches) {
    made.append(py::make_tuple(s.first_row, s.rows, s.start_s, s.rate_hz, s.time_uncertainty_s));
  }
  return made;
}

// a channel of `record`, which the arrays keep alive
py::dict ChannelOf(const RecordPointer& record, std::size_t number) {
  const trial::Channel& channel = record->channels.at(number);
  const py::object owner = py::cast(record);
  py::dict made;
  made["name"] = channel.name;
  made["role"] = std::string(Name(channel.role));
  made["unit"] = channel.unit;
  made["values"] = ViewOf(channel.values.data(), channel.values.size(), owner);
  made["statuses"] = ViewOf(reinterpret_cast<const std::uint8_t*>(channel.statuses.data()),
                            channel.statuses.size(), owner);
  made["range"] = py::make_tuple(channel.range_min, channel.range_max);
  made["resolution"] = channel.resolution;
  return made;
}

trial::ChannelRole RoleOfUnit(const std::string& unit) {
  if (unit == "m") return trial::ChannelRole::kDisplacement;
  if (unit == "V") return trial::ChannelRole::kVoltage;
  return unit == "A" ? trial::ChannelRole::kCurrent : trial::ChannelRole::kOther;
}

// (name, unit, values) of each channel, at one rate; a value that is not finite is not measured
RecordPointer MakeRecord(const std::vector<std::tuple<std::string, std::string, Numbers>>& channels,
                         double rate_hz, const std::map<std::string, std::string>& labels) {
  auto record = std::make_shared<trial::Record>();
  for (const auto& [name, unit, numbers] : channels) {
    const std::span<const double> values = SpanOf(numbers);
    record->rows = values.size();
    trial::Channel& channel = record->channels.emplace_back();
    channel.name = name;
    channel.unit = unit;
    channel.role = RoleOfUnit(unit);
    channel.values.assign(values.begin(), values.end());
    for (const double value : values) {
      channel.statuses.push_back(std::isfinite(value) ? trial::SampleStatus::kOk
                                                      : trial::SampleStatus::kInvalid);
    }
  }
  record->stretches = {{.rows = record->rows, .rate_hz = rate_hz}};
  record->metadata.source = "imported: arrays";
  record->metadata.nominal_rate_hz = rate_hz;
  record->metadata.labels = labels;
  return record;
}

void Save(const trial::Record& record, const std::string& path, bool overwrite) {
  const WithoutLock released;
  tools::BesideVerbs([&] {
    const auto done = tools::WriteSimulatedTrial(path, record, overwrite);
    if (!done) throw Raised(done.error());
  });
}

// --- signals ---

// a filter needs memory for its ringing on either side of what it filters
void RefuseLongRinging(const dsp::FilterDesign& design) {
  constexpr double kMostSamples = 1 << 25;
  // exp(-decay t) = 1e-18
  const double samples = std::log(1e18) * design.rate_hz / dsp::SlowestDecayPerS(design);
  if (samples <= kMostSamples) return;
  throw Raised(
      {Cause::kUsage, "band",
       fmt::format("is so narrow, or begins so low, that its filter rings for {:.3g} samples",
                   samples),
       fmt::format("a wider band rings for {:.3g} at most", kMostSamples)});
}

py::array BandPass(const Numbers& x, double rate_hz, const dsp::BandPass& band, int threads) {
  const std::span<const double> signal = SpanOf(x);
  py::array_t<double> filtered(x.size());
  const std::span<double> out(filtered.mutable_data(), signal.size());
  {
    const WithoutLock released;
    const auto design = ValueOf(dsp::DesignBandPass(band, rate_hz));
    RefuseLongRinging(design);
    dsp::FilterZeroPhase(design, signal, out, threads);
  }
  return filtered;
}

py::dict Welch(const Numbers& x, const dsp::WelchOptions& options) {
  const std::span<const double> signal = SpanOf(x);
  dsp::PowerSpectrum spectrum;
  {
    const WithoutLock released;
    spectrum = ValueOf(dsp::WelchSpectrum(signal, options));
  }
  py::dict made;
  made["resolution_hz"] = spectrum.grid.resolution_hz;
  made["noise_bandwidth_hz"] = spectrum.grid.noise_bandwidth_hz;
  made["segments"] = spectrum.grid.segments;
  made["degrees_of_freedom"] = spectrum.grid.degrees_of_freedom;
  made["lower_factor"] = spectrum.grid.lower_factor;
  made["upper_factor"] = spectrum.grid.upper_factor;
  made["density"] = ArrayOf(std::move(spectrum.density));
  return made;
}

py::dict DictOf(const dsp::SineFit& fit) {
  py::dict made;
  made["frequency_hz"] = fit.frequency_hz;
  made["amplitude"] = fit.amplitude;
  made["phase_rad"] = fit.phase_rad;
  made["offset"] = fit.offset;
  made["residual_rms"] = fit.residual_rms;
  made["frequency_uncertainty_hz"] = fit.frequency_uncertainty_hz;
  made["amplitude_uncertainty"] = fit.amplitude_uncertainty;
  made["phase_uncertainty_rad"] = fit.phase_uncertainty_rad;
  made["degrees_of_freedom"] = fit.degrees_of_freedom;
  made["converged"] = fit.converged;
  return made;
}

py::dict SineFitAt(const Numbers& x, const dsp::SineFitOptions& options, double frequency_hz) {
  const std::span<const double> signal = SpanOf(x);
  dsp::SineFit fit;
  {
    const WithoutLock released;
    fit = dsp::FitSineAt(signal, options, frequency_hz);
  }
  return DictOf(fit);
}

std::optional<py::dict> StrongestTone(const Numbers& x, const dsp::ToneSearch& search) {
  const std::span<const double> signal = SpanOf(x);
  std::optional<dsp::SineFit> fit;
  {
    const WithoutLock released;
    fit = dsp::StrongestTone(signal, search);
  }
  if (!fit) return std::nullopt;
  return DictOf(*fit);
}

// --- scenes ---

// what `from` has takes the place of what `into` has under the same keys
void Merge(toml::table& into, const toml::table& from) {
  for (const auto& [key, value] : from) {
    toml::table* const inner = into[key].as_table();
    if (inner != nullptr && value.is_table()) {
      Merge(*inner, *value.as_table());
    } else {
      into.insert_or_assign(key, value);
    }
  }
}

// paths under the key `file` begin at the scene's folder; the new text may stand in another one
void MakeFilesAbsolute(toml::table& table, const std::filesystem::path& folder) {
  for (auto&& [key, value] : table) {
    if (value.is_table()) MakeFilesAbsolute(*value.as_table(), folder);
    if (key == "file" && value.is_string()) {
      table.insert_or_assign(key, (folder / **value.as_string()).string());
    }
  }
}

toml::table Parsed(const std::string& text, const std::string& where) {
  try {
    return toml::parse(text);
  } catch (const toml::parse_error& error) {
    throw Raised({Cause::kUsage, where, std::string(error.description()), {}});
  }
}

// the scene's text with `changes`, lines of TOML, put in the place of what it has
std::string ChangedScene(const std::string& text, const std::string& folder,
                         const std::string& changes) {
  toml::table scene = Parsed(text, "scene");
  Merge(scene, Parsed(changes, "change of a scene"));
  MakeFilesAbsolute(scene, folder);
  std::ostringstream written;
  written << scene << '\n';
  return written.str();
}

}  // namespace
}  // namespace haptometer::python

PYBIND11_MODULE(_native, module) {
  using namespace haptometer;          // NOLINT(google-build-using-namespace): of this function
  using namespace haptometer::python;  // NOLINT(google-build-using-namespace)
  static const py::exception<Raised> error(module, "NativeError");
  // NOLINTNEXTLINE(performance-unnecessary-value-param): the signature that is asked for
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const Raised& raised) {
      PyErr_SetObject(error.ptr(), py::make_tuple(raised.status, raised.text).ptr());
    }
  });

  module.attr("DEFAULT_BAND") = py::make_tuple(kDefaultLowerHz, kDefaultUpperHz);
  py::class_<Answer>(module, "Answer")
      .def_readonly("status", &Answer::status)
      .def_readonly("json", &Answer::json)
      .def_readonly("errors", &Answer::errors)
      .def_property_readonly("has_document",
                             [](const Answer& answer) { return answer.document != nullptr; })
      .def("root", [](const Answer& answer) { return SectionOf(answer.document->root); })
      .def("panels", [](const Answer& answer) { return PanelsOf(*answer.document); })
      .def("text", &Text)
      .def("html", &Html);
  module.def("call", &Call, py::arg("words"), py::arg("has_figures"));

  py::class_<trial::Record, RecordPointer>(module, "Record")
      .def_readonly("rows", &trial::Record::rows)
      .def_property_readonly("timing",
                             [](const trial::Record& r) { return std::string(Name(r.timing)); })
      .def_property_readonly("labels", [](const trial::Record& r) { return r.metadata.labels; })
      .def_property_readonly("metadata",
                             [](const trial::Record& r) { return MetadataOf(r.metadata); })
      .def_property_readonly("channels", [](const trial::Record& r) { return r.channels.size(); })
      .def("channel", &ChannelOf)
      .def("segments", &SegmentsOf)
      .def("times", &TimesOf);
  module.def(
      "read",
      [](const std::string& path, const std::vector<std::string>& columns,
         std::optional<double> rate_hz) {
        return Read(path, {.columns = columns, .rate_hz = rate_hz});
      },
      py::arg("path"), py::arg("columns"), py::arg("rate_hz"));
  module.def("make_record", &MakeRecord, py::arg("channels"), py::arg("rate_hz"),
             py::arg("labels"));
  module.def("save", &Save, py::arg("record"), py::arg("path"), py::arg("overwrite"));

  module.def(
      "bandpass",
      [](const Numbers& x, double rate_hz, std::pair<double, double> band_hz, int order,
         bool each_corner, int threads) {
        const auto corners = each_corner ? dsp::Corners::kEach : dsp::Corners::kWhole;
        return BandPass(x, rate_hz, {order, band_hz.first, band_hz.second, corners}, threads);
      },
      py::arg("x"), py::arg("rate_hz"), py::arg("band_hz"), py::arg("order"),
      py::arg("each_corner"), py::arg("threads"));
  py::enum_<dsp::WindowShape>(module, "Window")
      .value("rectangular", dsp::WindowShape::kRectangular)
      .value("hann", dsp::WindowShape::kHann)
      .value("hamming", dsp::WindowShape::kHamming)
      .value("blackman-harris", dsp::WindowShape::kBlackmanHarris)
      .value("flat-top", dsp::WindowShape::kFlatTop);
  module.def(
      "welch",
      [](const Numbers& x, double rate_hz, std::size_t segment_size, dsp::WindowShape window,
         double overlap, bool detrend) {
        const auto taken = detrend ? dsp::Detrend::kMean : dsp::Detrend::kNothing;
        return Welch(x, {rate_hz, segment_size, window, overlap, taken});
      },
      py::arg("x"), py::arg("rate_hz"), py::arg("segment_size"), py::arg("window"),
      py::arg("overlap"), py::arg("detrend"));
  module.def(
      "sine_fit_at",
      [](const Numbers& x, double rate_hz, double frequency_hz, double noise_bandwidth_hz,
         int drift_degree) {
        return SineFitAt(x, {rate_hz, noise_bandwidth_hz, drift_degree}, frequency_hz);
      },
      py::arg("x"), py::arg("rate_hz"), py::arg("frequency_hz"), py::arg("noise_bandwidth_hz"),
      py::arg("drift_degree"));
  module.def(
      "strongest_tone",
      [](const Numbers& x, double rate_hz, std::pair<double, double> band_hz,
         double noise_bandwidth_hz) {
        return StrongestTone(x, {.rate_hz = rate_hz,
                                 .lower_hz = band_hz.first,
                                 .upper_hz = band_hz.second,
                                 .noise_bandwidth_hz = noise_bandwidth_hz});
      },
      py::arg("x"), py::arg("rate_hz"), py::arg("band_hz"), py::arg("noise_bandwidth_hz"));
  module.def("changed_scene", &ChangedScene, py::arg("text"), py::arg("folder"),
             py::arg("changes"));
}
