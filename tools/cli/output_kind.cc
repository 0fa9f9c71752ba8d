#include "tools/cli/output_kind.h"

#include <fmt/core.h>

#include <cstdint>
#include <span>

#include "base/error.h"
#include "trial/byte_io.h"

namespace haptometer::cli {
namespace {

using std::string_view_literals::operator""sv;

constexpr std::string_view kMark = "made by haptometer ";
constexpr std::string_view kPngBegin = "\x89PNG\r\n\x1a\n";
constexpr std::string_view kPngEnd = "\0\0\0\0IEND\xae\x42\x60\x82"sv;
constexpr std::string_view kTextType = "tEXtSoftware\0"sv;

// what stands around the mark
struct Frame {
  std::string_view before;
  std::string_view after;
};

Frame FrameOf(std::string_view content) {
  if (content.starts_with("%PDF")) return {"% ", "\n"};
  return {"<!-- ", " -->\n"};
}

std::uint32_t CrcOf(std::string_view bytes) {
  return trial::Crc32(std::as_bytes(std::span(bytes)));
}

std::string BigEndian(std::uint32_t number) {
  std::string bytes;
  for (const int shift : {24, 16, 8, 0}) bytes += static_cast<char>((number >> shift) & 0xffU);
  return bytes;
}

std::string MarkOf(std::string_view before) {
  return fmt::format("{}{:08x}", kMark, CrcOf(before));
}

// length, type and data, CRC of type and data (PNG, third edition, 5.3)
std::string TextChunk(std::string_view text) {
  const std::string data = std::string(kTextType) + std::string(text);
  constexpr std::size_t kTypeBytes = 4;
  return BigEndian(static_cast<std::uint32_t>(data.size() - kTypeBytes)) + data +
         BigEndian(CrcOf(data));
}

// whether `content` is what Marked() makes of what stands before its mark
bool EndsWithMark(std::string_view content) {
  const std::size_t at = content.rfind(kMark);
  if (at == std::string_view::npos) return false;
  const bool is_png = content.starts_with(kPngBegin);
  const std::size_t frame = is_png ? 4 + kTextType.size() : FrameOf(content).before.size();
  if (at < frame) return false;
  const std::string_view before = content.substr(0, at - frame);
  return Marked(std::string(before) + std::string(is_png ? kPngEnd : "")) == content;
}

std::string_view WithoutComments(std::string_view text) {
  while (text.starts_with("# ")) {
    const std::size_t end = text.find('\n');
    if (end == std::string_view::npos) return {};
    text.remove_prefix(end + 1);
  }
  return text;
}

}  // namespace

std::string Marked(std::string content) {
  if (!content.starts_with(kPngBegin)) {
    const Frame frame = FrameOf(content);
    const std::string mark = MarkOf(content);
    content += frame.before;
    content += mark;
    content += frame.after;
    return content;
  }
  HAPTOMETER_CHECK(content.ends_with(kPngEnd), "a PNG of {} bytes without its end", content.size());
  content.resize(content.size() - kPngEnd.size());
  content += TextChunk(MarkOf(content));
  content += kPngEnd;
  return content;
}

bool IsWholePicture(std::string_view content) {
  if (content.starts_with(kPngBegin)) return content.ends_with(kPngEnd);
  while (content.ends_with('\n')) content.remove_suffix(1);
  if (content.starts_with("%PDF")) return content.ends_with("%%EOF");
  return content.starts_with("<?xml") && content.ends_with("</svg>");
}

bool IsOfKind(std::string_view content, const OutputKind& kind) {
  if (kind.is_marked) return content.starts_with(kind.begin) && EndsWithMark(content);
  if (content.empty()) return true;
  return (kind.has_comments ? WithoutComments(content) : content).starts_with(kind.begin);
}

}  // namespace haptometer::cli
