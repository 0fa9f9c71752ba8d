#include <fmt/core.h>
#include <fmt/ranges.h>
#include <hdf5.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "base/input_file.h"
#include "trial/hdf5_id.h"
#include "trial/import/csv_header.h"
#include "trial/import/readers.h"
#include "trial/trial_format.h"

namespace haptometer::trial {
namespace {

constexpr const char* kRemedy = "export the trial again with haptometer trial export";

// no larger dataset is read, regardless of the size that a file states: 2 GiB of doubles
constexpr hsize_t kMostNumbers = 1ULL << 28;

// Reads the objects of one trial's group; errors name file and object.
class Group {
 public:
  Group(Hdf5Id group, std::string where) : group_(std::move(group)), where_(std::move(where)) {}

  [[nodiscard]] bool Has(const std::string& name) const {
    return H5Lexists(group_.id(), name.c_str(), H5P_DEFAULT) > 0;
  }
  [[nodiscard]] const std::string& where() const { return where_; }

  std::unexpected<Error> Wrong(const std::string& name, const std::string& what) const {
    return CannotAnswer(where_, fmt::format("its {} {}", name, what), kRemedy);
  }

  // the numbers of a dataset whose rows are `width` wide; T as it lies in memory
  template <typename T>
  Result<std::vector<T>> Numbers(const std::string& name, hid_t type, H5T_class_t kind,
                                 hsize_t width = 1) const {
    // existence, type, class and shape are checked before the memory is allocated
    const Hdf5Id dataset(H5Dopen2(group_.id(), name.c_str(), H5P_DEFAULT), H5Dclose);
    if (!dataset.ok()) return Wrong(name, "is missing");
    const Hdf5Id stored(H5Dget_type(dataset.id()), H5Tclose);
    if (H5Tget_class(stored.id()) != kind || H5Tget_size(stored.id()) != sizeof(T)) {
      return Wrong(name, "holds numbers of another type");
    }
    const Hdf5Id space(H5Dget_space(dataset.id()), H5Sclose);
    // one or two dimensions; a vector has the width 1
    hsize_t shape[2] = {0, 1};
    const int rank = H5Sget_simple_extent_ndims(space.id());
    if (rank < 1 || rank > 2 || H5Sget_simple_extent_dims(space.id(), shape, nullptr) < 0 ||
        shape[1] != width) {
      return Wrong(name, "has another shape");
    }
    // a claimed length above the limit is refused
    if (shape[0] > kMostNumbers / width) return Wrong(name, "is too long to be read");
    std::vector<T> numbers(shape[0] * width);
    if (!numbers.empty() &&
        H5Dread(dataset.id(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data()) < 0) {
      return Wrong(name, "cannot be read: the file is damaged");
    }
    return numbers;
  }

  Result<std::vector<double>> Doubles(const std::string& name, hsize_t width = 1) const {
    return Numbers<double>(name, H5T_NATIVE_DOUBLE, H5T_FLOAT, width);
  }

  // a scalar text of fixed length; NULs at its end do not belong to it
  Result<std::string> Text(const std::string& name) const {
    constexpr std::size_t kMostBytes = 1U << 28;
    const Hdf5Id dataset(H5Dopen2(group_.id(), name.c_str(), H5P_DEFAULT), H5Dclose);
    if (!dataset.ok()) return Wrong(name, "is missing");
    const Hdf5Id type(H5Dget_type(dataset.id()), H5Tclose);
    const Hdf5Id space(H5Dget_space(dataset.id()), H5Sclose);
    // a file may state any length, so it is limited
    const std::size_t bytes = H5Tget_size(type.id());
    if (H5Tget_class(type.id()) != H5T_STRING || H5Tis_variable_str(type.id()) > 0 ||
        H5Sget_simple_extent_type(space.id()) != H5S_SCALAR || bytes > kMostBytes) {
      return Wrong(name, "is not a text of fixed length");
    }
    std::string text(bytes, '\0');
    if (H5Dread(dataset.id(), type.id(), H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data()) < 0) {
      return Wrong(name, "cannot be read: the file is damaged");
    }
    text.erase(text.find_last_not_of('\0') + 1);
    return text;
  }

  // an attribute of one integer; absent or of another type: false
  [[nodiscard]] bool Flag(const std::string& name) const {
    std::uint8_t value = 0;
    const Hdf5Id attribute(H5Aopen(group_.id(), name.c_str(), H5P_DEFAULT), H5Aclose);
    if (!attribute.ok()) return false;
    const Hdf5Id type(H5Aget_type(attribute.id()), H5Tclose);
    const Hdf5Id space(H5Aget_space(attribute.id()), H5Sclose);
    if (H5Tget_class(type.id()) != H5T_INTEGER || H5Sget_simple_extent_npoints(space.id()) != 1) {
      return false;
    }
    return H5Aread(attribute.id(), H5T_NATIVE_UINT8, &value) >= 0 && value != 0;
  }

 private:
  Hdf5Id group_;
  std::string where_;
};

// the lines of a text, without empty ones
std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    if (end > at) lines.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return lines;
}

// what stands at the root, at most `most` of it
std::vector<std::string> NamesIn(const Hdf5Id& file, hsize_t most) {
  std::vector<std::string> names;
  H5G_info_t info{};
  if (H5Gget_info(file.id(), &info) < 0) return names;
  for (hsize_t i = 0; i < std::min(info.nlinks, most); ++i) {
    // longer names are ignored: no trial's group has one
    char name[1024];
    const auto length = H5Lget_name_by_idx(file.id(), ".", H5_INDEX_NAME, H5_ITER_INC, i, name,
                                           sizeof name, H5P_DEFAULT);
    if (length > 0 && length < static_cast<ssize_t>(sizeof name)) names.emplace_back(name);
  }
  return names;
}

// the groups at the root that hold a trial's header
std::vector<std::string> TrialsIn(const Hdf5Id& file) {
  std::vector<std::string> names;
  for (std::string& name : NamesIn(file, std::numeric_limits<hsize_t>::max())) {
    const std::string header = name + "/" + hdf5::kHeader;
    // objects at the root of other kinds than groups are no trials
    H5O_info_t object{};
    if (H5Oget_info_by_name(file.id(), name.c_str(), &object, H5P_DEFAULT) < 0 ||
        object.type != H5O_TYPE_GROUP) {
      continue;
    }
    if (H5Lexists(file.id(), header.c_str(), H5P_DEFAULT) > 0) names.push_back(std::move(name));
  }
  return names;
}

// "the dataset values (2 x 1000), the group set": the first few objects, for a message
std::string ObjectsIn(const Hdf5Id& file) {
  constexpr hsize_t kShown = 4;
  std::vector<std::string> objects;
  for (const std::string& name : NamesIn(file, kShown)) {
    const Hdf5Id dataset(H5Dopen2(file.id(), name.c_str(), H5P_DEFAULT), H5Dclose);
    if (!dataset.ok()) {
      objects.push_back(fmt::format("the group {}", name));
      continue;
    }
    const Hdf5Id space(H5Dget_space(dataset.id()), H5Sclose);
    hsize_t shape[H5S_MAX_RANK] = {};
    const int rank = H5Sget_simple_extent_dims(space.id(), shape, nullptr);
    objects.push_back(fmt::format("the dataset {} ({})", name,
                                  fmt::join(shape, shape + std::max(rank, 0), " x ")));
  }
  if (objects.empty()) return "nothing";
  H5G_info_t info{};
  const bool is_more = H5Gget_info(file.id(), &info) >= 0 && info.nlinks > kShown;
  return fmt::format("{}{}", fmt::join(objects, ", "), is_more ? " and more" : "");
}

// the group to read: the named one, or the only one; else an error that lists the groups
Result<std::string> Choose(const Hdf5Id& file, const std::string& path, const std::string& name) {
  const std::vector<std::string> names = TrialsIn(file);
  if (names.empty()) {
    return CannotAnswer(
        path,
        fmt::format("is an HDF5 file of another program: no group at its root holds a trial ({}); "
                    "it holds {}",
                    hdf5::kHeader, ObjectsIn(file)),
        "export the dataset's columns as a CSV whose header line is such as time_s,displacement_m");
  }
  if (name.empty() && names.size() == 1) return names.front();
  if (!name.empty() && std::ranges::find(names, name) != names.end()) return name;
  const std::size_t shown = std::min<std::size_t>(names.size(), 8);
  const std::string list =
      fmt::format("{}{}", fmt::join(names.begin(), names.begin() + static_cast<long>(shown), ", "),
                  names.size() > shown ? ", ..." : "");
  return CannotAnswer(path,
                      name.empty() ? fmt::format("holds {} trials: {}", names.size(), list)
                                   : fmt::format("holds no trial '{}', but {}", name, list),
                      fmt::format("name one as {}/{}", path, names.front()));
}

// whether the segments cover `rows` rows in order
bool Covers(const std::vector<Stretch>& stretches, std::size_t rows) {
  std::size_t row = 0;
  for (const Stretch& stretch : stretches) {
    if (stretch.first_row != row || stretch.rows == 0 || stretch.rows > rows - row) return false;
    if (!std::isfinite(stretch.start_s) || !(stretch.rate_hz > 0)) return false;
    row += stretch.rows;
  }
  return row == rows;
}

Result<void> ReadTimes(const Group& group, Record* record) {
  // five numbers per segment: first_row, rows, start_s, rate_hz, time_uncertainty_s
  HAPTOMETER_LET(const auto numbers, group.Doubles(hdf5::kStretches, hdf5::kStretchNumbers));
  constexpr double kMostRows = kMostNumbers;
  for (std::size_t i = 0; i < numbers.size(); i += hdf5::kStretchNumbers) {
    const double* n = numbers.data() + i;
    // counts are stored as doubles: checked before they are converted
    const bool is_count = n[0] >= 0 && n[0] <= kMostRows && n[1] >= 0 && n[1] <= kMostRows;
    if (!is_count) return group.Wrong(hdf5::kStretches, "do not describe its rows");
    record->stretches.push_back({.first_row = static_cast<std::size_t>(n[0]),
                                 .rows = static_cast<std::size_t>(n[1]),
                                 .start_s = n[2],
                                 .rate_hz = n[3],
                                 .time_uncertainty_s = n[4]});
  }
  if (!Covers(record->stretches, record->rows)) {
    return group.Wrong(hdf5::kStretches, "do not describe its rows");
  }
  // raw times only where the source's times lie on no grid
  if (!group.Has(hdf5::kRawTimes)) return {};
  HAPTOMETER_LET(auto raw, group.Doubles(hdf5::kRawTimes));
  if (raw.size() != record->rows) return group.Wrong(hdf5::kRawTimes, "has another length");
  record->raw_times_s = std::move(raw);
  record->times_are_known = group.Flag(hdf5::kTimesAreKnown);
  return {};
}

// values and statuses of one channel, of equal length, without numbers that are no measurements
Result<void> ReadChannel(const Group& group, const std::string& column, std::size_t rows,
                         Channel* channel) {
  HAPTOMETER_LET(auto values, group.Doubles(column));
  const std::string status_name = hdf5::StatusName(column);
  HAPTOMETER_LET(const auto statuses,
                 group.Numbers<std::uint8_t>(status_name, H5T_NATIVE_UINT8, H5T_INTEGER));
  if (values.size() != rows) return group.Wrong(column, "has another length");
  if (statuses.size() != rows) return group.Wrong(status_name, "has another length");
  for (std::size_t row = 0; row < rows; ++row) {
    if (statuses[row] >= kSampleStatusCount) return group.Wrong(status_name, "is none");
    const auto status = static_cast<SampleStatus>(statuses[row]);
    channel->statuses.push_back(status);
    // a number beside a status that is none is not kept, as everywhere
    if (!IsMeasurement(status)) values[row] = std::numeric_limits<double>::quiet_NaN();
  }
  channel->values = std::move(values);
  return {};
}

// the header comes first: it names the channels, whose columns have the names of a CSV
Result<Record> ReadRecordOf(const Group& group) {
  HAPTOMETER_LET(const auto json, group.Text(hdf5::kHeader));
  const auto header = HeaderFromJson(json);
  if (!header) return group.Wrong(hdf5::kHeader, "is not a trial's header");
  // the times give the number of rows; they are computed again from the segments
  HAPTOMETER_LET(const auto times_s, group.Doubles(hdf5::kTimes));
  Record record;
  record.rows = times_s.size();
  record.timing = header->timing;
  record.metadata = header->metadata;
  HAPTOMETER_TRY(ReadTimes(group, &record));
  for (const ChannelFormat& format : header->channels) record.channels.push_back(ChannelOf(format));
  const std::vector<std::string> columns = CsvColumnNames(record.channels);
  for (std::size_t c = 0; c < columns.size(); ++c) {
    HAPTOMETER_TRY(ReadChannel(group, columns[c], record.rows, &record.channels[c]));
  }
  return record;
}

Result<Recording> ReadGroup(const Group& group) {
  HAPTOMETER_LET(auto record, ReadRecordOf(group));
  Recording recording{.record = std::move(record), .report = {}};
  ReadReport& report = recording.report;
  report.kind = FileKind::kHdf5;
  report.closed = group.Flag(hdf5::kClosed);
  // an export is complete: no rows beyond those that it holds
  report.rows = report.next_row = recording.record.rows;
  if (group.Has(hdf5::kEvents)) {
    HAPTOMETER_LET(const auto events, group.Text(hdf5::kEvents));
    for (const std::string& line : Lines(events)) {
      const auto event = EventFromJson(line);
      if (!event) return group.Wrong(hdf5::kEvents, "hold a line that is none");
      report.events.push_back(*event);
    }
  }
  if (group.Has(hdf5::kRemarks)) {
    HAPTOMETER_LET(const auto remarks, group.Text(hdf5::kRemarks));
    for (std::string& line : Lines(remarks)) {
      report.findings.Note(FindingKind::kNotedAtExport, {{"text", std::move(line)}});
    }
  }
  return recording;
}

}  // namespace

Result<Recording> ReadHdf5(const std::string& path, const std::string& name) {
  // errors are reported by this program, not by libhdf5 on stderr
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  // no output of the same command may replace this file
  NoteInput(path);
  const Hdf5Id file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (!file.ok()) {
    return CannotAnswer(path, "is a damaged HDF5 file, or is still being written", kRemedy);
  }
  HAPTOMETER_LET(const auto chosen, Choose(file, path, name));
  Hdf5Id group(H5Gopen2(file.id(), chosen.c_str(), H5P_DEFAULT), H5Gclose);
  if (!group.ok()) return CannotAnswer(path, "holds a trial that cannot be opened", kRemedy);
  return ReadGroup(Group(std::move(group), fmt::format("{}/{}", path, chosen)));
}

}  // namespace haptometer::trial
