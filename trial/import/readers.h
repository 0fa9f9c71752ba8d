#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "trial/import/import_options.h"
#include "trial/record.h"
#include "trial/trial_reader.h"

namespace haptometer::trial {

/// A measurement from the text of a CSV: `# key = value` lines, a header line, rows.
///
/// Header line: `time_s`, and columns whose names carry role and unit: displacement_m, voltage_v,
/// current_a, trigger, each also in prefixed units (displacement_mm, voltage_mv, time_ms),
/// converted to SI; other names become ChannelRole::kOther. `status` applies to all channels,
/// `status_2` to the second. Separator comma, semicolon, tab or blanks (with the latter three a
/// decimal comma is understood); a byte-order mark and CRLF are tolerated.
/// trial/import/table/csv_header.h has the rules.
///
/// `# key = value`: keys with a place in Metadata go there (`label.NAME` to the labels), all others
/// to metadata.fields as text, as do those of impulse.csv. An empty cell, `nan` or `inf` is
/// kInvalid; a number beside a status that is no measurement is dropped.
///
/// Times that differ from a grid by no more than their printed digits explain become clocked
/// stretches (trial/import/table/printed_times.cc); other times are kept in raw_times_s beside
/// their mean line. The
/// `# stretch` lines of an export count where they still describe the rows.
///
/// A table of another program (oscilloscope, DAQ) is read as trial/import/table/foreign_table.h
/// says; `options` help where its own words do not suffice. Without a time column it needs
/// options.rate_hz. Errors name `name`; what was assumed goes to `findings`, which may be nullptr.
///
/// Errors (Cause::kCannotAnswer): text instead of numbers, no time column, times that do not grow
/// or are not finite, a row with too many or too few cells (the line is named), a comma that may be
/// a decimal one or group thousands, times against options.rate_hz, fewer than two rows. Memory:
/// the record.
[[nodiscard]] Result<Record> ParseCsv(std::string_view text, const std::string& name,
                                      const ImportOptions& options = {},
                                      Findings* findings = nullptr);

/// A trial from an HDF5 file that trial/export/export.h wrote, bit for bit as it was exported
/// (trial/import/exported_trial.h), or a table of numbers in a file of another program.
///
/// `name`: the trial's group, or the path of a dataset or a group in the file; empty where the file
/// holds one trial, or columns at its root. A table is a dataset of one dimension (a column called
/// as the dataset), of two (trial/import/number_table.h), a compound one whose fields are its
/// columns, or a group's datasets of one dimension that have the greatest length. Objects of other
/// kinds are passed over. What lies in other files, and how much is read, trial/import/hdf5_file.h
/// states. libhdf5 is not made for hostile files, so an HDF5 file is trusted not to
/// be one; types, shapes and sizes are checked all the same.
/// Errors (Cause::kCannotAnswer): no HDF5 file, nothing of these in it, several trials and no name
/// (they are named), as ReadExportedTrial and ReadNumberTable. Memory: the record.
[[nodiscard]] Result<Recording> ReadHdf5(const std::string& path, const std::string& name,
                                         const ImportOptions& options = {});

/// A trial from a MATLAB file of version 5 that trial/export/export.h wrote, or a table: the
/// variables of numbers of the greatest length of the file or of its only struct, beside each other
/// in the file's order. A vector is a column called as it is; the columns of a matrix have no names
/// (trial/import/number_table.h), so that options.columns names all columns where there is one.
///
/// `bytes`: of the file at `path`, which messages name; `variable`: the one to read; empty: all. At
/// most 2^28 numbers are read; what else there is in it, trial/import/mat_variables.h says.
/// Errors (Cause::kCannotAnswer): a file that was cut short, no such variable, several trials and
/// no name (they are named), as ReadExportedTrial and ReadNumberTable. Memory: the record and what
/// is compressed in the file.
[[nodiscard]] Result<Recording> ParseMat(std::string_view bytes, const std::string& path,
                                         const std::string& variable,
                                         const ImportOptions& options = {});

/// A trial from the bytes of an NPY that trial/export/export.h wrote, or a table: a NumPy array
/// with named fields, which are its columns, of one dimension, or of two
/// (trial/import/number_table.h). Numbers may be floats of 4 or 8 bytes and whole ones of 1 to 8,
/// in either order of bytes.
///
/// Errors (Cause::kCannotAnswer), naming `name`: another array (objects, texts, complex numbers,
/// fields with shapes of their own), bytes that are missing, more than 2^28 numbers, as
/// ReadExportedTrial and ReadNumberTable. Memory: the record.
[[nodiscard]] Result<Recording> ParseNpy(std::string_view bytes, const std::string& name,
                                         const ImportOptions& options = {});

/// A trial from the bytes of a WAV that trial/export/export.h wrote, or a table: a sound with a
/// column channel_N each track, at the file's rate. Samples are floats of 32 or 64 bits as they
/// are, or PCM of 8 to 32 bits as parts of full scale, -1 to 1; at either end they are kClipped.
///
/// Errors (Cause::kCannotAnswer), naming `name`: another coding, more than 2^28 numbers, as
/// ReadExportedTrial and ReadNumberTable. Of a sound that is shorter than it states the finding
/// kStatedRowsDiffer says so. Memory: the record.
[[nodiscard]] Result<Recording> ParseWav(std::string_view bytes, const std::string& name,
                                         const ImportOptions& options = {});

/// Whether `text` begins as a LabVIEW measurement file does.
[[nodiscard]] bool IsLvm(std::string_view text);

/// A measurement from the text of a LabVIEW measurement file (.lvm), versions 0 to 2 of the text
/// form (National Instruments, "Specification for the LabVIEW Measurement File (.lvm)").
///
/// Channels, their names and units (Y_Unit_Label), decimal point or comma, tabs or commas between
/// cells, X_Columns No, One or Multi (whose columns must agree), the comment column (kept as
/// notes), header lines in any order and several segments with a header each are understood. X0 and
/// Delta_X are the stated clock of a channel of more than one sample: it beats the printed X where
/// their resolution explains the difference. A segment's rows start where that says; where it does
/// not lie behind the segment before, at its Date and Time instead. Each segment is at least one
/// stretch. A unit of length makes a displacement, one of voltage or current a voltage or current.
/// The file's header is kept as fields ("lvm.Date"); the zone of its Time is not in the file, so
/// utc_start stays empty.
///
/// `options`: columns names the channels, or X and the channels, from the left; a channel of
/// another Delta_X than the first can be read on its own (options.channel), at its own X0 and
/// Delta_X. What was assumed goes to `findings`, which may be nullptr. options.format is passed
/// over.
///
/// Errors (Cause::kCannotAnswer), naming the line: no header end, a cell that is no number,
/// segments with other channels, X columns that differ, X values that fall, an X_Dimension other
/// than Time, channels that differ in Delta_X, X values that contradict Delta_X (options.rate_hz
/// decides), segments whose order in time the file does not tell, fewer than two rows.
/// Cause::kUsage: as ReadNamedColumns. Memory: the record.
[[nodiscard]] Result<Record> ParseLvm(std::string_view text, const std::string& name,
                                      const ImportOptions& options = {},
                                      Findings* findings = nullptr);

}  // namespace haptometer::trial
