// Reference values of the thesis's own tool: csim of Scilab 6.1.1 (Debian's scilab-cli).
//
// The adapter scene and the direct scene from rest under 5 V at 225 Hz, the voltage given as a
// function, over 0.1 s at 10 kHz, of which every 50th output is kept; and the adapter scene after
// 1 s, when its transients are down to e^-41. Written from the equations of motion (J. Lindsay, "A
// Mechanical Amplifier for Haptic Feedback", University of Washington, 2013, equations 2.1-2.4 with
// the reaction +Km i on the case), not from the program. Once with csim's own tolerances, once with
// a relative 1e-12 and an absolute 1e-14.
//
//   scilab-cli -nb -f csim_reference.sce > csim_reference.h
//
// No test runs it, so that none needs Scilab; it takes some seconds. csim's own tolerances come
// from the sum of |v| over all outputs: the fewer are asked for, the tighter they are, and with 51
// over 1 s its integrator refuses them. They hold for combinations of the states, not for each;
// what they come to stands in agreement_test.cc.
mode(-1);

Mv = 1.4e-3; Mc = 0.6e-3; Kv = 2800; Bv = 0.0322; Km = 1; R = 27; L = 130e-6;
Ma1 = 0.25e-3; Ma2 = 4.35e-3; Ka = 8200; Ba = 0.01;

// xv, vv, xa, va, xs, vs, i
function sl = adapter(Ks, Bs)
  M = Mc + Ma1;
  a = [0 1 0 0 0 0 0
       -Kv/Mv -Bv/Mv Kv/Mv Bv/Mv 0 0 -Km/Mv
       0 0 0 1 0 0 0
       Kv/M Bv/M -(Kv+Ka)/M -(Bv+Ba)/M Ka/M Ba/M Km/M
       0 0 0 0 0 1 0
       0 0 Ka/Ma2 Ba/Ma2 -(Ka+Ks)/Ma2 -(Ba+Bs)/Ma2 0
       0 Km/L 0 -Km/L 0 0 -R/L];
  sl = syslin("c", a, [0; 0; 0; 0; 0; 0; 1/L], eye(7, 7));
endfunction

// xv, vv, xa, va, i
function sl = direct(Ks, Bs)
  a = [0 1 0 0 0
       -Kv/Mv -Bv/Mv Kv/Mv Bv/Mv -Km/Mv
       0 0 0 1 0
       Kv/Mc Bv/Mc -(Kv+Ks)/Mc -(Bv+Bs)/Mc Km/Mc
       0 Km/L 0 -Km/L -R/L];
  sl = syslin("c", a, [0; 0; 0; 0; 1/L], eye(5, 5));
endfunction

function v = volt(t)
  v = 5*sin(2*%pi*225*t);
endfunction

// every so many columns but the first
function put(name, x, every)
  [n, m] = size(x);
  rows = (m - 1)/every;
  mprintf("inline constexpr double k%s[%d][%d] = {\n", name, rows, n);
  for k = 1:rows
    mprintf("    {%s},\n", strcat(msprintf("%.17g\n", x(:, every*k + 1)), ", "));
  end
  mprintf("};\n");
endfunction

mprintf("// Written by csim_reference.sce; do not edit.\n");
mprintf("// clang-format off\n#pragma once\n\nnamespace haptometer::tests {\n\n");
mprintf("/// Every 5 ms up to 0.1 s: xv, vv, xa, va, xs, vs, i; without an adapter xv, vv, xa, va, i.\n");
t = (0:1000)/1e4;
long = (0:10000)/1e4;
tight = [1e-14 1e-12];
scenes = list(list("CsimAdapter", adapter(600, 0.75)), list("CsimDirect", direct(1861.2, 2.2185)));
for k = 1:2
  sl = scenes(k)(2);
  x0 = zeros(size(sl.A, 1), 1);
  [y, x] = csim(volt, t, sl, x0);
  put(scenes(k)(1), y, 50);
  [y, x] = csim(volt, t, sl, x0, tight);
  put(scenes(k)(1) + "Tight", y, 50);
end
mprintf("/// At 1 s, as above.\n");
sl = adapter(600, 0.75);
put("CsimAdapterLate", csim(volt, long, sl, zeros(7, 1)), 10000);
put("CsimAdapterLateTight", csim(volt, long, sl, zeros(7, 1), tight), 10000);
mprintf("\n}  // namespace haptometer::tests\n");
exit
