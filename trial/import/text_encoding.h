#pragma once

#include <string>
#include <string_view>

namespace haptometer::trial {

/// The text of a file as UTF-8 with lines that end in LF (or CR LF).
///
/// A byte-order mark is taken off; UTF-16 (told by its mark) is converted; text that is not valid
/// UTF-8 is read as Windows-1252, as oscilloscopes and spreadsheets write "µs"; NUL bytes are
/// dropped; lines that end in CR alone end in LF. Returns a view of `raw` where nothing needs
/// changing, else of `storage`. Cost: one pass over the bytes.
[[nodiscard]] std::string_view Utf8Text(std::string_view raw, std::string* storage);

}  // namespace haptometer::trial
