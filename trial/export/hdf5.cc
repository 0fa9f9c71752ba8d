#include <hdf5.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <type_traits>
#include <utility>
#include <vector>

#include "trial/block.h"
#include "trial/export/description.h"
#include "trial/export/export.h"
#include "trial/export/object_names.h"
#include "trial/hdf5_id.h"
#include "trial/import/table/csv_header.h"
#include "trial/trial_format.h"

namespace haptometer::trial {
namespace {

static_assert(std::is_same_v<hid_t, std::int64_t> && std::is_same_v<herr_t, int>,
              "Hdf5Id stands for libhdf5's own types");

std::unexpected<Error> NotWritten() {
  return Failed("", "could not be written as HDF5", "is there room, and may you write there?");
}

// a dataset of `shape` with the bytes at `data`, which are of `type` already
Result<void> WriteData(const Hdf5Id& group, const std::string& name, hid_t type,
                       const std::vector<hsize_t>& shape, const void* data) {
  const Hdf5Id space(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr),
                     H5Sclose);
  Hdf5Id dataset(
      H5Dcreate2(group.id(), name.c_str(), type, space.id(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
      H5Dclose);
  if (!dataset.ok()) return NotWritten();
  // a dataset of no rows has no data to write
  const bool is_empty = shape.front() == 0;
  if (!is_empty && H5Dwrite(dataset.id(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0) {
    return NotWritten();
  }
  // a failed close is an error too: libhdf5 may write only then
  if (!dataset.Close()) return NotWritten();
  return {};
}

// types in the file are little-endian on every machine
template <typename T>
hid_t TypeOf() {
  if constexpr (std::is_same_v<T, double>) return H5T_IEEE_F64LE;
  if constexpr (std::is_same_v<T, std::int64_t>) return H5T_STD_I64LE;
  if constexpr (std::is_same_v<T, SampleStatus>) return H5T_STD_U8LE;
}

template <typename T>
Result<void> WriteColumn(const Hdf5Id& group, const std::string& name,
                         const std::vector<T>& values) {
  return WriteData(group, name, TypeOf<T>(), {values.size()}, values.data());
}

// a scalar of UTF-8 bytes; HDF5 has none of length 0, so an empty text is one NUL
Result<void> WriteText(const Hdf5Id& group, const std::string& name, const std::string& text) {
  const Hdf5Id type(H5Tcopy(H5T_C_S1), H5Tclose);
  const std::string stored = text.empty() ? std::string(1, '\0') : text;
  if (H5Tset_size(type.id(), stored.size()) < 0 || H5Tset_cset(type.id(), H5T_CSET_UTF8) < 0 ||
      H5Tset_strpad(type.id(), H5T_STR_NULLPAD) < 0) {
    return NotWritten();
  }
  const Hdf5Id space(H5Screate(H5S_SCALAR), H5Sclose);
  Hdf5Id dataset(H5Dcreate2(group.id(), name.c_str(), type.id(), space.id(), H5P_DEFAULT,
                            H5P_DEFAULT, H5P_DEFAULT),
                 H5Dclose);
  const bool is_written = dataset.ok() && H5Dwrite(dataset.id(), type.id(), H5S_ALL, H5S_ALL,
                                                   H5P_DEFAULT, stored.data()) >= 0;
  if (!is_written || !dataset.Close()) return NotWritten();
  return {};
}

// an attribute of one byte: 0 or 1
Result<void> WriteFlag(const Hdf5Id& group, const std::string& name, bool value) {
  const Hdf5Id space(H5Screate(H5S_SCALAR), H5Sclose);
  const Hdf5Id attribute(
      H5Acreate2(group.id(), name.c_str(), H5T_STD_U8LE, space.id(), H5P_DEFAULT, H5P_DEFAULT),
      H5Aclose);
  const std::uint8_t number = value ? 1 : 0;
  if (!attribute.ok() || H5Awrite(attribute.id(), H5T_STD_U8LE, &number) < 0) return NotWritten();
  return {};
}

// a column of the group `raw`: raw values in their encoding, or times in nanoseconds
struct RawColumn {
  hid_t type;
  std::function<void(const Chunk& chunk, std::size_t row, std::string* bytes)> append;
  Hdf5Id dataset;
};

// the datasets of a trial of `rows` rows, filled chunk by chunk
class RawColumns {
 public:
  RawColumns(const Hdf5Id& group, hsize_t rows) : group_(group), rows_(rows) {}

  // the times that the source's timing has: place on the grid, arrival, or request and reply
  Result<void> AddTimes(Timing timing) {
    if (timing == Timing::kUniform) {
      return Add("index", H5T_STD_I64LE, [](const Chunk& chunk, std::size_t row, auto* bytes) {
        AppendLittleEndian(chunk.first_index() + static_cast<std::int64_t>(row), bytes);
      });
    }
    const bool is_polled = timing == Timing::kPolled;
    auto done = Add(is_polled ? "request_ns" : "time_ns", H5T_STD_I64LE,
                    [](const Chunk& chunk, std::size_t row, auto* bytes) {
                      AppendLittleEndian(chunk.TimeNs(row), bytes);
                    });
    if (!done || !is_polled) return done;
    return Add("reply_ns", H5T_STD_I64LE, [](const Chunk& chunk, std::size_t row, auto* bytes) {
      AppendLittleEndian(chunk.ReplyNs(row), bytes);
    });
  }

  Result<void> AddChannel(const std::string& name, std::size_t channel, Encoding encoding) {
    // in the order of Encoding
    const hid_t types[] = {H5T_STD_I32LE, H5T_IEEE_F32LE, H5T_IEEE_F64LE};
    return Add(name, types[static_cast<std::size_t>(encoding)],
               [channel, size = BytesOf(encoding)](const Chunk& chunk, std::size_t row,
                                                   std::string* bytes) {
                 const std::uint64_t bits = chunk.At(row, channel).raw.bits();
                 bytes->append(reinterpret_cast<const char*>(&bits), size);
               });
  }

  // writes rows from `first` on; those behind the last one are omitted
  Result<void> Write(hsize_t first, const Chunk& chunk) {
    const hsize_t count = std::min<hsize_t>(chunk.rows(), rows_ - first);
    if (count == 0) return {};
    // a range of the dataset's rows, of the size of the chunk
    const Hdf5Id rows_in_memory(H5Screate_simple(1, &count, nullptr), H5Sclose);
    const Hdf5Id rows_in_file(H5Screate_simple(1, &rows_, nullptr), H5Sclose);
    if (H5Sselect_hyperslab(rows_in_file.id(), H5S_SELECT_SET, &first, nullptr, &count, nullptr) <
        0) {
      return NotWritten();
    }
    // rows are packed in the trial, columns are contiguous here
    for (const RawColumn& column : columns_) {
      bytes_.clear();
      for (std::size_t row = 0; row < count; ++row) column.append(chunk, row, &bytes_);
      if (H5Dwrite(column.dataset.id(), column.type, rows_in_memory.id(), rows_in_file.id(),
                   H5P_DEFAULT, bytes_.data()) < 0) {
        return NotWritten();
      }
    }
    return {};
  }

  Result<void> Close() {
    for (RawColumn& column : columns_) {
      if (!column.dataset.Close()) return NotWritten();
    }
    return {};
  }

 private:
  template <typename Append>
  Result<void> Add(const std::string& name, hid_t type, Append append) {
    const Hdf5Id space(H5Screate_simple(1, &rows_, nullptr), H5Sclose);
    Hdf5Id dataset(H5Dcreate2(group_.id(), name.c_str(), type, space.id(), H5P_DEFAULT, H5P_DEFAULT,
                              H5P_DEFAULT),
                   H5Dclose);
    if (!dataset.ok()) return NotWritten();
    columns_.push_back({type, append, std::move(dataset)});
    return {};
  }

  const Hdf5Id& group_;
  hsize_t rows_;
  std::vector<RawColumn> columns_;
  std::string bytes_;  // of one column and chunk
};

// chunk by chunk, so that the raw values of a long trial are never all in memory
Result<void> WriteRaw(const Hdf5Id& trial, const std::vector<std::string>& names, std::size_t rows,
                      TrialReader* reader) {
  const Hdf5Id group(H5Gcreate2(trial.id(), objects::kRaw, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                     H5Gclose);
  if (!group.ok()) return NotWritten();
  const TrialHeader& header = reader->header();
  RawColumns columns(group, rows);
  auto done = columns.AddTimes(header.timing);
  for (std::size_t c = 0; done && c < names.size(); ++c) {
    done = columns.AddChannel(names[c], c, header.channels[c].encoding);
  }
  hsize_t written = 0;
  // a file that grows meanwhile is written as far as its length at the beginning
  while (done && written < rows) {
    HAPTOMETER_LET(const auto chunk, reader->Next());
    if (chunk == nullptr) {
      return CannotAnswer("", "has fewer rows than when it was opened",
                          "export it when nothing writes to it");
    }
    done = columns.Write(written, *chunk);
    written += std::min<hsize_t>(chunk->rows(), rows - written);
  }
  if (!done) return done;
  return columns.Close();
}

// time of each row, arrival times where there are any, and a table of the segments
Result<void> WriteTimes(const Hdf5Id& group, const Record& record) {
  std::vector<double> times_s(record.rows);
  for (std::size_t row = 0; row < record.rows; ++row) times_s[row] = ExportedTimeOf(record, row);
  auto done = WriteColumn(group, objects::kTimes, times_s);
  if (done && HasArrivalTimes(record)) {
    done = WriteColumn(group, objects::kArrivalTimes, record.raw_times_s);
  }
  // one row of five numbers for each segment
  std::vector<double> numbers;
  for (const Stretch& stretch : record.stretches) {
    numbers.insert(numbers.end(),
                   {static_cast<double>(stretch.first_row), static_cast<double>(stretch.rows),
                    stretch.start_s, stretch.rate_hz, stretch.time_uncertainty_s});
  }
  if (!done) return done;
  return WriteData(group, objects::kStretches, H5T_IEEE_F64LE,
                   {record.stretches.size(), objects::kStretchNumbers}, numbers.data());
}

Result<void> WriteChannels(const Hdf5Id& group, const std::vector<std::string>& columns,
                           const Record& record) {
  Result<void> done;
  for (std::size_t c = 0; done && c < columns.size(); ++c) {
    done = WriteColumn(group, columns[c], record.channels[c].values);
    if (!done) return done;
    done = WriteColumn(group, objects::StatusName(columns[c]), record.channels[c].statuses);
  }
  return done;
}

// header, events, and the findings of the reader
Result<void> WriteWords(const Hdf5Id& group, const Recording& recording, TrialHeader header,
                        const FindingSayer& say) {
  header.metadata = recording.record.metadata;  // with the labels as last given
  auto done = WriteText(group, objects::kHeader, HeaderToJson(header));
  if (done) done = WriteText(group, objects::kEvents, EventLinesOf(recording.report));
  if (done) done = WriteText(group, objects::kRemarks, RemarksOf(recording.report, say));
  if (done) done = WriteFlag(group, objects::kClosed, recording.report.closed);
  if (done && recording.record.times_are_known)
    done = WriteFlag(group, objects::kTimesAreKnown, true);
  return done;
}

}  // namespace

Result<Hdf5Writer> Hdf5Writer::Create(const std::string& path) {
  PrepareHdf5();
  Hdf5Id file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose);
  if (!file.ok()) return NotWritten();
  return Hdf5Writer(std::move(file));
}

Result<void> Hdf5Writer::Add(const std::string& name, const Recording& recording, TrialReader* raw,
                             const FindingSayer& say) {
  const Hdf5Id group(H5Gcreate2(file_.id(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                     H5Gclose);
  if (!group.ok()) return NotWritten();
  const Record& record = recording.record;
  const std::vector<std::string> columns = CsvColumnNames(record.channels);
  auto done = WriteTimes(group, record);
  if (done) done = WriteChannels(group, columns, record);
  if (done) {
    // without a trial.bin the header is made from the record
    done = WriteWords(group, recording, raw != nullptr ? raw->header() : HeaderOf(record), say);
  }
  if (done && raw != nullptr) done = WriteRaw(group, columns, record.rows, raw);
  return done;
}

Result<void> Hdf5Writer::Close() {
  // flushed first, because a failed close gives no reason
  const bool is_flushed = H5Fflush(file_.id(), H5F_SCOPE_LOCAL) >= 0;
  if (!file_.Close() || !is_flushed) return NotWritten();
  return {};
}

}  // namespace haptometer::trial
