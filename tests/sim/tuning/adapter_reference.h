// Written by adapter_reference.py; do not edit.
// clang-format off
#pragma once

namespace haptometer::tests {

// the best of all 3 200 000 points: places on the axes Ma1, Ma2, Ka, Ba, A; RMS
inline constexpr int kGridPlaces[5] = {19, 10, 15, 0, 0};
inline constexpr double kGridRmsM = 2.015860747195e-04;
inline constexpr int kStimulusGridPlaces[5] = {0, 12, 19, 0, 3};
inline constexpr double kStimulusGridRmsM = 1.452372865438e-04;

// optima over the continuous bounds, to 20 digits
inline constexpr double kRmsBestMa1 = 0.0002500000000000000052;
inline constexpr double kRmsBestMa2 = 0.0049205410705411217496;
inline constexpr double kRmsBestKa = 9276.1804352564655152;
inline constexpr double kRmsBestBa = 0.010000000000000000208;
inline constexpr double kRmsBestA = 9.9999999999999995475e-7;
inline constexpr double kRmsBest = 0.00020188526002182380689;
inline constexpr double kStimulusBestMa1 = 0.0017155396814823905164;
inline constexpr double kStimulusBestMa2 = 0.0065309272486146032553;
inline constexpr double kStimulusBestKa = 12000.0;
inline constexpr double kStimulusBestBa = 0.010000000000000000208;
inline constexpr double kStimulusBestA = 0.000012897528029026031577;
inline constexpr double kStimulusBest = 0.00015071241299263429607;
inline constexpr double kPowerBestMa1 = 0.0002500000000000000052;
inline constexpr double kPowerBestMa2 = 0.0064661458488983889144;
inline constexpr double kPowerBestKa = 12000.0;
inline constexpr double kPowerBestBa = 0.010000000000000000208;
inline constexpr double kPowerBestA = 0.000010338973853289985759;
inline constexpr double kPowerBest = 0.061426800856243698841;
inline constexpr double kPerWattBestMa1 = 0.0002500000000000000052;
inline constexpr double kPerWattBestMa2 = 0.0063027988321724332964;
inline constexpr double kPerWattBestKa = 12000.0;
inline constexpr double kPerWattBestBa = 0.010000000000000000208;
inline constexpr double kPerWattBestA = 9.9999999999999995475e-7;
inline constexpr double kPerWattBest = 0.00063457332392908417669;

// the largest RMS with a mover's travel of 0.4 mm; Ma1, Ba and A at their lower bounds
inline constexpr double kLimitedBestMa2 = 0.0026963446432770465672;
inline constexpr double kLimitedBestKa = 4798.936448881664303;
inline constexpr double kLimitedBest = 0.00016482179305968387359;

}  // namespace haptometer::tests
