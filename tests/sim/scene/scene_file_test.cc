#include "sim/scene/scene_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <regex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/linear/steady_state.h"
#include "tests/residual.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::sim {
namespace {

const std::string kActuator = "[actuator]\nmodel = 'thesis-c10-100'\n";
const std::string kSkin = "[skin]\nstiffness_n_per_m = 600\ndamping_n_s_per_m = 0.75\n";
const std::string kDrive = "[drive]\nkind = 'sine'\namplitude_v = 5\nfrequency_hz = 225\n";
const std::string kCone = kActuator + kSkin + kDrive;

Scene Read(const std::string& text) {
  const auto scene = ReadSceneText(text, "scene.toml");
  EXPECT_TRUE(scene) << scene.error().Text();
  return scene.value_or(Scene{});
}

// "scene.toml:12: x" as "scene.toml: x"
std::string WithoutLine(const std::string& error) {
  return std::regex_replace(error, std::regex("^scene\\.toml:[0-9]+:"), "scene.toml:");
}

std::string ErrorOf(const std::string& text) {
  const auto scene = ReadSceneText(text, "scene.toml");
  return scene ? "no error" : scene.error().Text();
}

TEST(SceneFixtures, GiveTheThreeBars) {
  const auto rms_m = [](const char* name) {
    const auto scene = ReadSceneFile(std::string(HAPTOMETER_FIXTURES "/") + name);
    EXPECT_TRUE(scene) << scene.error().Text();
    return scene ? SolveSteadyState(*scene).skin_rms_m : 0;
  };
  EXPECT_EQ(rms_m("lra_adapter.toml"), SolveSteadyState(tests::AdapterScene()).skin_rms_m);
  EXPECT_EQ(rms_m("lra_cone.toml"), SolveSteadyState(tests::ConeScene()).skin_rms_m);
  EXPECT_EQ(rms_m("lra_direct.toml"), SolveSteadyState(tests::DirectScene()).skin_rms_m);
}

TEST(SceneFile, AnActuatorIsNamedAsWhatItIs) {
  EXPECT_EQ(
      ErrorOf("moving_mass_kg = '1.4 g'\ncase_mass_kg = '0.6 g'\n"),
      "scene.toml: is an actuator, and no scene; name it in a scene, in its table [actuator]: "
      "file = \"scene.toml\"");
}

TEST(SceneFile, TakesNumbersAndTextsWithUnits) {
  const Scene scene =
      Read(kActuator + "[skin]\nstiffness_n_per_m = '0.6 N/mm'\n" + "damping_n_s_per_m = 0.75\n" +
           "[drive]\nkind = 'sine'\namplitude_v = '5000mV'\n" + "frequency_hz = '0.225 kHz'\n" +
           "[adapter]\nmotor_side_mass_kg = '0.25g'\nskin_side_mass_kg = '4.35 g'\n" +
           "stiffness_n_per_m = 8200\ndamping_n_s_per_m = 0.01\n");
  EXPECT_REL(scene.skin.stiffness_n_per_m, 600, 3e-16, "one rounding of the unit's factor");
  EXPECT_REL(scene.drive.amplitude_v, 5, 3e-16, "one rounding of the unit's factor");
  EXPECT_REL(scene.drive.frequency_hz, 225, 3e-16, "one rounding of the unit's factor");
  ASSERT_TRUE(scene.adapter);
  EXPECT_REL(scene.adapter->skin_side_mass_kg, 4.35e-3, 3e-16, "one rounding");
}

TEST(SceneFile, ReadsTheSkinsLaw) {
  const Scene scene = Read(kActuator + kDrive +
                           "[skin]\ncontact_area_m2 = 78.5e-6\nlaw = 'power'\nrange = 'table'\n");
  const Skin expected = SkinUnderArea(78.5e-6, SkinRange::kTable);
  EXPECT_EQ(scene.skin.stiffness_n_per_m, expected.stiffness_n_per_m);
  EXPECT_EQ(scene.skin.damping_n_s_per_m, expected.damping_n_s_per_m);
}

TEST(SceneFile, StartsFromRestWhereADurationIsSet) {
  EXPECT_EQ(StartOf(Read(kCone)), Start::kSteady);
  EXPECT_EQ(StartOf(Read(kCone + "[run]\nduration_s = 0.1\n")), Start::kRest);
  EXPECT_EQ(StartOf(Read(kCone + "[run]\nduration_s = 0.1\nstart = 'steady'\n")), Start::kSteady);
  EXPECT_EQ(StartOf(Read(kCone + "[run]\nstart = 'rest'\n")), Start::kRest);
  EXPECT_EQ(Read(kCone + "[run]\nduration_s = '100ms'\n").duration_s, 0.1);
}

TEST(SceneFile, ReadsASensorOverItsKindsNumbers) {
  EXPECT_FALSE(Read(kCone).sensor);
  const Scene plain = Read(kCone + "[sensor]\nkind = 'stream'\n");
  ASSERT_TRUE(plain.sensor);
  EXPECT_EQ(plain.sensor->rate_hz, 1e4);
  EXPECT_EQ(plain.sensor->head.noise_rms_m, 0.5e-6);
  EXPECT_EQ(plain.sensor->target, SensorTarget::kSkin);
  const Scene full = Read(kCone +
                          "[sensor]\nkind = 'il-030'\ntarget = 'case'\nrate_hz = 250\n"
                          "sampling_s = '2ms'\naverages = 4\nresolution_m = '10um'\n"
                          "noise_rms_m = 0\nlatency_s = '3ms'\nrange_m = '5mm'\nseed = 7\n");
  ASSERT_TRUE(full.sensor);
  EXPECT_EQ(full.sensor->target, SensorTarget::kCase);
  EXPECT_EQ(full.sensor->rate_hz, 250);
  EXPECT_EQ(full.sensor->head.sampling_s, 2e-3);
  EXPECT_EQ(full.sensor->head.averages, 4);
  EXPECT_REL(full.sensor->head.resolution_m, 10e-6, 3e-16, "one rounding");
  EXPECT_EQ(full.sensor->head.noise_rms_m, 0);
  EXPECT_EQ(full.sensor->latency_s, 3e-3);
  EXPECT_EQ(full.sensor->head.range_max_m, 5e-3);
  EXPECT_EQ(full.sensor->head.range_min_m, -5e-3);
  EXPECT_EQ(full.sensor->seed, 7U);
}

TEST(SceneFile, SamplesAnIdealSensorWhenItReads) {
  const Scene scene = Read(kCone + "[sensor]\nkind = 'ideal'\nrate_hz = 48000\n");
  EXPECT_EQ(scene.sensor->head.sampling_s, 1 / 48000.0);
  EXPECT_EQ(scene.sensor->head.noise_rms_m, 0);
  EXPECT_EQ(scene.sensor->head.range_max_m, std::numeric_limits<double>::infinity());
}

// its own time of sampling, where one is given, and then readings at a fraction of it
TEST(SceneFile, SamplesAnIdealSensorAsItSays) {
  const auto sensor = [](const std::string& text) {
    return Read(kCone + "[sensor]\nkind = 'ideal'\n" + text).sensor.value_or(Sensor{});
  };
  const Sensor both = sensor("rate_hz = 2000\nsampling_s = 1e-4\ntarget = 'mover'\n");
  EXPECT_EQ(both.rate_hz, 2000);
  EXPECT_EQ(both.head.sampling_s, 1e-4);
  EXPECT_EQ(both.target, SensorTarget::kMover);
  EXPECT_EQ(sensor("sampling_s = 5e-4\n").rate_hz, 2000);
  EXPECT_EQ(sensor("sampling_s = 5e-4\n").head.sampling_s, 5e-4);
}

// each of the seven, and a body's speed in m/s
TEST(SceneFile, ReadsEachNumberOfTheStateAtTheBeginning) {
  const InitialState initial =
      Read(kCone +
           "[adapter]\nmotor_side_mass_kg = 1e-3\nskin_side_mass_kg = 2e-3\n"
           "stiffness_n_per_m = 8200\ndamping_n_s_per_m = 0.01\n[start]\nmover_m = 1e-6\n"
           "mover_m_per_s = 2\ncase_m = 3e-6\ncase_m_per_s = -4\nskin_m = 5e-6\n"
           "skin_m_per_s = 6\ncurrent_a = -7e-3\n")
          .initial;
  EXPECT_EQ(initial.mover_m, 1e-6);
  EXPECT_EQ(initial.mover_m_per_s, 2);
  EXPECT_EQ(initial.case_m, 3e-6);
  EXPECT_EQ(initial.case_m_per_s, -4);
  EXPECT_EQ(initial.skin_m, 5e-6);
  EXPECT_EQ(initial.skin_m_per_s, 6);
  EXPECT_EQ(initial.current_a, -7e-3);
}

// a skin that only damps holds a preload for as long as the motion lasts
TEST(SceneFile, TakesAContactOnASkinThatOnlyDamps) {
  const Scene scene = Read(kActuator + kDrive +
                           "[skin]\nstiffness_n_per_m = 0\ndamping_n_s_per_m = 0.5\n"
                           "contact = 'unilateral'\npreload_n = 0.2\n");
  EXPECT_EQ(scene.effects[Effect::kContactLoss], Wish::kOn);
  EXPECT_EQ(scene.effects.contact_loss->preload_n, 0.2);
  EXPECT_EQ(scene.effects.gravity_m_per_s2, 9.80665) << "standard, unless it is stated";
}

// "unilateral" beside [effects] with it, or with it by its error: no contradiction
TEST(SceneFile, TakesAContactThatIsNamedTwice) {
  const auto wish = [](const std::string& contact, const std::string& effect) {
    return Read(kActuator + kDrive + kSkin + "preload_n = 0.2\ncontact = '" + contact +
                "'\n[effects]\ncontact_loss = " + effect + "\n")
        .effects[Effect::kContactLoss];
  };
  EXPECT_EQ(wish("unilateral", "true"), Wish::kOn);
  EXPECT_EQ(wish("unilateral", "'auto'"), Wish::kAuto);
  EXPECT_EQ(wish("bilateral", "false"), Wish::kOff);
}

TEST(SceneFile, TakesEffectsThatAreOff) {
  const Scene scene = Read(kCone +
                           "[effects]\ngravity = false\ntravel_stops = false\nstiffening = false\n"
                           "contact_loss = false\ntremor = false\ncoil_heating = false\n"
                           "inductance = true\n");
  EXPECT_EQ(scene.actuator.inductance_h, 130e-6);
  EXPECT_EQ(Read(kActuator + kDrive + kSkin + "contact = 'bilateral'\n").skin.stiffness_n_per_m,
            600);
}

TEST(SceneFile, ReadsEffectsAndTheirConstants) {
  const Scene scene =
      Read(kActuator + kDrive + kSkin +
           "contact = 'unilateral'\npreload_n = 0.07\n[effects]\ngravity = true\ntravel_stops = "
           "'auto'\n[gravity]\nacceleration_m_per_s2 = -9.8\n[travel_stops]\ngap_up_m = '0.3mm'\n"
           "restitution = 0.5\n[run]\ntolerance = 1e-6\nquantity = 'mover_peak_m'\n");
  EXPECT_EQ(scene.effects[Effect::kGravity], Wish::kOn);
  EXPECT_EQ(scene.effects[Effect::kTravelStops], Wish::kAuto);
  EXPECT_EQ(scene.effects[Effect::kContactLoss], Wish::kOn);
  EXPECT_EQ(scene.effects[Effect::kInductance], Wish::kOn);
  EXPECT_EQ(scene.effects.gravity_m_per_s2, -9.8);
  EXPECT_EQ(scene.effects.travel_stops->gap_up_m, 0.3e-3);
  EXPECT_EQ(scene.effects.travel_stops->gap_down_m, TravelStops::kNone);
  EXPECT_EQ(scene.effects.travel_stops->restitution, 0.5);
  EXPECT_EQ(scene.effects.contact_loss->preload_n, 0.07);
  EXPECT_EQ(scene.tolerance, 1e-6);
  EXPECT_EQ(scene.quantity, AskedQuantity::kMoverPeak);
}

TEST(SceneFile, ReadsSmoothEffectsAndTremor) {
  const Scene scene =
      Read("effects = 'auto'\n" + kCone +
           "[stiffening]\ncubic_n_per_m3 = 3e9\n[coil_heating]\nheat_capacity_j_per_k = 0.5\n"
           "thermal_resistance_k_per_w = 40\n[[tremor.tone]]\namplitude_m = '50um'\n"
           "frequency_hz = 9\n[[tremor.tone]]\namplitude_m = '10um'\nfrequency_hz = 18\n"
           "phase_rad = 1\n");
  for (const Effect effect : {Effect::kStiffening, Effect::kTremor, Effect::kCoilHeating}) {
    EXPECT_EQ(scene.effects[effect], Wish::kAuto);
  }
  EXPECT_EQ(scene.effects.stiffening->cubic_n_per_m3, 3e9);
  EXPECT_EQ(scene.effects.coil_heating->heat_capacity_j_per_k, 0.5);
  EXPECT_EQ(scene.effects.coil_heating->thermal_resistance_k_per_w, 40);
  EXPECT_EQ(scene.effects.coil_heating->resistance_per_k, CoilHeating::kCopperPerK);
  ASSERT_EQ(scene.finger.tones.size(), 2U);
  EXPECT_EQ(scene.finger.tones[1].phase_rad, 1);
  // without a way out for the heat; one tone by itself; off though stated
  const Scene other = Read(kCone +
                           "[coil_heating]\nheat_capacity_j_per_k = 2\n"
                           "resistance_per_k = 0\n[tremor]\namplitude_m = '1mm'\n"
                           "frequency_hz = 4\n");
  EXPECT_EQ(other.effects.coil_heating->thermal_resistance_k_per_w,
            std::numeric_limits<double>::infinity());
  EXPECT_EQ(other.effects.coil_heating->resistance_per_k, 0);
  ASSERT_EQ(other.finger.tones.size(), 1U);
  EXPECT_EQ(other.effects[Effect::kTremor], Wish::kOff);
}

TEST(SceneFile, TakesAnActuatorWithoutInductanceOrDamping) {
  const auto with = [](const std::string& damping, const std::string& inductance) {
    return "[actuator]\nmoving_mass_kg = '1.4g'\ncase_mass_kg = '0.6g'\nstiffness_n_per_m = 2800\n"
           "damping_n_s_per_m = " +
           damping +
           "\nforce_constant_n_per_a = 1\nresistance_ohm = 27\ninductance_h = " + inductance +
           "\n" + kSkin + kDrive;
  };
  EXPECT_EQ(Read(with("0.0322", "0")).actuator.inductance_h, 0);
  EXPECT_EQ(Read(with("0", "130e-6")).actuator.damping_n_s_per_m, 0);
  EXPECT_EQ(ErrorOf(with("0.0322", "-1e-6")),
            "scene.toml:8: [actuator]: inductance_h: must not be negative; check its sign");
}

TEST(SceneFile, AutoForAllAsksAboutWhatHasConstants) {
  const Scene scene =
      Read("effects = 'auto'\n" + kCone +
           "[travel_stops]\ngap_m = '1mm'\nstiffness_n_per_m = 1e6\ndamping_n_s_per_m = 2\n");
  EXPECT_EQ(scene.effects[Effect::kInductance], Wish::kAuto);
  EXPECT_EQ(scene.effects[Effect::kTravelStops], Wish::kAuto);
  EXPECT_EQ(scene.effects[Effect::kGravity], Wish::kOff);
  EXPECT_EQ(scene.effects[Effect::kContactLoss], Wish::kOff);
  EXPECT_EQ(scene.effects.travel_stops->damping_n_s_per_m, 2);
}

TEST(SceneFile, TellsWhatIsWrongWithEffects) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"[effects]\ntravel_stops = true\n",
       "[effects]: travel_stops: needs [travel_stops] with gap_m; docs/reference/scene.md "
       "lists the "
       "constants"},
      {"[effects]\ncontact_loss = 'auto'\n",
       "[effects]: contact_loss: needs preload_n in [skin]; docs/reference/scene.md lists the "
       "constants"},
      {"[effects]\ngravity = 'maybe'\n", "[effects]: gravity: \"maybe\" is not known; use auto"},
      {"[effects.travel_stops]\ngap_m = '1mm'\n",
       "[effects]: travel_stops: is a table; its constants stand in [travel_stops]"},
      {"[effects]\ngravitation = true\n",
       "[effects]: key gravitation is not known; did you mean gravity?"},
      {"[travel_stops]\nrestitution = 0.5\n",
       "[travel_stops]: gap_m: is missing; give gap_m, or gap_up_m, gap_down_m or both"},
      {"[travel_stops]\ngap_m = '1mm'\nrestitution = 1.5\n",
       "[travel_stops]: restitution: is not 0 to 1; speed after over speed before the impact"},
      {"[travel_stops]\ngap_m = '1mm'\ngap_up_m = '1mm'\nrestitution = 0\n",
       "[travel_stops]: gap_up_m: cannot be combined with gap_m; give one or the other"},
      {"[travel_stops]\ngap_m = '1mm'\nrestitution = 0\nstiffness_n_per_m = 1e5\n",
       "[travel_stops]: restitution: applies to rigid stops, which have no stiffness_n_per_m; give "
       "one or the other"},
      {"[travel_stops]\ngap_m = '1mm'\nrestitution = 0\ndamping_n_s_per_m = 1\n",
       "[travel_stops]: damping_n_s_per_m: needs stiffness_n_per_m; a rigid stop has restitution "
       "instead"},
      {"[gravity]\nacceleration_m_per_s2 = 0\n",
       "[gravity]: acceleration_m_per_s2: is 0; leave gravity out"},
      {"[run]\ntolerance = 2\n",
       "[run]: tolerance: is not 1e-11 or more and below 1; it is relative: 1e-3 asks for three "
       "digits"},
      {"[run]\nquantity = 'skin'\n",
       "[run]: quantity: \"skin\" is not known; use one of skin_rms_m, skin_waveform_m, "
       "mover_peak_m, current_rms_a"},
      {"[effects]\ntremor = true\n",
       "[effects]: tremor: needs [tremor] with amplitude_m and frequency_hz; "
       "docs/reference/scene.md "
       "lists "
       "the constants"},
      {"[effects]\nstiffening = 'auto'\n",
       "[effects]: stiffening: needs [stiffening] with cubic_n_per_m3; "
       "docs/reference/scene.md lists the "
       "constants"},
      {"[effects]\ncoil_heating = true\n",
       "[effects]: coil_heating: needs [coil_heating] with heat_capacity_j_per_k; "
       "docs/reference/scene.md lists the constants"},
      {"[stiffening]\ncubic_n_per_m3 = 0\n",
       "[stiffening]: cubic_n_per_m3: is not 1 to 1e15 N/m^3; the spring pulls stiffness_n_per_m d "
       "+ cubic_n_per_m3 d^3"},
      {"[stiffening]\ncubic = 1e9\n",
       "[stiffening]: key cubic is not known; did you mean cubic_n_per_m3?"},
      {"[coil_heating]\nheat_capacity_j_per_k = 0\n",
       "[coil_heating]: heat_capacity_j_per_k: must be greater than 0; check its sign"},
      {"[coil_heating]\nheat_capacity_j_per_k = 1\nresistance_per_k = 2\n",
       "[coil_heating]: resistance_per_k: is more than 1 per K; copper has 3.93e-3"},
      {"[tremor]\namplitude_m = '50um'\n",
       "[tremor]: frequency_hz: is missing; add it, in Hz or with a unit"},
      {"[mounting]\nkind = 'grounded'\n",
       "[mounting]: kind: \"grounded\" is not known; use one of free, grip, held, drop"},
      {"[mounting]\nkind = 'grip'\nstiffness_n_per_m = 100\n",
       "[mounting]: damping_n_s_per_m: is missing; add it, in N s/m or with a unit"}};
  for (const auto& [text, message] : cases) {
    EXPECT_EQ(WithoutLine(ErrorOf(kCone + text)), "scene.toml: " + message) << text;
  }
  const std::string needs =
      "scene.toml: [skin]: contact: needs preload_n in [skin]; docs/reference/scene.md lists "
      "the "
      "constants";
  const std::string unilateral = kActuator + kDrive + kSkin + "contact = 'unilateral'\n";
  EXPECT_EQ(WithoutLine(ErrorOf(unilateral)), needs);
  EXPECT_EQ(WithoutLine(ErrorOf("effects = 'auto'\n" + unilateral)), needs);
  EXPECT_EQ(WithoutLine(ErrorOf(kActuator + kDrive +
                                "[skin]\nstiffness_n_per_m = 0\ndamping_n_s_per_m = 0\n"
                                "preload_n = 1\n[effects]\ncontact_loss = true\n")),
            "scene.toml: [skin]: preload_n: presses on a skin without stiffness and damping; give "
            "it one of them");
  EXPECT_EQ(Read("effects = 'auto'\n" + kActuator + kDrive + kSkin +
                 "contact = 'bilateral'\npreload_n = 1\n")
                .effects[Effect::kContactLoss],
            Wish::kOff)
      << "bilateral is said";
  EXPECT_EQ(WithoutLine(ErrorOf(kActuator + kDrive + kSkin +
                                "contact = 'bilateral'\npreload_n = 1\n[effects]\n"
                                "contact_loss = true\n")),
            "scene.toml: [skin]: contact: \"bilateral\" contradicts contact_loss in [effects]; "
            "remove one of the two");
}

