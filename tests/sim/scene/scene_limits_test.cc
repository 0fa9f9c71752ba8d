// What a scene's numbers may be, and what of them excludes each other.

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <regex>
#include <string>
#include <vector>

#include "sim/scene/scene_file.h"

namespace haptometer::sim {
namespace {

const std::string kActuator = "[actuator]\nmodel = 'thesis-c10-100'\n";
const std::string kSkin = "[skin]\nstiffness_n_per_m = 600\ndamping_n_s_per_m = 0.75\n";
const std::string kDrive = "[drive]\nkind = 'sine'\namplitude_v = 5\nfrequency_hz = 225\n";
const std::string kCone = kActuator + kSkin + kDrive;

// "scene.toml:12: x" as "scene.toml: x"
std::string WithoutLine(const std::string& error) {
  return std::regex_replace(error, std::regex("^scene\\.toml:[0-9]+:"), "scene.toml:");
}

std::string ErrorOf(const std::string& text) {
  const auto scene = ReadSceneText(text, "scene.toml");
  return scene ? "no error" : scene.error().Text();
}

struct EndsOfANumber {
  std::string before;  // the scene up to the number
  std::vector<std::string> taken, refused;
};

// each end of a range is taken, what is a hundredth beyond is not
TEST(SceneFile, TakesNumbersUpToTheEndsOfTheirRanges) {
  const std::string stops = kCone + "[travel_stops]\ngap_m = '1mm'\n";
  const std::string law = kActuator + kDrive + "[skin]\nlaw = 'power'\nrange = 'text'\n";
  const std::vector<EndsOfANumber> cases = {
      {kActuator + kDrive + "[skin]\ndamping_n_s_per_m = 0.75\nstiffness_n_per_m = ",
       {"1e9", "1e-9", "0"},
       {"1.01e9", "0.99e-9"}},
      {kCone + "[run]\ntolerance = ", {"1e-11", "0.99"}, {"0.99e-11", "1"}},
      {kCone + "[run]\nduration_s = ", {"1e6"}, {"1.01e6"}},
      {kCone + "[sensor]\nkind = 'stream'\naverages = ", {"1", "65536"}, {"0", "65537"}},
      {kCone + "[sensor]\nkind = 'stream'\nseed = ", {"0", "1"}, {"-1"}},
      {stops + "restitution = ", {"0", "1"}, {"-0.01", "1.01"}},
      {stops + "stiffness_n_per_m = ", {"1", "1e11"}, {"0.99", "1.01e11"}},
      {kCone + "[stiffening]\ncubic_n_per_m3 = ", {"1", "1e15"}, {"0.99", "1.01e15"}},
      {kCone + "[coil_heating]\nheat_capacity_j_per_k = 1\nresistance_per_k = ",
       {"0", "1"},
       {"-0.01", "1.01"}},
      {law + "contact_area_m2 = ", {"1e-6", "100e-6"}, {"0.99e-6", "101e-6"}}};
  for (const auto& [before, taken, refused] : cases) {
    for (const std::string& number : taken) {
      EXPECT_EQ(ErrorOf(before + number + "\n"), "no error") << before << number;
    }
    for (const std::string& number : refused) {
      EXPECT_NE(ErrorOf(before + number + "\n"), "no error") << before << number;
    }
  }
}

// An actuator's numbers have these ends too; masses and inductances end sooner, at 1e6 kg and H.
TEST(SceneFile, RefusesAnActuatorThatNoneIs) {
  const std::vector<std::string> keys = {
      "moving_mass_kg",         "case_mass_kg",   "stiffness_n_per_m", "damping_n_s_per_m",
      "force_constant_n_per_a", "resistance_ohm", "inductance_h"};
  const auto reads = [&](const std::string& key, const std::string& number) {
    std::string text = "[actuator]\n";
    for (const std::string& each : keys) text += each + " = " + (each == key ? number : "1") + "\n";
    return ErrorOf(text + kSkin + kDrive) == "no error";
  };
  for (const std::string& key : keys) {
    EXPECT_TRUE(reads(key, "1e-9")) << key;
    EXPECT_FALSE(reads(key, "0.99e-9")) << key;
    EXPECT_FALSE(reads(key, "1.01e9")) << key;
  }
  for (const std::string key : {"stiffness_n_per_m", "damping_n_s_per_m"}) {
    EXPECT_TRUE(reads(key, "1e9")) << key;
  }
}

// the mover rests 1.4 g 9.80665 m/s^2 / 2800 N/m = 4.903 um nearer to the upper stop
TEST(SceneFile, RefusesAStartBeyondAStop) {
  const auto error_of = [](const std::string& start, const std::string& gravity) {
    return WithoutLine(ErrorOf(kCone +
                               "[travel_stops]\ngap_up_m = '100um'\ngap_down_m = '200um'\n"
                               "restitution = 0.5\n[effects]\ntravel_stops = true\n" +
                               gravity + "[start]\n" + start));
  };
  const std::string none = "no error", weight = "gravity = true\n";
  EXPECT_EQ(error_of("mover_m = '99.9um'\n", ""), none);
  EXPECT_EQ(error_of("mover_m = '100um'\n", ""), none) << "it touches the stop";
  EXPECT_EQ(error_of("mover_m = '-200um'\n", ""), none) << "it touches the stop";
  EXPECT_EQ(error_of("mover_m = '100.1um'\n", ""),
            "scene.toml: [start]: mover_m: puts the mover 100.1 um from where its spring is "
            "unloaded, beyond a stop; it is measured from where the mover rests");
  EXPECT_EQ(error_of("mover_m = '-199.9um'\n", ""), none);
  EXPECT_NE(error_of("mover_m = '-200.1um'\n", ""), none);
  EXPECT_EQ(error_of("case_m = '-99.9um'\n", ""), none) << "it counts from the case";
  EXPECT_NE(error_of("case_m = '-100.1um'\n", ""), none);
  EXPECT_EQ(error_of("mover_m = '1mm'\ncase_m = '1mm'\n", ""), none);
  EXPECT_EQ(error_of("mover_m = '95um'\n", weight), none);
  EXPECT_NE(error_of("mover_m = '95.2um'\n", weight), none);
  EXPECT_EQ(error_of("mover_m = '-204.8um'\n", weight), none);
  EXPECT_NE(error_of("mover_m = '-205um'\n", weight), none);
}

TEST(SceneFile, RefusesACurrentThatNoInductanceKeeps) {
  const auto error_of = [](const std::string& inductance_h, const std::string& effects) {
    std::string text = "[actuator]\n";
    for (const char* key : {"moving_mass_kg", "case_mass_kg", "stiffness_n_per_m",
                            "damping_n_s_per_m", "force_constant_n_per_a", "resistance_ohm"}) {
      text += std::string(key) + " = 1\n";
    }
    return WithoutLine(ErrorOf(text + "inductance_h = " + inductance_h + "\n" + kSkin + kDrive +
                               "[start]\ncurrent_a = 0.1\n" + effects));
  };
  EXPECT_EQ(error_of("1e-6", ""), "no error");
  EXPECT_EQ(error_of("0", ""),
            "scene.toml: [start]: current_a: needs an inductance, and inductance_h is 0; remove "
            "it: the current follows the voltage at once");
  EXPECT_EQ(error_of("1e-6", "[effects]\ninductance = false\n"),
            "scene.toml: [start]: current_a: needs an inductance, which [effects] turns off; "
            "remove it: the current follows the voltage at once");
}

// what a grip carries of a weight is not known, and so the preload is not
TEST(SceneFile, RefusesAContactWhosePressAGripShares) {
  const auto error_of = [](const std::string& preload, const std::string& effects,
                           const std::string& stiffness) {
    return WithoutLine(ErrorOf(kActuator + preload + kDrive + kSkin +
                               "contact = 'unilateral'\npreload_n = 0.05\n[mounting]\n"
                               "kind = 'grip'\ndamping_n_s_per_m = 1\nstiffness_n_per_m = " +
                               stiffness + "\n" + effects));
  };
  const std::string none = "no error", gravity = "[effects]\ngravity = true\n";
  EXPECT_EQ(error_of("", "", "100"), none) << "nothing but the stated preload presses";
  EXPECT_EQ(error_of("", gravity, "0"), none) << "nothing carries it";
  EXPECT_EQ(error_of("", gravity, "100"),
            "scene.toml: [skin]: preload_n: is given with gravity and a grip, which carries part "
            "of the weight; leave gravity out and give the whole preload");
  EXPECT_EQ(error_of("preload_n = 0.1\n", "", "100"),
            "scene.toml: [skin]: preload_n: is given with the mover's preload and a grip, which "
            "carries part of it; leave one of the two out");
}

// hanging by 0.02 N on 2 g of weight, 0.0196133 N
TEST(SceneFile, TakesAPreloadThatJustCarriesTheBodies) {
  const auto reads = [](const std::string& preload) {
    return ErrorOf(kActuator + kDrive + kSkin + "contact = 'unilateral'\npreload_n = " + preload +
                   "\n[effects]\ngravity = true\n[gravity]\n"
                   "acceleration_m_per_s2 = -9.80665\n") == "no error";
  };
  EXPECT_TRUE(reads("0.01962"));
  EXPECT_FALSE(reads("0.01961"));
}

TEST(SceneFile, RefusesAPreloadOfBodiesThatNothingHolds) {
  const std::string loaded = kActuator + "preload_n = 0.1\n" + kDrive;
  const std::string loose = "[skin]\nstiffness_n_per_m = 0\ndamping_n_s_per_m = 1\n";
  EXPECT_EQ(WithoutLine(ErrorOf(loaded + loose)),
            "scene.toml: [actuator]: preload_n: pushes bodies that nothing holds in their place; "
            "give [skin] a stiffness, or hold the case in [mounting]");
  EXPECT_EQ(ErrorOf(loaded + kSkin), "no error");
  EXPECT_EQ(ErrorOf(loaded + loose + "[mounting]\nkind = 'held'\n"), "no error");
}

TEST(SceneFile, RefusesWhatAHeldCaseDoesNotMove) {
  const std::string held = "[mounting]\nkind = 'held'\n";
  EXPECT_EQ(ErrorOf(kCone + held), "no error");
  EXPECT_EQ(WithoutLine(ErrorOf(kCone + held +
                                "[adapter]\nmotor_side_mass_kg = 1e-3\nskin_side_mass_kg = 1e-3\n"
                                "stiffness_n_per_m = 8200\ndamping_n_s_per_m = 0.01\n")),
            "scene.toml: [mounting]: kind: holds the case, and an adapter would not move; remove "
            "[adapter], or hold the case by a grip");
  EXPECT_EQ(WithoutLine(ErrorOf(kActuator + kDrive + kSkin +
                                "contact = 'unilateral'\npreload_n = 1\n" + held)),
            "scene.toml: [skin]: preload_n: presses on a skin that a held case does not move; "
            "leave contact_loss out");
  for (const std::string key : {"case_m", "case_m_per_s"}) {
    EXPECT_NE(ErrorOf(kCone + held + "[start]\n" + key + " = 1e-5\n"), "no error") << key;
  }
  EXPECT_EQ(ErrorOf(kCone + held + "[start]\nmover_m = 1e-5\n"), "no error");
}

// readings fall on samples: 10 kHz divided by a whole number, to 1e-9
TEST(SceneFile, TakesRatesThatDivideTheSampling) {
  const auto reads = [](const std::string& rate) {
    return ErrorOf(kCone + "[sensor]\nkind = 'stream'\nrate_hz = " + rate + "\n") == "no error";
  };
  EXPECT_TRUE(reads("10000") && reads("5000") && reads("3333.3333333333335") && reads("100"));
  EXPECT_FALSE(reads("3333.33"));
  EXPECT_FALSE(reads("9900"));
  EXPECT_FALSE(reads("15000"));
  for (const double sign : {1.0, -1.0}) {
    EXPECT_TRUE(reads(fmt::format("{}", 1e4 / (3 * (1 + sign * 0.995e-9)))));
    EXPECT_FALSE(reads(fmt::format("{}", 1e4 / (3 * (1 + sign * 1.005e-9)))));
  }
}

// gravity and what has either sign, by magnitude
TEST(SceneFile, TakesNumbersOfEitherSignUpToTheirEnds) {
  const std::vector<EndsOfANumber> cases = {
      {kCone + "[gravity]\nacceleration_m_per_s2 = ",
       {"1e9", "-1e9", "1e-9", "-1e-9"},
       {"1.01e9", "-1.01e9", "0.99e-9", "-0.99e-9", "0"}},
      {kCone + "[start]\ncurrent_a = ",
       {"1e9", "-1e9", "1e-9", "-1e-9", "0"},
       {"1.01e9", "-1.01e9", "0.99e-9", "-0.99e-9"}},
      {kActuator + "preload_n = ", {"1e-9", "-1e-9", "0"}, {"0.99e-9", "-0.99e-9"}}};
  for (const auto& [before, taken, refused] : cases) {
    const std::string behind = before.starts_with(kCone) ? "\n" : "\n" + kSkin + kDrive;
    for (const std::string& number : taken) {
      EXPECT_EQ(ErrorOf(before + number + behind), "no error") << before << number;
    }
    for (const std::string& number : refused) {
      EXPECT_NE(ErrorOf(before + number + behind), "no error") << before << number;
    }
  }
}

}  // namespace
}  // namespace haptometer::sim
