// Readings on every wire, as the makers' formats write them, in pieces and damaged.
//
// What no damage touched must be read, in order. Lines have no checksum: damage of a line may fake
// another reading (a digit lost or replaced), at most one for each line that it touched and one
// more for each end of line that it put in. Modbus RTU has a CRC, which finds every burst of 16
// bits; lost or added bytes are found by the length. Binary samples and Modbus TCP have nothing
// against damage (what carries them has) and are only split.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/protocol/keyence/dl_en1.h"
#include "acquire/protocol/keyence/dl_rs1a.h"
#include "acquire/protocol/keyence/lkg.h"
#include "acquire/protocol/line_framer.h"
#include "acquire/protocol/modbus.h"
#include "acquire/protocol/sample_format.h"
#include "acquire/protocol/stream_line.h"
#include "tests/search/draws.h"

namespace haptometer::search {
namespace {

// bytes, and the reading in words of this file
struct Message {
  std::string bytes;
  std::string reading;
};

using Texts = std::vector<std::string>;

struct Wire {
  std::vector<Message> messages{};
  std::function<Texts(const Texts& pieces)> decode{};
};

// --- values as text ---

// what stands in place of a number, and its status
struct Code {
  std::string_view text;
  std::string_view status;
};

constexpr std::array<Code, 4> kRs1aCodes{
    {{"+99999", "over"}, {"-99999", "under"}, {"-99998", "invalid"}, {"+EEEEE", "device_error"}}};
constexpr std::array<Code, 4> kEn1Codes{{{"+099999999", "over"},
                                         {"-099999999", "under"},
                                         {"-099999998", "invalid"},
                                         {"+100000000", "device_error"}}};
constexpr std::array<Code, 4> kLetterCodes{{{"+FFFFFFF", "over"},
                                            {"-FFFFFFF", "under"},
                                            {"XXXXXXXX", "invalid"},
                                            {"--------", "invalid"}}};

struct Picture {
  std::size_t digits = 0;
  std::size_t decimals = 0;  ///< 0: no point
  std::span<const Code> codes{};
  bool codes_have_point = false;
};

// sign and digits; one of five is a code
Message DrawValue(Noise& draw, const Picture& picture) {
  Message message;
  const bool is_code = draw.Below(5) == 0;
  if (is_code) {
    const Code& code = picture.codes[draw.Below(picture.codes.size())];
    message = {std::string(code.text), fmt::format("{} ", code.status)};
  } else {
    message.bytes = draw.Below(2) == 0 ? "+" : "-";
    // no code of digits begins with 01 to 08 or 10 and a digit above 0
    message.bytes += fmt::format("0{}", 1 + draw.Below(8));
    while (message.bytes.size() <= picture.digits) {
      message.bytes += static_cast<char>('0' + draw.Below(10));
    }
    message.reading = fmt::format("{}e-{} ", std::stoi(message.bytes), picture.decimals);
  }
  if (picture.decimals > 0 && (!is_code || picture.codes_have_point)) {
    message.bytes.insert(message.bytes.size() - picture.decimals, ".");
  }
  return message;
}

std::string InWords(const acquire::Value& value) {
  if (!trial::IsMeasurement(value.status)) return fmt::format("{} ", trial::Name(value.status));
  return fmt::format("{}e-{} ", value.counts, value.decimals);
}

// --- lines ---

// head or number of the line, then values behind commas
struct LineFormat {
  std::string head{};
  std::size_t values = 1;
  bool has_outputs = false;  ///< two digits before each value
  bool is_counted = false;
  Picture picture{};
  acquire::Delimiter delimiter = acquire::Delimiter::kCr;
  std::size_t longest = 0;
  /// The reading of a line; an empty text: none.
  std::function<std::string(std::string_view)> read{};
};

Message DrawLine(Noise& draw, const LineFormat& format, int number) {
  Message message{format.head, ""};
  if (format.is_counted) message = {fmt::format("{:03}", number), fmt::format("{}: ", number)};
  for (std::size_t k = 0; k < format.values; ++k) {
    const Message value = DrawValue(draw, format.picture);
    const std::size_t outputs = format.has_outputs ? draw.Below(32) : 0;
    if (format.has_outputs) message.bytes += fmt::format(",{:02}", outputs);
    message.bytes += (message.bytes.empty() ? "" : ",") + value.bytes;
    message.reading += value.reading + fmt::format("{} ", outputs);
  }
  constexpr std::array<std::string_view, 3> kEnds{"\r", "\n", "\r\n"};
  message.bytes += kEnds[static_cast<std::size_t>(format.delimiter)];
  return message;
}

Wire DrawLines(Noise& draw, int count, const LineFormat& format) {
  Wire wire;
  for (int k = 0; k < count; ++k) wire.messages.push_back(DrawLine(draw, format, k));
  wire.decode = [format](const Texts& pieces) {
    acquire::LineFramer framer(format.delimiter, format.longest);
    Texts readings;
    for (const std::string& piece : pieces) {
      framer.Feed(piece);
      for (auto frame = framer.Next(); frame.framing != acquire::Framing::kNeedMore;
           frame = framer.Next()) {
        if (frame.framing != acquire::Framing::kValid) continue;
        if (std::string words = format.read(frame.text); !words.empty()) readings.push_back(words);
      }
    }
    return readings;
  };
  return wire;
}

// M0,+01.234,...  MS,04,+01.234,...  of some amplifiers
LineFormat DrawDlFormat() {
  const bool is_en1 = Flag("is_en1");
  const bool is_ms = Flag("has_outputs");
  const auto units = static_cast<std::size_t>(Whole("amplifiers", 1, 15));
  const auto decimals = static_cast<std::size_t>(Whole("decimals", 1, 3));
  const auto read = [=](std::string_view line) {
    const auto& spelling = is_en1 ? acquire::dl_en1::Spelling() : acquire::dl_rs1a::Spelling();
    const auto reply = acquire::dl::ParseReply(spelling, line);
    const auto kind = is_ms ? acquire::dl::ReplyKind::kMs : acquire::dl::ReplyKind::kM0;
    std::string words;
    // sensors refuse a reply of another number of amplifiers too
    if (!reply || reply->kind != kind || reply->units != units) return words;
    for (std::size_t k = 0; k < units; ++k) {
      words += InWords(reply->values[k]) + fmt::format("{} ", reply->outputs[k]);
    }
    return words;
  };
  return {.head = is_ms ? "MS" : "M0",
          .values = units,
          .has_outputs = is_ms,
          .picture = is_en1 ? Picture{9, 0, kEn1Codes} : Picture{5, decimals, kRs1aCodes, true},
          .delimiter = acquire::Delimiter::kCrLf,
          .longest = is_en1 ? acquire::dl_en1::kLongestLine : acquire::dl_rs1a::kLongestLine,
          .read = read};
}

// M1,+01.2345  M0,+01.2345,-00001.2
LineFormat DrawLkgFormat() {
  const std::size_t outs = Flag("two_outs") ? 2 : 1;
  const auto decimals = static_cast<std::size_t>(Whole("decimals", 1, 5));
  const auto read = [=](std::string_view line) {
    const auto reply = acquire::lkg::ParseReply(line);
    std::string words;
    if (!reply || reply->kind != acquire::lkg::ReplyKind::kCommand || reply->outs != outs) {
      return words;
    }
    for (std::size_t k = 0; k < outs; ++k) words += InWords(reply->values[k]) + "0 ";
    return words;
  };
  return {.head = outs == 2 ? "M0" : "M1",
          .values = outs,
          .picture = {6, decimals, kLetterCodes},
          .longest = acquire::lkg::kLongestLine,
          .read = read};
}

// +01.2345  017,+01.2345
LineFormat DrawStreamFormat() {
  acquire::StreamFormat format;
  format.delimiter = static_cast<acquire::Delimiter>(Whole("end", 0, 2));
  format.counter_digits = Flag("is_counted") ? 3 : 0;
  const bool is_counted = format.counter_digits > 0;
  const auto read = [=](std::string_view line) {
    const auto value = acquire::ParseStreamLine(format, line);
    if (!value) return std::string{};
    const std::string words = InWords(*value) + "0 ";
    return is_counted ? fmt::format("{}: {}", acquire::LineCount(format, line), words) : words;
  };
  return {.is_counted = is_counted,
          .picture = {6, 4, kLetterCodes},
          .delimiter = format.delimiter,
          .longest = acquire::LineWidth(format),
          .read = read};
}

// --- samples ---

// the lowest byte first
std::string LittleEndian(std::uint64_t bits, unsigned bytes) {
  std::string text;
  for (unsigned k = 0; k < bytes; ++k) text += static_cast<char>(bits >> (8 * k));
  return text;
}

// a sample of a pipe; its reading is the bits that a trial keeps
Message DrawSample(Noise& draw, acquire::SampleFormat format) {
  const double number = draw() * std::pow(10.0, static_cast<double>(draw.Below(20)) - 10);
  const auto words = [](std::uint64_t bits) { return fmt::format("{:x} ", bits); };
  const auto wide = std::bit_cast<std::uint64_t>(number);
  if (format == acquire::SampleFormat::kText) return {fmt::format("{:.17g}", number), words(wide)};
  if (format == acquire::SampleFormat::kF64) return {LittleEndian(wide, 8), words(wide)};
  if (format == acquire::SampleFormat::kF32) {
    const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(number));
    return {LittleEndian(bits, 4), words(bits)};
  }
  const auto counts = static_cast<std::int32_t>(draw.Below(65'536)) - 32'768;
  const auto bits = std::bit_cast<std::uint32_t>(counts);
  return {LittleEndian(bits, 2), words(bits)};
}

Wire DrawSamples(Noise& draw, int count, acquire::SampleFormat format) {
  const auto channels = static_cast<std::size_t>(Whole("channels", 1, 5));
  const bool is_text = format == acquire::SampleFormat::kText;
  Wire wire;
  for (int k = 0; k < count; ++k) {
    Message message;
    for (std::size_t c = 0; c < channels; ++c) {
      const Message sample = DrawSample(draw, format);
      message.bytes += (is_text && c > 0 ? ";" : "") + sample.bytes;
      message.reading += sample.reading;
    }
    if (is_text) message.bytes += "\n";
    wire.messages.push_back(message);
  }
  wire.decode = [=](const Texts& pieces) {
    acquire::SampleParser parser(format, std::vector<trial::RawLimits>(channels));
    std::vector<trial::Sample> row(channels);
    Texts readings;
    for (const std::string& piece : pieces) {
      parser.Feed(piece);
      for (auto state = parser.Next(row); state != acquire::RowState::kNeedMore;
           state = parser.Next(row)) {
        if (state != acquire::RowState::kRow) continue;
        readings.emplace_back();
        for (const trial::Sample& sample : row) {
          readings.back() += fmt::format("{:x} ", sample.raw.bits());
        }
      }
    }
    return readings;
  };
  return wire;
}

// --- in pieces and damaged ---

Texts Split(std::string_view bytes, Noise& draw, std::size_t longest) {
  Texts pieces;
  while (!bytes.empty()) {
    pieces.emplace_back(bytes.substr(0, draw.Below(longest)));
    bytes.remove_prefix(pieces.back().size());
  }
  return pieces;
}

// what damage did to the messages
struct Damage {
  std::vector<bool> is_touched;
  std::ptrdiff_t ends_put_in = 0;
};

// loses, puts in or replaces up to three bytes of one message
void DamageOne(Noise& draw, Wire& wire, Damage& damage) {
  // half of them are bytes that the lines themselves have
  constexpr std::string_view kUsual = "\r\n,.+-0123456789MSEFX;";
  const std::size_t which = draw.Below(wire.messages.size());
  std::string& bytes = wire.messages[which].bytes;
  const char end = bytes.empty() ? '\n' : bytes.back();
  const std::size_t at = draw.Below(bytes.size() + 1);
  const std::size_t length = 1 + draw.Below(3);
  const std::size_t kind = draw.Below(3);
  if (kind != 0) bytes.erase(at, length);
  for (std::size_t k = 0; k < length && kind != 1; ++k) {
    const char strange =
        draw.Below(2) == 0 ? kUsual[draw.Below(kUsual.size())] : static_cast<char>(draw.Below(256));
    bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at), strange);
    damage.ends_put_in += strange == '\r' || strange == '\n' ? 1 : 0;
  }
  damage.is_touched[which] = true;
  // without its end it runs into the next
  const bool has_end = !bytes.empty() && bytes.back() == end;
  if (!has_end && which + 1 < damage.is_touched.size()) damage.is_touched[which + 1] = true;
}

std::string Escaped(std::string_view bytes) {
  std::string text;
  for (const char byte : bytes) {
    const bool is_plain = byte >= ' ' && byte <= '~';
    text += is_plain ? std::string(1, byte)
                     : fmt::format("\\x{:02x}", static_cast<unsigned char>(byte));
  }
  return text;
}

void CheckWire(Wire wire, Noise& draw, int damages) {
  Damage damage{.is_touched = std::vector<bool>(wire.messages.size())};
  for (int k = 0; k < damages; ++k) DamageOne(draw, wire, damage);
  std::string bytes;
  for (const Message& message : wire.messages) bytes += message.bytes;
  const Texts readings = wire.decode(Split(bytes, draw, 40));
  const auto require = [&](std::string_view what, bool is_so) {
    if (is_so) return;
    std::string words(what);
    for (const std::string& reading : readings) words += "\n  " + reading;
    Require(fmt::format("{}\n  in {}", words, Escaped(bytes)), false);
  };
  require("any split gives the same readings", readings == wire.decode({bytes}));
  auto next = readings.begin();
  for (std::size_t k = 0; k < wire.messages.size(); ++k) {
    if (damage.is_touched[k]) continue;
    next = std::find(next, readings.end(), wire.messages[k].reading);
    require(fmt::format("message {}, {}, is read in its place", k, wire.messages[k].reading),
            next != readings.end());
    ++next;
  }
  const auto whole = std::ranges::count(damage.is_touched, false);
  const auto touched = std::ranges::count(damage.is_touched, true);
  require("no reading but what damage may fake",
          std::ssize(readings) <= whole + touched + damage.ends_put_in);
}

// --- Modbus ---

// x^16 + x^15 + x^2 + 1, the lowest bit first, from all ones (serial line specification V1.02)
std::string Crc(std::string_view bytes) {
  std::uint32_t crc = 0xffff;
  for (const char byte : bytes) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      const std::uint32_t in = (static_cast<unsigned char>(byte) >> bit) & 1U;
      crc = ((crc ^ in) & 1U) != 0 ? (crc >> 1U) ^ 0xa001U : crc >> 1U;
    }
  }
  return LittleEndian(crc, 2);
}

