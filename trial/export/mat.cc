#include <matio.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "trial/block.h"
#include "trial/byte_io.h"
#include "trial/export/description.h"
#include "trial/export/export.h"
#include "trial/export/object_names.h"
#include "trial/import/table/csv_header.h"
#include "trial/trial_format.h"

namespace haptometer::trial {
namespace {

using Variable = std::unique_ptr<matvar_t, decltype(&Mat_VarFree)>;

std::unexpected<Error> NotWritten() {
  return Failed("", "could not be written as a MATLAB file",
                "is there room, and may you write there?");
}

// whether the file at `path` holds `variables` whole elements, by the lengths in it: libmatio
// does not check whether a write succeeds
Result<void> CheckWhole(const std::string& path, std::size_t variables) {
  // a MAT file of version 5: a header of 128 bytes, then elements of tag and data
  constexpr std::size_t kHeadBytes = 128;
  const auto file = OpenFileSource(path);
  if (!file) return NotWritten();
  std::uint64_t at = kHeadBytes;
  std::size_t found = 0;
  while (at < (*file)->size()) {
    std::array<std::byte, 8> tag{};  // type and length, 32 bits each
    const auto got = (*file)->ReadAt(at, tag);
    if (!got || *got < tag.size()) return NotWritten();
    at += tag.size() + LoadLittleEndian<std::uint32_t>(tag.data() + 4);
    ++found;
  }
  if (found != variables || at != (*file)->size()) return NotWritten();
  return {};
}

// a struct that is built field by field; each field's data are copied
class Struct {
 public:
  explicit Struct(const std::string& name)
      : variable_(Mat_VarCreateStruct(name.c_str(), 2, one_by_one_.data(), nullptr, 0),
                  Mat_VarFree) {}

  void Column(const std::string& name, const std::vector<double>& values, std::size_t width = 1) {
    Add(name, MAT_C_DOUBLE, MAT_T_DOUBLE, {values.size() / width, width}, values.data());
  }
  void Statuses(const std::string& name, const std::vector<SampleStatus>& statuses) {
    Add(name, MAT_C_UINT8, MAT_T_UINT8, {statuses.size(), 1}, statuses.data());
  }
  void Flag(const std::string& name, bool is_set) {
    const std::uint8_t number = is_set ? 1 : 0;
    Add(name, MAT_C_UINT8, MAT_T_UINT8, {1, 1}, &number);
  }
  // `text` is ASCII, because what libmatio makes of other characters depends on the reader
  void Text(const std::string& name, const std::string& text) {
    Add(name, MAT_C_CHAR, MAT_T_UINT8, {text.empty() ? 0U : 1U, text.size()}, text.data());
  }

  [[nodiscard]] bool ok() const { return is_whole_; }
  [[nodiscard]] matvar_t* get() const { return variable_.get(); }

 private:
  void Add(const std::string& name, matio_classes kind, matio_types type,
           std::array<std::size_t, 2> shape, const void* data) {
    // libmatio copies from the pointer and changes nothing behind it
    matvar_t* field =
        Mat_VarCreate(nullptr, kind, type, 2, shape.data(), const_cast<void*>(data), 0);
    if (field == nullptr || variable_ == nullptr ||
        Mat_VarAddStructField(variable_.get(), name.c_str()) != 0) {
      is_whole_ = false;
      Mat_VarFree(field);
      return;
    }
    Mat_VarSetStructFieldByName(variable_.get(), name.c_str(), 0, field);
  }