// the thesis's actuator hangs under the skin with its 1.4 g and 0.6 g: 19.6 mN; a preload of the
// mover takes its place
TEST(SceneFile, RefusesContactThatDoesNotCarryTheBodies) {
  const std::string hanging = kActuator + "preload_n = %\n" + kDrive + kSkin +
                              "contact = 'unilateral'\npreload_n = 0.01\n[effects]\n"
                              "gravity = true\n[gravity]\nacceleration_m_per_s2 = -9.80665\n";
  const auto error_with = [&](const std::string& preload) {
    std::string text = hanging;
    return WithoutLine(ErrorOf(text.replace(text.find('%'), 1, preload)));
  };
  EXPECT_EQ(error_with("0"),
            "scene.toml: [skin]: preload_n: does not carry the bodies' 0.0196 N of weight; they "
            "would fall off the skin");
  EXPECT_EQ(error_with("-0.005"),
            "scene.toml: [skin]: preload_n: does not carry the 0.0246 N that pull the bodies; they "
            "would fall off the skin");
}

TEST(SceneFile, TellsTheLineOfAFault) {
  EXPECT_EQ(ErrorOf("[actuator]\nmodel = 'thesis-c10-100'\n\n[drive]\nkind = 'sine'\n"
                    "amplitude_v = 5\nfrequency_hz = -3\n" +
                    kSkin),
            "scene.toml:7: [drive]: frequency_hz: must be greater than 0; check its sign");
}