// unit, function, count of bytes and registers
std::string DrawReply(Noise& draw, const acquire::ReadRequest& request) {
  std::string reply{static_cast<char>(request.unit), static_cast<char>(request.function),
                    static_cast<char>(2 * request.count)};
  for (int k = 0; k < 2 * request.count; ++k) reply += static_cast<char>(draw.Below(256));
  return reply;
}

// a whole reply is read as it was sent, a damaged one is refused
void CheckRtu(Noise& draw, const acquire::ReadRequest& request) {
  std::string frame = DrawReply(draw, request);
  const std::string registers = frame.substr(3);
  frame += Crc(frame);
  const auto read = [&](const std::string& bytes) {
    return acquire::ParseReadReply(acquire::ModbusFraming::kRtu, request, bytes);
  };
  Require("a whole RTU reply is read",
          read(frame).fault == acquire::ModbusFault::kNone && read(frame).registers == registers);
  const std::size_t at = draw.Below(frame.size());
  const auto strange = static_cast<char>(1 + draw.Below(255));
  switch (draw.Below(3)) {
    case 0:
      frame.erase(at, 1 + draw.Below(3));
      break;
    case 1:
      frame.insert(at, 1 + draw.Below(3), strange);
      break;
    default:
      frame[at] = static_cast<char>(frame[at] ^ strange);
  }
  Require("a damaged RTU reply is refused", read(frame).fault != acquire::ModbusFault::kNone);
}