  std::array<std::size_t, 2> one_by_one_{1, 1};
  Variable variable_;
  bool is_whole_ = true;
};

// the same JSON with all other characters escaped
std::string Ascii(const std::string& json) {
  return nlohmann::ordered_json::parse(json).dump(-1, ' ', true);
}

// the same of a line of JSON each
std::string AsciiLines(const std::string& lines) {
  std::istringstream source(lines);
  std::string ascii;
  for (std::string line; std::getline(source, line);) ascii += Ascii(line) + "\n";
  return ascii;
}

// each byte of another character as a question mark
std::string AsciiText(std::string text) {
  std::ranges::replace_if(text, [](char c) { return (c & 0x80) != 0; }, '?');
  return text;
}

// time of each row, arrival times where there are any, and a matrix of the segments
void AddTimes(const Record& record, Struct* variable) {
  std::vector<double> times_s(record.rows);
  for (std::size_t row = 0; row < record.rows; ++row) times_s[row] = ExportedTimeOf(record, row);
  variable->Column(objects::kTimes, times_s);
  if (HasArrivalTimes(record)) variable->Column(objects::kArrivalTimes, record.raw_times_s);
  // column by column, as MATLAB stores a matrix
  std::vector<double> numbers;
  numbers.reserve(objects::kStretchNumbers * record.stretches.size());
  for (const Stretch& s : record.stretches) numbers.push_back(static_cast<double>(s.first_row));
  for (const Stretch& s : record.stretches) numbers.push_back(static_cast<double>(s.rows));
  for (const Stretch& s : record.stretches) numbers.push_back(s.start_s);
  for (const Stretch& s : record.stretches) numbers.push_back(s.rate_hz);
  for (const Stretch& s : record.stretches) numbers.push_back(s.time_uncertainty_s);
  variable->Column(objects::kStretches, numbers, objects::kStretchNumbers);
}

// header, events, remarks in ASCII, and the flags
void AddWords(const Recording& recording, const FindingSayer& say, Struct* variable) {
  variable->Text(objects::kHeader, Ascii(HeaderToJson(HeaderOf(recording.record))));
  variable->Text(objects::kEvents, AsciiLines(EventLinesOf(recording.report)));
  variable->Text(objects::kRemarks, AsciiText(RemarksOf(recording.report, say)));
  variable->Flag(objects::kClosed, recording.report.closed);
  if (recording.record.times_are_known) variable->Flag(objects::kTimesAreKnown, true);
}

}  // namespace

struct MatWriter::State {
  std::string path;
  mat_t* file = nullptr;
  std::size_t variables = 0;
  ~State() {
    if (file != nullptr) Mat_Close(file);
  }
};

MatWriter::MatWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
MatWriter::MatWriter(MatWriter&&) noexcept = default;
MatWriter& MatWriter::operator=(MatWriter&&) noexcept = default;
MatWriter::~MatWriter() = default;

Result<MatWriter> MatWriter::Create(const std::string& path) {
  auto state = std::make_unique<State>();
  state->path = path;
  state->file =
      Mat_CreateVer(path.c_str(), "MATLAB 5.0 MAT-file, written by haptometer", MAT_FT_MAT5);
  if (state->file == nullptr) return NotWritten();
  return MatWriter(std::move(state));
}

Result<void> MatWriter::Add(const std::string& name, const Recording& recording,
                            const FindingSayer& say) {
  const Record& record = recording.record;
  // the length of a variable has 32 bits, which some readers treat as signed
  constexpr double kLargestBytes = 2e9;
  const double channels = static_cast<double>(record.channels.size());
  // bytes per row: 16 for two times, 9 for the value and status of each channel
  if (static_cast<double>(record.rows) * (16 + 9 * channels) > kLargestBytes) {
    return CannotAnswer("", "is larger than the 2 GiB that a MATLAB file can hold",
                        "export it as .h5");
  }
  Struct variable(name);
  AddTimes(record, &variable);
  const std::vector<std::string> columns = CsvColumnNames(record.channels);
  for (std::size_t c = 0; c < columns.size(); ++c) {
    variable.Column(columns[c], record.channels[c].values);
    variable.Statuses(objects::StatusName(columns[c]), record.channels[c].statuses);
  }
  AddWords(recording, say, &variable);
  if (!variable.ok() || Mat_VarWrite(state_->file, variable.get(), MAT_COMPRESSION_NONE) != 0) {
    return NotWritten();
  }
  ++state_->variables;
  return {};
}

Result<void> MatWriter::Close() {
  // the file is closed first, so that all of it is on the disk when its length is checked
  Mat_Close(std::exchange(state_->file, nullptr));
  return CheckWhole(state_->path, state_->variables);
}

}  // namespace haptometer::trial