TEST(SceneFile, TellsWhatIsWrongWithIt) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {kCone + "[adaptor]\n", "key adaptor is not known; did you mean adapter?"},
      {"[actuator]\nmodell = 'x'\n", "[actuator]: key modell is not known; did you mean model?"},
      {kActuator + kDrive, "has no [skin]; add that table (docs/reference/scene.md)"},
      {kSkin + kDrive, "has no [actuator]; add that table (docs/reference/scene.md)"},
      {kActuator + kSkin, "has no [drive]; add that table (docs/reference/scene.md)"},
      {"skin = 1\n" + kActuator + kDrive, "skin: is not a table; write [skin]"},
      {"[actuator]\nmodel = 'c10'\n" + kDrive + kSkin,
       "[actuator]: model: \"c10\" is not known; use thesis-c10-100"},
      {kActuator + "moving_mass_kg = 1\n" + kDrive + kSkin,
       "[actuator]: moving_mass_kg: cannot be combined with model; give one or the other"},
      {kActuator + kSkin + "[drive]\nkind = 'sine'\namplitude_v = 5\nfrequency_hz = 0\n",
       "[drive]: frequency_hz: must be greater than 0; check its sign"},
      {kActuator + kSkin + "[drive]\namplitude_v = 5\nfrequency_hz = 1\n",
       "[drive]: kind: is missing; write kind = \"sine\""},
      {kActuator + kSkin + "[drive]\nkind = 'sine'\namplitude_v = '5'\nfrequency_hz = '3mm'\n",
       "[drive]: frequency_hz: 'mm' is not a unit of a frequen"},
      {kActuator + kDrive + "[skin]\nstiffness_n_per_m = -1\ndamping_n_s_per_m = 1\n",
       "[skin]: stiffness_n_per_m: must not be negative; check its sign"},
      {kActuator + kDrive + "[skin]\nstiffness_n_per_m = 1e12\ndamping_n_s_per_m = 1\n",
       "[skin]: stiffness_n_per_m: 1e+12 is outside 1e-09 to 1e+09, where all scenes lie; check "
       "its unit"},
      {kActuator + kDrive + "[skin]\ncontact_area_m2 = 78.5\nlaw = 'power'\nrange = 'text'\n",
       "[skin]: contact_area_m2: is outside the law's 1e-6 to 100e-6 m2; give stiffness_n_per_m "
       "and damping_n_s_per_m instead"},
      {kActuator + kDrive + "[skin]\ncontact_area_m2 = 1e-6\nlaw = 'power'\n",
       "[skin]: range: is missing; \"text\" (600-2000 N/m) or \"table\" (600-1200 N/m)"},
      {kActuator + kDrive + "[skin]\ncontact_area_m2 = 1e-6\nrange = 'text'\n",
       "[skin]: law: is missing; write law = \"power\""},
      {kActuator + kDrive + kSkin + "law = 'power'\n",
       "[skin]: law: needs contact_area_m2; add it or remove this"},
      {kActuator + kDrive + kSkin + "contact_area_m2 = 1e-6\nlaw = 'power'\nrange = 'text'\n",
       "[skin]: stiffness_n_per_m: cannot be combined with contact_area_m2; give one or the other"},
      {kCone + "[run]\nduration_s = 1e7\n",
       "[run]: duration_s: is longer than 1e+06 s; leave it out for the steady state"},
      {kCone + "[run]\nstart = 'warm'\n",
       "[run]: start: \"warm\" is not known; use one of rest, steady"},
      {kCone + "[sensor]\nkind = 'stream'\nrate_hz = 3000\n",
       "[sensor]: rate_hz: is not 1/sampling_s = 10000 Hz divided by a whole number; change one "
       "of the two"},
      {kCone + "[sensor]\nkind = 'stream'\nrate_hz = 20000\n",
       "[sensor]: rate_hz: is not 1/sampling_s = 10000 Hz divided by a whole number; change one "
       "of the two"},
      {kCone + "[sensor]\ntarget = 'skin'\n",
       "[sensor]: kind: is missing; \"ideal\", \"il-030\" or \"stream\""},
      {kCone + "[sensor]\nkind = 'ideal'\naverages = 0\n",
       "[sensor]: averages: is not 1 to 65536; check it"},
      {kCone + "[sensor]\nkind = 'ideal'\nresolution_m = '1'\n",
       "[sensor]: resolution_m: '1' has no unit, and a length needs one; did you mean 1m?"},
      {kCone + "[effects]\ninductance = false\n[start]\ncurrent_a = 0.1\n",
       "[start]: current_a: needs an inductance, which [effects] turns off; remove it"},
      {kCone + "[start]\nskin_m = 1e-6\n",
       "[start]: skin_m: needs an [adapter]: without one the case is on the skin; give case_m and "
       "case_m_per_s"},
      {kCone + "[start]\nskin_m_per_s = 1e-6\n", "[start]: skin_m_per_s: needs an [adapter]"},
      {kCone + "[run]\nstart = 'steady'\n[start]\nmover_m = 1e-6\n",
       "[start]: mover_m: cannot be combined with start = \"steady\" in [run]; remove one of the "
       "two"},
      {kCone + "[mounting]\n",
       "[mounting]: kind: is missing; \"free\", \"grip\", \"held\" or \"drop\""},
      {"effects = 'on'\n" + kCone, "effects: \"on\" is not known; use auto"}};
  for (const auto& [text, message] : cases) {
    const std::string error = WithoutLine(ErrorOf(text));
    EXPECT_EQ(error.substr(0, ("scene.toml: " + message).size()), "scene.toml: " + message) << text;
    const auto scene = ReadSceneText(text, "scene.toml");
    ASSERT_FALSE(scene);
    EXPECT_EQ(scene.error().cause, Cause::kUsage) << text;
  }
}