// replies one behind the other, with header: transaction, 0, length, each the high byte first
Wire DrawTcp(Noise& draw, const acquire::ReadRequest& request, int count) {
  Wire wire;
  for (int k = 0; k < count; ++k) {
    const std::string reply = DrawReply(draw, request);
    const std::string head{0,
                           static_cast<char>(k),
                           0,
                           0,
                           static_cast<char>(reply.size() >> 8U),
                           static_cast<char>(reply.size())};
    wire.messages.push_back({head + reply, Escaped(reply.substr(3))});
  }
  wire.decode = [request](const Texts& pieces) {
    constexpr auto kTcp = acquire::ModbusFraming::kTcp;
    acquire::ReadRequest asked = request;
    std::string waiting;
    Texts readings;
    for (const std::string& piece : pieces) {
      waiting += piece;
      for (auto adu = acquire::ParseAdu(kTcp, waiting); adu.state == acquire::AduState::kWhole;
           adu = acquire::ParseAdu(kTcp, waiting)) {
        const auto frame = std::string_view(waiting).substr(0, adu.bytes);
        const auto reply = acquire::ParseReadReply(kTcp, asked, frame);
        readings.push_back(Escaped(reply.registers));
        waiting.erase(0, adu.bytes);
        ++asked.transaction;
      }
    }
    return readings;
  };
  return wire;
}

