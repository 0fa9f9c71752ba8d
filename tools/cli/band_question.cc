#include "tools/cli/band_question.h"

#include "tools/cli/band.h"

namespace haptometer::cli {

void DeclareBand(Options* options, BandWords* words, Shown order_shown) {
  options->Text("--band", &words->band, "LOWER-UPPERHz", "Corners of the band-pass; 20-500Hz");
  options->Count("--order", &words->order, 1, dsp::kHighestOrder,
                 "Butterworth order, kept whatever it leaves settled (default: 6, lowered where a "
                 "record is too short for it)",
                 order_shown);
  options->Choice("--corner", &words->corner, {"whole", "each"},
                  "-3 dB at the corners of both passes together or of each", Shown::kHelpAll);
}

Result<dsp::BandQuestion> BandQuestionOf(const BandWords& words) {
  dsp::BandQuestion question;
  if (!words.band.empty()) {
    const auto band = ParseBand(words.band);
    if (!band) return std::unexpected(band.error());
    question.band.lower_hz = band->lower_hz;
    question.band.upper_hz = band->upper_hz;
  }
  question.may_lower_order = !words.order.has_value();
  // a manifest's order has passed through no option
  if (words.order && (*words.order < 1 || *words.order > dsp::kHighestOrder)) {
    return Usage("order", "lies outside 1 to 8", "write one within");
  }
  question.band.order = static_cast<int>(words.order.value_or(question.band.order));
  question.band.corners = words.corner == "each" ? dsp::Corners::kEach : dsp::Corners::kWhole;
  const auto possible = dsp::DesignBandPass(question.band, 4 * question.band.upper_hz);
  if (!possible) return std::unexpected(possible.error());
  return question;
}

}  // namespace haptometer::cli
