#pragma once

#include <string>
#include <string_view>

#include "base/error.h"

namespace haptometer::cli {

/// What an option writes, and how an existing file of that kind is known. Only such a file is ever
/// replaced: see OutputFile.
struct OutputKind {
  std::string_view name;      ///< "a sweep's table", for messages
  std::string_view begin;     ///< the first bytes of its content
  bool has_comments = false;  ///< `begin` stands behind lines that begin with "# "
  /// The file ends with Marked()'s mark; it is replaced without being asked to.
  bool is_marked = false;
};

inline constexpr OutputKind kPictureOutput{
    .name = "a picture drawn by haptometer", .begin = "", .is_marked = true};
inline constexpr OutputKind kPageOutput{
    .name = "a page written by haptometer", .begin = "<!DOCTYPE html>", .is_marked = true};
inline constexpr OutputKind kTrialOutput{.name = "a trial.bin",
                                         .begin =
                                             "\x93"
                                             "haptrial\r\n"};
inline constexpr OutputKind kRowsOutput{
    .name = "a table of time_s", .begin = "time_s,", .has_comments = true};
inline constexpr OutputKind kSpectrumOutput{
    .name = "a spectrum's table", .begin = "frequency_hz,", .has_comments = true};
inline constexpr OutputKind kSpectrogramOutput{
    .name = "a spectrogram's table", .begin = "time_s,frequency_hz,", .has_comments = true};
inline constexpr OutputKind kSweepTableOutput{.name = "a sweep's table",
                                              .begin = "# haptometer sweep "};
inline constexpr OutputKind kStudyTableOutput{
    .name = "a study's table", .begin = "subject,", .has_comments = true};
inline constexpr OutputKind kTrialsTableOutput{
    .name = "a table of trials", .begin = "file,", .has_comments = true};
inline constexpr OutputKind kResultsOutput{.name = "a file of results",
                                           .begin = "haptometer results "};
inline constexpr OutputKind kMethodsOutput{.name = "a methods paragraph", .begin = "## Methods\n"};
inline constexpr OutputKind kActuatorOutput{.name = "an actuator written by --save",
                                            .begin = "# written by haptometer fit-lra"};
inline constexpr OutputKind kCalibrationOutput{.name = "a calibration file",
                                               .begin = "# written by haptometer calibrate"};
inline constexpr OutputKind kHdf5Output{.name = "an HDF5 file", .begin = "\x89HDF\r\n\x1a\n"};
inline constexpr OutputKind kNpyOutput{.name = "a NumPy file", .begin = "\x93NUMPY"};
inline constexpr OutputKind kWavOutput{.name = "a WAV file", .begin = "RIFF"};
inline constexpr OutputKind kMatOutput{.name = "a MATLAB file written by haptometer",
                                       .begin = "MATLAB 5.0 MAT-file, written by haptometer"};

/// A picture (SVG, PNG, PDF) or page (HTML) with the mark "made by haptometer CRC" at its end, as a
/// comment, in a PNG as a tEXt chunk; CRC is the CRC-32 of all bytes before it. So a file that was
/// changed since is known to be somebody's work.
[[nodiscard]] std::string Marked(std::string content);

/// Whether `content` is a whole SVG, PNG or PDF as gnuplot writes it, to its last line or chunk.
[[nodiscard]] bool IsWholePicture(std::string_view content);

/// Whether a file of this content is one that `kind`'s option may have made. An empty one holds
/// nothing that could be lost, and is, unless `kind` is marked.
[[nodiscard]] bool IsOfKind(std::string_view content, const OutputKind& kind);

/// Whether `path` may be written now. This is the one rule for every file that a command makes:
///
/// 1. An input of the same command is never written, under whatever name: inputs are the files that
///    its words name and those that it opened to read (NoteInput), compared by device and inode.
/// 2. An existing file is replaced only if it is of `kind` and either `overwrite` was said or it is
///    a picture or page with haptometer's own mark (OutputKind), unchanged since. No file of
///    another kind, no read-only file and none that another program is writing (flock) is replaced.
/// 3. A link to an existing file stands for that file. A link to nothing, a directory, a disk and a
///    socket are refused.
/// 4. Pipes, terminals and devices (/dev/null) are written as they are, and /dev/stdout,
///    /dev/stderr, /dev/fd/N as the open files that they name. A pipe that no program reads is
///    refused when it is opened.
///
/// Errors: Cause::kUsage where the rule forbids it or the directory does not exist; Cause::kFailed
/// where the system does not permit writing there. Reads an existing file that is a picture or page
/// whole, of others 1 MiB.
[[nodiscard]] Result<void> CheckOutput(const std::string& path, const OutputKind& kind,
                                       bool overwrite);

/// Whether both paths lead to one file, there already or not. Devices and pipes are none.
[[nodiscard]] bool AreOneOutput(const std::string& one, const std::string& other);

/// A file that is written under a name of its own beside its place and takes its place only when it
/// is whole and on the disk, so that a full disk costs no older file and leaves none behind.
///
/// The part's name is random and made exclusively, following no link. A new file gets the
/// permissions that open() would give; one in the place of an older keeps that one's, and its owner
/// where the system permits. Where rule 4 of CheckOutput holds, the bytes go straight there.
class OutputFile {
 public:
  /// Errors: as CheckOutput, and Cause::kUsage for a pipe that no program reads; Cause::kFailed
  /// where no part can be made.
  [[nodiscard]] static Result<OutputFile> Begin(const std::string& path, const OutputKind& kind,
                                                bool overwrite);

  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&&) = delete;
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  /// Removes what was not finished.
  ~OutputFile();

  /// Writes all of `bytes` behind what was written. Errors: Cause::kFailed.
  [[nodiscard]] Result<void> Write(std::string_view bytes);

  /// The part's path for a library that opens files by name. Errors (Cause::kUsage): it is no
  /// regular file, where such a library could not go back.
  [[nodiscard]] Result<std::string> PathForLibrary() const;

  /// Syncs the part and gives it its place. Errors: Cause::kFailed when the disk fails;
  /// Cause::kUsage when a file has come to be there meanwhile that CheckOutput forbids to replace.
  [[nodiscard]] Result<void> Finish();

 private:
  OutputFile(std::string path, OutputKind kind, bool overwrite);
  [[nodiscard]] Result<void> MakePart();
  [[nodiscard]] Result<void> TakePlace();
  [[nodiscard]] std::unexpected<Error> NotWritten(int failure) const;

  std::string path_;    // as given, for messages
  std::string target_;  // where links lead
  std::string part_;    // empty: none, or finished
  OutputKind kind_;
  bool overwrite_;
  int descriptor_ = -1;
};

/// Gives the file `from` the name `to`, which is synced, where nothing has that name.
/// Errors (Cause::kFailed): something has come to be there, or the disk fails.
[[nodiscard]] Result<void> RenameNew(const std::string& from, const std::string& to);

/// Writes `content` as an OutputFile. Errors: as its.
[[nodiscard]] Result<void> WriteOutput(const std::string& path, const OutputKind& kind,
                                       bool overwrite, std::string_view content);

}  // namespace haptometer::cli
