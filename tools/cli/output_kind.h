#pragma once

#include <string>
#include <string_view>

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
inline constexpr OutputKind kStudyTableOutput{.name = "a study's table", .begin = "subject,"};
inline constexpr OutputKind kMethodsOutput{.name = "a methods paragraph", .begin = "## Methods\n"};
inline constexpr OutputKind kActuatorOutput{.name = "an actuator written by --save",
                                            .begin = "# written by haptometer fit-lra"};
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

}  // namespace haptometer::cli