void CheckModbus(Noise& draw, int count) {
  acquire::ReadRequest request;
  request.unit = static_cast<std::uint8_t>(Whole("slave", 1, 247));
  request.function = Flag("input_registers") ? 4 : 3;
  request.count = static_cast<std::uint16_t>(Whole("registers", 1, 125));
  for (int k = 0; k < count; ++k) CheckRtu(draw, request);
  CheckWire(DrawTcp(draw, request, count), draw, 0);
}

}  // namespace

bool WireCase() {
  const int protocol = Whole("protocol", 0, 7);
  const int count = Whole("messages", 1, 40);
  Noise draw(Whole("seed", 0, 1'000'000));
  if (protocol == 4) {
    CheckModbus(draw, count);
    return true;
  }
  constexpr std::array kSamples{acquire::SampleFormat::kText, acquire::SampleFormat::kF64,
                                acquire::SampleFormat::kF32, acquire::SampleFormat::kI16};
  const int damages = protocol <= 3 ? Whole("damages", 0, 3) : 0;
  const auto samples = static_cast<std::size_t>(std::max(protocol - 4, 0));
  const Wire wire = protocol == 0   ? DrawLines(draw, count, DrawStreamFormat())
                    : protocol == 1 ? DrawLines(draw, count, DrawDlFormat())
                    : protocol == 2 ? DrawLines(draw, count, DrawLkgFormat())
                                    : DrawSamples(draw, count, kSamples[samples]);
  CheckWire(wire, draw, damages);
  return true;
}

}  // namespace haptometer::search
