#include "trial/import/text_encoding.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "base/text.h"

namespace haptometer::trial {
namespace {

unsigned Byte(char c) { return static_cast<unsigned char>(c); }

void AppendUtf8(std::uint32_t code, std::string* text) {
  const auto put = [text](std::uint32_t byte) { text->push_back(static_cast<char>(byte)); };
  if (code < 0x80) {
    put(code);
  } else if (code < 0x800) {
    put(0xc0 | code >> 6);
    put(0x80 | (code & 0x3f));
  } else if (code < 0x10000) {
    put(0xe0 | code >> 12);
    put(0x80 | (code >> 6 & 0x3f));
    put(0x80 | (code & 0x3f));
  } else {
    put(0xf0 | code >> 18);
    put(0x80 | (code >> 12 & 0x3f));
    put(0x80 | (code >> 6 & 0x3f));
    put(0x80 | (code & 0x3f));
  }
}

std::string FromUtf16(std::string_view raw, bool is_big_endian) {
  constexpr std::uint32_t kReplacement = 0xfffd;
  const auto unit = [&](std::size_t i) -> std::uint32_t {
    const unsigned first = Byte(raw[i]);
    const unsigned second = Byte(raw[i + 1]);
    return is_big_endian ? first << 8U | second : second << 8U | first;
  };
  std::string text;
  text.reserve(raw.size());
  for (std::size_t i = 0; i + 1 < raw.size(); i += 2) {
    std::uint32_t code = unit(i);
    const bool is_high = code >= 0xd800 && code < 0xdc00;
    if (is_high && i + 3 < raw.size() && unit(i + 2) >= 0xdc00 && unit(i + 2) < 0xe000) {
      code = 0x10000 + ((code - 0xd800) << 10U) + (unit(i + 2) - 0xdc00);
      i += 2;
    } else if (code >= 0xd800 && code < 0xe000) {
      code = kReplacement;
    }
    AppendUtf8(code, &text);
  }
  return text;
}

bool IsUtf8(std::string_view text) {
  while (!text.empty()) {
    const std::size_t bytes = Utf8CharacterBytes(text);
    if (bytes == 0) return false;
    text.remove_prefix(bytes);
  }
  return true;
}

std::string FromWindows1252(std::string_view raw) {
  constexpr std::array<std::uint16_t, 32> kAbove7f{
      0x20ac, 0xfffd, 0x201a, 0x0192, 0x201e, 0x2026, 0x2020, 0x2021, 0x02c6, 0x2030, 0x0160,
      0x2039, 0x0152, 0xfffd, 0x017d, 0xfffd, 0xfffd, 0x2018, 0x2019, 0x201c, 0x201d, 0x2022,
      0x2013, 0x2014, 0x02dc, 0x2122, 0x0161, 0x203a, 0x0153, 0xfffd, 0x017e, 0x0178};
  std::string text;
  text.reserve(raw.size());
  for (const char c : raw) {
    const unsigned byte = Byte(c);
    AppendUtf8(byte >= 0x80 && byte < 0xa0 ? kAbove7f[byte - 0x80] : byte, &text);
  }
  return text;
}

}  // namespace

std::string_view Utf8Text(std::string_view raw, std::string* storage) {
  std::string_view text = raw;
  if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff")) {
    *storage = FromUtf16(text.substr(2), text.starts_with("\xfe\xff"));
    text = *storage;
  } else if (text.starts_with("\xef\xbb\xbf")) {
    text.remove_prefix(3);
  }
  if (!IsUtf8(text)) {
    *storage = FromWindows1252(text);
    text = *storage;
  }
  const bool has_nul = text.find('\0') != std::string_view::npos;
  const bool ends_in_cr =
      text.find('\n') == std::string_view::npos && text.find('\r') != std::string_view::npos;
  if (!has_nul && !ends_in_cr) return text;
  std::string changed(text);
  std::erase(changed, '\0');
  if (ends_in_cr) std::ranges::replace(changed, '\r', '\n');
  *storage = std::move(changed);
  return *storage;
}

}  // namespace haptometer::trial