// an area in the units of areas, in SI
TEST(SceneFile, TakesAreasWithTheirUnits) {
  const auto stiffness = [](const std::string& area) {
    return Read(kActuator + kDrive +
                "[skin]\nlaw = 'power'\nrange = 'text'\ncontact_area_m2 = " + area + "\n")
        .skin.stiffness_n_per_m;
  };
  EXPECT_EQ(stiffness("'10mm2'"), stiffness("10e-6"));
  EXPECT_EQ(stiffness("'0.1 cm2'"), stiffness("10e-6"));
  EXPECT_EQ(stiffness("'10e-6m2'"), stiffness("10e-6"));
}

TEST(SceneFile, OfBrokenTomlNamesThePlace) {
  const auto scene = ReadSceneText("[actuator\n", "scene.toml");
  ASSERT_FALSE(scene);
  EXPECT_EQ(scene.error().where.substr(0, 13), "scene.toml:1:");
  EXPECT_EQ(scene.error().cause, Cause::kCannotAnswer);
  // what is given twice is a wrong key
  EXPECT_EQ(ReadSceneText(kCone + kSkin, "scene.toml").error().cause, Cause::kUsage);
}

TEST(SceneFile, FindsAnActuatorFileBesideItself) {
  namespace fs = std::filesystem;
  const fs::path directory = fs::path(::testing::TempDir()) / "scene_file_test";
  fs::create_directories(directory);
  std::ofstream(directory / "mine.toml")
      << "moving_mass_kg = '2g'\ncase_mass_kg = '1g'\nresistance_ohm = 8\ninductance_h = '1uH'\n"
         "stiffness_n_per_m = 1000\ndamping_n_s_per_m = 0.1\nforce_constant_n_per_a = 2\n";
  std::ofstream(directory / "scene.toml") << "[actuator]\nfile = 'mine.toml'\n" + kSkin + kDrive;
  const auto scene = ReadSceneFile(directory / "scene.toml");
  ASSERT_TRUE(scene) << scene.error().Text();
  EXPECT_EQ(scene->actuator.stiffness_n_per_m, 1000);
  EXPECT_EQ(scene->actuator.resistance_ohm, 8);
  fs::remove(directory / "mine.toml");
  const auto gone = ReadSceneFile(directory / "scene.toml");
  ASSERT_FALSE(gone);
  EXPECT_EQ(gone.error().where, directory / "mine.toml");
  EXPECT_EQ(gone.error().cause, Cause::kCannotAnswer);
  fs::remove_all(directory);
}

