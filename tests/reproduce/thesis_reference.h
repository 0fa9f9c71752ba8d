// Written by thesis_reference.py; do not edit.
// clang-format off
#pragma once

#include <string_view>

namespace haptometer::tests {

struct ReferenceNumber {
  std::string_view key;
  double value;  // SI
};

inline constexpr ReferenceNumber kThesisReference[] = {
    {"rms-direct", 4.499076212730883e-05},
    {"rms-cone", 4.6100166397432036e-05},
    {"rms-adapter", 0.00020017620580604478},
    {"ratio-adapter-direct", 4.449273502849606},
    {"current", 0.12825766644981912},
    {"power", 0.45336711256270945},
    {"phase", 0.020167683320883416},
    {"current-reduction", 0.21746088073949854},
    {"power-reduction", 0.21739183913502147},
    {"rise-ratio", 10.900363724156943},
    {"amplitude-ratio", 4.449273502849606},
    {"start-ratio", 1.4601080801807031},
    {"latency-adapter", 0.05546803294650781},
    {"start-direct", 0.002479799173557053},
    {"start-cone", 0.0008776368218076757},
    {"start-adapter", 0.0036207748105360825},
    {"impedance-match", 221.19133341624095},
    {"impedance-ratio", 0.8193382443326185},
    {"sensitivity-Ma1", 5.767162710712537e-05},
    {"sensitivity-Ma2", 0.6029299898119158},
    {"sensitivity-Ka", 0.7713611837331151},
    {"sensitivity-Ba", 0.003694481381793846},
    {"sensitivity-Ks", 0.018594908348483208},
    {"sensitivity-Bs", 0.38162685174647026},
    {"receptors", 49.0},
    {"all-receptors-cell", 0.0033913729009698956},
    {"all-receptors-edge", 0.0049066017177982115},
    {"stimulus-adapter", 0.006242480904336529},
    {"stimulus-direct", 0.0022045473442381326},
    {"stimulus-ratio", 2.831638395361322},
    {"weight", 0.07354987499999999},
    {"sag", 0.000122583125},
    {"built-ia1", 2.1957056175319987},
    {"built-ia2", 4.248623036953301},
    {"gain-at-175hz", 0.5851244867672848},
    {"power-saving", 0.5644},
    {"power-possible", 0.9375},
    {"mover-travel-adapter", 0.000826268452713214},
    {"mover-travel-direct", 8.62940800602667e-05},
    {"contact-force", 0.34488560908319377},
    {"interpolated-direct", 4.407043710967163e-05},
    {"interpolated-cone", 4.520497233650174e-05},
    {"interpolated-adapter", 0.00019124171149710291},
    {"phase-without-reaction", 0.0021783928422569264},
};

}  // namespace haptometer::tests