TEST(SceneFile, ReadsEachSideOfTheStops) {
  const Scene down = Read(kCone + "[travel_stops]\ngap_down_m = '0.2mm'\nrestitution = 0.25\n");
  EXPECT_DOUBLE_EQ(down.effects.travel_stops->gap_down_m, 0.2e-3);
  EXPECT_EQ(down.effects.travel_stops->gap_up_m, TravelStops::kNone);
  EXPECT_TRUE(down.effects.travel_stops->rigid());
  const Scene both = Read(kCone +
                          "[travel_stops]\ngap_up_m = '0.1mm'\ngap_down_m = '0.2mm'\n"
                          "stiffness_n_per_m = 5e4\n");
  EXPECT_DOUBLE_EQ(both.effects.travel_stops->gap_up_m, 0.1e-3);
  EXPECT_DOUBLE_EQ(both.effects.travel_stops->gap_down_m, 0.2e-3);
  EXPECT_EQ(both.effects.travel_stops->stiffness_n_per_m, 5e4);
  EXPECT_EQ(both.effects.travel_stops->damping_n_s_per_m, 0);
  EXPECT_FALSE(both.effects.travel_stops->rigid());
}

TEST(SceneFile, ReadsEachWishByItsName) {
  for (const std::string_view name : kEffectNames) {
    const std::string all =
        "[gravity]\nacceleration_m_per_s2 = 9\n[travel_stops]\ngap_m = '1mm'\nrestitution = 0\n"
        "[stiffening]\ncubic_n_per_m3 = 1e9\n[tremor]\namplitude_m = '1um'\nfrequency_hz = 9\n"
        "[coil_heating]\nheat_capacity_j_per_k = 1\n";
    const std::string scene =
        kActuator + kDrive + kSkin + "preload_n = 1\n" + all + "[effects]\n" + std::string(name);
    for (const auto& [word, stated] : {std::pair{"true", Wish::kOn}, std::pair{"false", Wish::kOff},
                                       std::pair{"'auto'", Wish::kAuto}}) {
      const Effects effects = Read(scene + " = " + word + "\n").effects;
      for (std::size_t k = 0; k < kEffectNames.size(); ++k) {
        const Wish other = k == PlaceOf(Effect::kInductance) ? Wish::kOn : Wish::kOff;
        EXPECT_EQ(effects.wishes[k], kEffectNames[k] == name ? stated : other)
            << name << ' ' << word;
      }
    }
  }
}

}  // namespace
}  // namespace haptometer::sim
