#pragma once

// Written by tests/base/reference/elementary_tables.py, which derives each number; do not edit.

#include <array>
#include <cstdint>

// clang-format off
namespace haptometer::elementary {

struct ExpRow {
  double power;
  double tail;
};

struct LogRow {
  double inverse;
  double high;
  double low;
};

struct AtanRow {
  double high;
  double low;
};

struct ErfcRow {
  double high;
  double low;
  std::array<double, 14> slopes;
};

// ln 2 / 128, its high part of 35 bits; ln 2, its high part a multiple of 2^-42
inline constexpr double kExpStepHigh = 0x1.62e42fefc0000p-8;
inline constexpr double kExpStepLow = -0x1.c610ca86c3899p-44;
inline constexpr double kLn2High = 0x1.62e42fefa3800p-1;
inline constexpr double kLn2Low = 0x1.ef35793c76730p-45;
inline constexpr double kExpStepsPerUnit = 0x1.71547652b82fep+7;

// 1 / ln 10; 2 / sqrt(pi); pi / 2
inline constexpr double kPerLn10High = 0x1.bcb7b1526e50ep-2;
inline constexpr double kPerLn10Low = 0x1.95355baaafad3p-57;
inline constexpr double kErfSlopeHigh = 0x1.20dd750429b6dp+0;
inline constexpr double kErfSlopeLow = 0x1.1ae3a914fed80p-56;
inline constexpr double kHalfPiHigh = 0x1.921fb54442d18p+0;
inline constexpr double kHalfPiLow = 0x1.1a62633145c07p-54;

// pi / 2 as a sum: two parts of 30 bits, and the rest
inline constexpr double kHalfPiFirst = 0x1.921fb54800000p+0;
inline constexpr double kHalfPiSecond = -0x1.de973dd000000p-31;
inline constexpr double kHalfPiThird = 0x1.313198a2e0370p-61;
inline constexpr double kPerHalfPi = 0x1.45f306dc9c883p-1;

// cbrt 1, 2, 4
inline constexpr std::array<double, 3> kCbrtOfPowers{0x1p+0, 0x1.428a2f98d728bp+0, 0x1.965fea53d6e3dp+0};

// (e^r - 1 - r) / r^2, |r| <= ln 2 / 256; error below 2^-65.3 of the result
inline constexpr std::array<double, 4> kExpTail{
    0x1.ffffffffffdbdp-2, 0x1.555555555551ep-3, 0x1.55555cf14e726p-5, 0x1.111113f3a8ef3p-7,
};

// (e^x - 1 - x - x^2 / 2) / x^3, |x| <= 1/16; error below 2^-60.3 of the result
inline constexpr std::array<double, 7> kExpm1Tail{
    0x1.5555555555555p-3, 0x1.5555555555428p-5, 0x1.11111111239a1p-7, 0x1.6c16c1705354fp-10,
    0x1.a019efc936839p-13, 0x1.a01e284b62987p-16, 0x1.75341833b9203p-19,
};

// (log(1 + r) - r + r^2 / 2) / r^3, |r| <= 2^-7; error below 2^-72.9 of the result
inline constexpr std::array<double, 7> kLogTail{
    0x1.5555555555555p-2, -0x1.000000000003bp-2, 0x1.99999999a51c2p-3, -0x1.55555548414b0p-3,
    0x1.24924538c7576p-3, -0x1.0005f9c0a0a49p-3, 0x1.c7fd257d5dde7p-4,
};

// (sin r - r) / r^3 in r^2, |r| <= pi / 4; error below 2^-57.8 of the result
inline constexpr std::array<double, 6> kSinTail{
    -0x1.5555555555548p-3, 0x1.111111110f731p-7, -0x1.a01a019be9434p-13, 0x1.71de355551652p-19,
    -0x1.ae5e4ba6df801p-26, 0x1.5d8b60e76cebcp-33,
};

// (cos r - 1 + r^2 / 2) / r^4 in r^2, |r| <= pi / 4; error below 2^-63.7 of the result
inline constexpr std::array<double, 6> kCosTail{
    0x1.555555555554bp-5, -0x1.6c16c16c15015p-10, 0x1.a01a019c8f29fp-16, -0x1.27e4f7f195b39p-22,
    0x1.1ee9dbd2a0c05p-29, -0x1.8fa686ba4585cp-37,
};

// (sinh x - x) / x^3 in x^2, |x| <= 0.3; error below 2^-64.0 of the result
inline constexpr std::array<double, 5> kSinhTail{
    0x1.5555555555556p-3, 0x1.11111111109bap-7, 0x1.a01a01a64bd48p-13, 0x1.71de16a2929bdp-19,
    0x1.af1d0be38e28fp-26,
};

// (asinh x - x) / x^3 in x^2, |x| <= 1/4; error below 2^-65.3 of the result
inline constexpr std::array<double, 9> kAsinhTail{
    -0x1.5555555555554p-3, 0x1.3333333332cd0p-4, -0x1.6db6db6d0e275p-5, 0x1.f1c71be91a708p-6,
    -0x1.6e8b8389ef660p-6, 0x1.1c4a6888e424fp-6, -0x1.c8d9664e8911dp-7, 0x1.70741a43b5f58p-7,
    -0x1.e637183ceb4b7p-8,
};

// (atan t - t) / t^3 in t^2, |t| <= 1/63; error below 2^-71.8 of the result
inline constexpr std::array<double, 4> kAtanTail{
    -0x1.5555555555555p-2, 0x1.99999999922cfp-3, -0x1.249247ac5aa33p-3, 0x1.c6e3a78dd6786p-4,
};

// (erf x - 2 x / sqrt(pi)) / x^3 in x^2, |x| <= 1/2; error below 2^-62.7 of the result
inline constexpr std::array<double, 9> kErfTail{
    -0x1.812746b0379e6p-2, 0x1.ce2f21a042a6fp-4, -0x1.b82ce3127845ep-6, 0x1.565bcd086f71ap-8,
    -0x1.c02db177bc583p-11, 0x1.f9a27dacadc6ep-14, -0x1.f4b6b3d1ab901p-17, 0x1.b723c573baffap-20,
    -0x1.37b8c53b31761p-23,
};

// cbrt m, 1 <= m <= 2; error below 2^-13.7 of the result
inline constexpr std::array<double, 4> kCbrtStart{
    0x1.1b0ba5cb4f5a5p-1, 0x1.2c9a56e28b8cep-1, -0x1.4dc36b66c0d11p-3, 0x1.7a8e19f211e1fp-6,
};

// 2 / pi = sum of kBitsOfPerHalfPi[k] 2^(-32 (k + 1))
inline constexpr std::array<std::uint32_t, 40> kBitsOfPerHalfPi{
    0xa2f9836e, 0x4e441529, 0xfc2757d1, 0xf534ddc0, 0xdb629599, 0x3c439041, 0xfe5163ab, 0xdebbc561,
    0xb7246e3a, 0x424dd2e0, 0x06492eea, 0x09d1921c, 0xfe1deb1c, 0xb129a73e, 0xe88235f5, 0x2ebb4484,
    0xe99c7026, 0xb45f7e41, 0x3991d639, 0x835339f4, 0x9c845f8b, 0xbdf9283b, 0x1ff897ff, 0xde05980f,
    0xef2f118b, 0x5a0a6d1f, 0x6d367ecf, 0x27cb09b7, 0x4f463f66, 0x9e5fea2d, 0x7527bac7, 0xebe5f17b,
    0x3d0739f7, 0x8a5292ea, 0x6bfb5fb1, 0x1f8d5d08, 0x56033046, 0xfc7b6bab, 0xf0cfbc20, 0x9af4361d,
};

// 2^(k/128) = power (1 + tail)
inline constexpr std::array<ExpRow, 128> kExpTable{{
    {0x1p+0, 0},
    {0x1.0163da9fb3335p+0, 0x1.b3b4f1a88bf6ep-54},
    {0x1.02c9a3e778061p+0, -0x1.160139cd8dc5dp-56},
    {0x1.04315e86e7f85p+0, -0x1.05e7a108766d1p-54},
    {0x1.059b0d3158574p+0, 0x1.cd2523567f613p-55},
    {0x1.0706b29ddf6dep+0, -0x1.bce8023f98efap-55},
    {0x1.0874518759bc8p+0, 0x1.0f74e61e6c861p-57},
    {0x1.09e3ecac6f383p+0, 0x1.0a3e45b33d399p-54},
    {0x1.0b5586cf9890fp+0, 0x1.79aa65d837b6dp-54},
    {0x1.0cc922b7247f7p+0, 0x1.eb51a92fdeffcp-55},
    {0x1.0e3ec32d3d1a2p+0, 0x1.ebe3d702f9cd1p-60},
    {0x1.0fb66affed31bp+0, -0x1.a033489906e0bp-57},
    {0x1.11301d0125b51p+0, -0x1.556522a2fbd0ep-54},
    {0x1.12abdc06c31ccp+0, -0x1.080ef8c4eea55p-58},
    {0x1.1429aaea92de0p+0, -0x1.1c923b9d5f416p-54},
    {0x1.15a98c8a58e51p+0, 0x1.0d3e3e95c55afp-55},
    {0x1.172b83c7d517bp+0, -0x1.01b15eaa59348p-55},
    {0x1.18af9388c8deap+0, -0x1.f1ff055de323dp-55},
    {0x1.1a35beb6fcb75p+0, 0x1.b898c3f1353bfp-55},
    {0x1.1bbe084045cd4p+0, -0x1.6d99c7611eb26p-54},
    {0x1.1d4873168b9aap+0, 0x1.aecf73e3a2f60p-54},
    {0x1.1ed5022fcd91dp+0, -0x1.fe782cb86389dp-55},
    {0x1.2063b88628cd6p+0, 0x1.a6f4144a6c38dp-55},
    {0x1.21f49917ddc96p+0, 0x1.07a05b0e4047dp-55},
    {0x1.2387a6e756238p+0, 0x1.68efde3a8a894p-54},
    {0x1.251ce4fb2a63fp+0, 0x1.75e18f274487dp-55},
    {0x1.26b4565e27cddp+0, 0x1.0472b981fe7f2p-55},
    {0x1.284dfe1f56381p+0, -0x1.6b87b3f71085ep-54},
    {0x1.29e9df51fdee1p+0, 0x1.2f7e16d09ab31p-55},
    {0x1.2b87fd0dad990p+0, -0x1.d219b1a6fbffap-60},
    {0x1.2d285a6e4030bp+0, 0x1.b3782720c0ab4p-55},
    {0x1.2ecafa93e2f56p+0, 0x1.e149289cecb8fp-57},
    {0x1.306fe0a31b715p+0, 0x1.34d754db0abb6p-55},
    {0x1.32170fc4cd831p+0, 0x1.64201e2ac744cp-55},
    {0x1.33c08b26416ffp+0, 0x1.fdd395dd3f84ap-55},
    {0x1.356c55f929ff1p+0, -0x1.6a3803b8e5b04p-55},
    {0x1.371a7373aa9cbp+0, -0x1.24aedcc4b5068p-54},
    {0x1.38cae6d05d866p+0, -0x1.907f81b512d8ep-54},
    {0x1.3a7db34e59ff7p+0, -0x1.1d1e83e9436d2p-56},
    {0x1.3c32dc313a8e5p+0, -0x1.91919b3ce1b15p-54},
    {0x1.3dea64c123422p+0, 0x1.59f48a72a4c6dp-55},
    {0x1.3fa4504ac801cp+0, -0x1.312607a28698ap-54},
    {0x1.4160a21f72e2ap+0, -0x1.8a78f4817895bp-58},
    {0x1.431f5d950a897p+0, -0x1.c2c9b67499a1bp-56},
    {0x1.44e086061892dp+0, 0x1.363ed60c2ac11p-59},
    {0x1.46a41ed1d0057p+0, 0x1.666093b0664efp-54},
    {0x1.486a2b5c13cd0p+0, 0x1.ecce1daa10379p-57},
    {0x1.4a32af0d7d3dep+0, 0x1.3ff8e3f0f1230p-54},
    {0x1.4bfdad5362a27p+0, 0x1.690cebb7aafb0p-56},
    {0x1.4dcb299fddd0dp+0, 0x1.31dbdeb54e077p-54},
    {0x1.4f9b2769d2ca7p+0, -0x1.f94340071a38ep-55},
    {0x1.516daa2cf6642p+0, -0x1.7deccdc93a349p-55},
    {0x1.5342b569d4f82p+0, -0x1.8dec6bd0f385fp-56},
    {0x1.551a4ca5d920fp+0, -0x1.61246ec7b5cf6p-55},
    {0x1.56f4736b527dap+0, 0x1.3350518fdd78ep-54},
    {0x1.58d12d497c7fdp+0, 0x1.b98b72f8a9b05p-56},
    {0x1.5ab07dd485429p+0, 0x1.063e1e21c5409p-54},
    {0x1.5c9268a5946b7p+0, 0x1.4c7855019c6eap-60},
    {0x1.5e76f15ad2148p+0, 0x1.432e62b64c035p-54},
    {0x1.605e1b976dc09p+0, -0x1.ce44a6199769fp-55},
    {0x1.6247eb03a5585p+0, -0x1.c33c53bef4da8p-55},
    {0x1.6434634ccc320p+0, -0x1.45378892be9aep-55},
    {0x1.6623882552225p+0, -0x1.3cedd78565858p-54},
    {0x1.68155d44ca973p+0, 0x1.710aa807e1964p-58},
    {0x1.6a09e667f3bcdp+0, -0x1.3b3efbf5e2228p-54},
    {0x1.6c012750bdabfp+0, -0x1.a12ad8734b982p-57},
    {0x1.6dfb23c651a2fp+0, -0x1.367efb86da9eep-57},
    {0x1.6ff7df9519484p+0, -0x1.0dc3d54e08851p-55},
    {0x1.71f75e8ec5f74p+0, -0x1.81f647e5a3ecfp-56},
    {0x1.73f9a48a58174p+0, -0x1.6ee4ac08b7db0p-55},
    {0x1.75feb564267c9p+0, -0x1.619321e55e68ap-55},
    {0x1.780694fde5d3fp+0, 0x1.09ccb5e09d4d3p-54},
    {0x1.7a11473eb0187p+0, -0x1.b32dcb94da51dp-56},
    {0x1.7c1ed0130c132p+0, 0x1.4ecfd5467c06bp-54},
    {0x1.7e2f336cf4e62p+0, 0x1.5ebe1abd66c55p-57},
    {0x1.80427543e1a12p+0, -0x1.8a1c52fb3cf42p-55},
    {0x1.82589994cce13p+0, -0x1.369b6f13b3734p-54},
    {0x1.8471a4623c7adp+0, -0x1.05e843a19ff1ep-55},
    {0x1.868d99b4492edp+0, -0x1.4d450d872576ep-54},
    {0x1.88ac7d98a6699p+0, 0x1.0ad675b0e8a00p-54},
    {0x1.8ace5422aa0dbp+0, 0x1.db72fc1f0eab4p-55},
    {0x1.8cf3216b5448cp+0, -0x1.5b6609cc5e7ffp-57},
    {0x1.8f1ae99157736p+0, 0x1.bf68359f35f44p-56},
    {0x1.9145b0b91ffc6p+0, -0x1.3091fa71e3d83p-54},
    {0x1.93737b0cdc5e5p+0, -0x1.da9b88b6c1e29p-58},
    {0x1.95a44cbc8520fp+0, -0x1.c23f97c90b959p-57},
    {0x1.97d829fde4e50p+0, -0x1.2434322f4f9aap-54},
    {0x1.9a0f170ca07bap+0, -0x1.5ca6cd7668e4bp-55},
    {0x1.9c49182a3f090p+0, 0x1.1affc2b91ce27p-56},
    {0x1.9e86319e32323p+0, 0x1.dd235e10a73bbp-57},
    {0x1.a0c667b5de565p+0, -0x1.7c50422622263p-55},
    {0x1.a309bec4a2d33p+0, 0x1.b1c86e3e231d5p-55},
    {0x1.a5503b23e255dp+0, -0x1.1bbd1d3bcbb15p-54},
    {0x1.a799e1330b358p+0, 0x1.0cc319cee31d2p-54},
    {0x1.a9e6b5579fdbfp+0, 0x1.469846e735ab3p-55},
    {0x1.ac36bbfd3f37ap+0, -0x1.2dfcd978e9db4p-55},
    {0x1.ae89f995ad3adp+0, 0x1.c1a7792cb3387p-55},
    {0x1.b0e07298db666p+0, -0x1.07b8f4ad1d9fap-54},
    {0x1.b33a2b84f15fbp+0, -0x1.5c3d956dcaebap-58},
    {0x1.b59728de5593ap+0, -0x1.0a40e3da6f640p-54},
    {0x1.b7f76f2fb5e47p+0, -0x1.8d6f438ad9334p-57},
    {0x1.ba5b030a1064ap+0, -0x1.1eee26b588a35p-54},
    {0x1.bcc1e904bc1d2p+0, 0x1.4ffd70a5fddcdp-56},
    {0x1.bf2c25bd71e09p+0, -0x1.1bdfbfa9298acp-54},
    {0x1.c199bdd85529cp+0, 0x1.36eae30af0cb3p-56},
    {0x1.c40ab5fffd07ap+0, 0x1.ee3325c9ffd94p-55},
    {0x1.c67f12e57d14bp+0, 0x1.4e08fd10959acp-55},
    {0x1.c8f6d9406e7b5p+0, 0x1.3cdaf384e1a67p-57},
    {0x1.cb720dcef9069p+0, 0x1.76b2c6c921968p-57},
    {0x1.cdf0b555dc3fap+0, -0x1.08a1883ccb5d2p-55},
    {0x1.d072d4a07897cp+0, -0x1.fad5d3ffffa6fp-55},
    {0x1.d2f87080d89f2p+0, -0x1.00dae3875a949p-54},
    {0x1.d5818dcfba487p+0, 0x1.4a385a63d07a7p-56},
    {0x1.d80e316c98398p+0, -0x1.2919e2040220fp-55},
    {0x1.da9e603db3285p+0, 0x1.e5a50d5c192acp-55},
    {0x1.dd321f301b460p+0, 0x1.43a59ac016b4bp-55},
    {0x1.dfc97337b9b5fp+0, -0x1.2d52107b43e1fp-55},
    {0x1.e264614f5a129p+0, -0x1.92ab93b470dc9p-55},
    {0x1.e502ee78b3ff6p+0, 0x1.4b604603a88d3p-56},
    {0x1.e7a51fbc74c83p+0, 0x1.3c5ec519d7271p-55},
    {0x1.ea4afa2a490dap+0, -0x1.ff7128fd391f0p-55},
    {0x1.ecf482d8e67f1p+0, -0x1.dae98e223747dp-55},
    {0x1.efa1bee615a27p+0, 0x1.ec3bc41aa2008p-55},
    {0x1.f252b376bba97p+0, 0x1.42b94c3a9eb32p-55},
    {0x1.f50765b6e4540p+0, 0x1.a64a931d185eep-55},
    {0x1.f7bfdad9cbe14p+0, -0x1.e37bae43be3edp-55},
    {0x1.fa7c1819e90d8p+0, 0x1.7893b4d91cd9dp-56},
    {0x1.fd3c22b8f71f1p+0, 0x1.305c14160cc89p-58},
}};

// interval k of 128, of equal steps of the bits from 0.703125 to 1.40625: inverse about 1/m, -log(inverse)
// as a multiple of 2^-42 and the rest. inverse m - 1 is below 2^-7 and exact: inverse is a multiple of 2^-7
// below m = 1, of 2^-8 above.
inline constexpr std::array<LogRow, 128> kLogTable{{
    {0x1.6c00000000000p+0, -0x1.686c81e9b1000p-2, -0x1.2bb110af84054p-44},
    {0x1.6a00000000000p+0, -0x1.62c82f2b9c000p-2, -0x1.e54bdbd7c8a98p-44},
    {0x1.6800000000000p+0, -0x1.5d1bdbf581000p-2, 0x1.8d6bdc9c7c238p-44},
    {0x1.6600000000000p+0, -0x1.5767717456000p-2, 0x1.64ead9524d7cap-44},
    {0x1.6400000000000p+0, -0x1.51aad872e0000p-2, 0x1.f4bd8db0a7cc1p-44},
    {0x1.6200000000000p+0, -0x1.4be5f95778000p-2, 0x1.d7c92cd9ad824p-44},
    {0x1.6000000000000p+0, -0x1.4618bc21c6000p-2, 0x1.3d82f484c84ccp-46},
    {0x1.5e00000000000p+0, -0x1.404308686a000p-2, -0x1.f8ef43049f7d3p-44},
    {0x1.5c00000000000p+0, -0x1.3a64c55694000p-2, -0x1.7a71cbcd735d0p-44},
    {0x1.5a00000000000p+0, -0x1.347dd9a988000p-2, 0x1.5594dd4c58092p-45},
    {0x1.5800000000000p+0, -0x1.2e8e2bae12000p-2, 0x1.67b1e99b72bd8p-45},
    {0x1.5600000000000p+0, -0x1.2895a13de8000p-2, -0x1.a8d7ad24c13f0p-44},
    {0x1.5400000000000p+0, -0x1.22941fbcf8000p-2, 0x1.a6976f5eb0963p-44},
    {0x1.5200000000000p+0, -0x1.1c898c169a000p-2, 0x1.81410e5c62affp-44},
    {0x1.5000000000000p+0, -0x1.1675cababa000p-2, -0x1.8380e731f55c4p-44},
    {0x1.5000000000000p+0, -0x1.1675cababa000p-2, -0x1.8380e731f55c4p-44},
    {0x1.4e00000000000p+0, -0x1.1058bf9ae5000p-2, 0x1.4ab9d817d52cdp-44},
    {0x1.4c00000000000p+0, -0x1.0a324e2739000p-2, -0x1.c6bee7ef4030ep-47},
    {0x1.4a00000000000p+0, -0x1.0402594b4d000p-2, -0x1.036b89ef42d7fp-48},
    {0x1.4800000000000p+0, -0x1.fb9186d5e4000p-3, 0x1.d572aab993c87p-47},
    {0x1.4600000000000p+0, -0x1.ef0adcbdc6000p-3, 0x1.b26b79c86af24p-45},
    {0x1.4600000000000p+0, -0x1.ef0adcbdc6000p-3, 0x1.b26b79c86af24p-45},
    {0x1.4400000000000p+0, -0x1.e27076e2b0000p-3, 0x1.a342c2af0003cp-44},
    {0x1.4200000000000p+0, -0x1.d5c216b4fc000p-3, 0x1.1ba91bbca681bp-45},
    {0x1.4000000000000p+0, -0x1.c8ff7c79aa000p-3, 0x1.7794f689f8434p-45},
    {0x1.3e00000000000p+0, -0x1.bc286742d8000p-3, -0x1.9ac53f39d121cp-44},
    {0x1.3e00000000000p+0, -0x1.bc286742d8000p-3, -0x1.9ac53f39d121cp-44},
    {0x1.3c00000000000p+0, -0x1.af3c94e80c000p-3, 0x1.a4e633fcd9066p-52},
    {0x1.3a00000000000p+0, -0x1.a23bc1fe2c000p-3, 0x1.539cd91dc9f0bp-44},
    {0x1.3800000000000p+0, -0x1.9525a9cf46000p-3, 0x1.297137d9f158fp-44},
    {0x1.3800000000000p+0, -0x1.9525a9cf46000p-3, 0x1.297137d9f158fp-44},
    {0x1.3600000000000p+0, -0x1.87fa06520c000p-3, -0x1.22120401202fcp-44},
    {0x1.3400000000000p+0, -0x1.7ab890210e000p-3, 0x1.bdb9072534a58p-45},
    {0x1.3200000000000p+0, -0x1.6d60fe719e000p-3, 0x1.bc6e557134767p-44},
    {0x1.3200000000000p+0, -0x1.6d60fe719e000p-3, 0x1.bc6e557134767p-44},
    {0x1.3000000000000p+0, -0x1.5ff3070a7a000p-3, 0x1.8586f183bebf2p-44},
    {0x1.2e00000000000p+0, -0x1.526e5e3a1c000p-3, 0x1.790ba37fc5238p-44},
    {0x1.2e00000000000p+0, -0x1.526e5e3a1c000p-3, 0x1.790ba37fc5238p-44},
    {0x1.2c00000000000p+0, -0x1.44d2b6ccb8000p-3, 0x1.70cc16135783cp-46},
    {0x1.2a00000000000p+0, -0x1.371fc201e8000p-3, -0x1.ee8779b2d8abcp-44},
    {0x1.2a00000000000p+0, -0x1.371fc201e8000p-3, -0x1.ee8779b2d8abcp-44},
    {0x1.2800000000000p+0, -0x1.29552f8200000p-3, 0x1.5b967f4471dfcp-44},
    {0x1.2600000000000p+0, -0x1.1b72ad52f6000p-3, -0x1.e80a41811a396p-45},
    {0x1.2600000000000p+0, -0x1.1b72ad52f6000p-3, -0x1.e80a41811a396p-45},
    {0x1.2400000000000p+0, -0x1.0d77e7cd08000p-3, -0x1.cb2cd2ee2f482p-44},
    {0x1.2200000000000p+0, -0x1.fec9131dc0000p-4, 0x1.54555d1ae6607p-44},
    {0x1.2200000000000p+0, -0x1.fec9131dc0000p-4, 0x1.54555d1ae6607p-44},
    {0x1.2000000000000p+0, -0x1.e27076e2b0000p-4, 0x1.a342c2af0003cp-45},
    {0x1.1e00000000000p+0, -0x1.c5e548f5bc000p-4, -0x1.d0c57585fbe06p-46},
    {0x1.1e00000000000p+0, -0x1.c5e548f5bc000p-4, -0x1.d0c57585fbe06p-46},
    {0x1.1c00000000000p+0, -0x1.a926d3a4ac000p-4, -0x1.563650bd22a9cp-44},
    {0x1.1c00000000000p+0, -0x1.a926d3a4ac000p-4, -0x1.563650bd22a9cp-44},
    {0x1.1a00000000000p+0, -0x1.8c345d6318000p-4, -0x1.b20f5acb42a66p-44},
    {0x1.1800000000000p+0, -0x1.6f0d28ae58000p-4, 0x1.4b4641b664613p-44},
    {0x1.1800000000000p+0, -0x1.6f0d28ae58000p-4, 0x1.4b4641b664613p-44},
    {0x1.1600000000000p+0, -0x1.51b073f060000p-4, -0x1.83f69278e686ap-44},
    {0x1.1600000000000p+0, -0x1.51b073f060000p-4, -0x1.83f69278e686ap-44},
    {0x1.1400000000000p+0, -0x1.341d7961bc000p-4, -0x1.1d09299837610p-44},
    {0x1.1200000000000p+0, -0x1.16536eea38000p-4, 0x1.47c5e768fa309p-46},
    {0x1.1200000000000p+0, -0x1.16536eea38000p-4, 0x1.47c5e768fa309p-46},
    {0x1.1000000000000p+0, -0x1.f0a30c0118000p-5, 0x1.d599e83368e91p-45},
    {0x1.1000000000000p+0, -0x1.f0a30c0118000p-5, 0x1.d599e83368e91p-45},
    {0x1.0e00000000000p+0, -0x1.b42dd71198000p-5, 0x1.c827ae5d6704cp-46},
    {0x1.0e00000000000p+0, -0x1.b42dd71198000p-5, 0x1.c827ae5d6704cp-46},
    {0x1.0c00000000000p+0, -0x1.77458f6330000p-5, 0x1.181dce586af09p-44},
    {0x1.0a00000000000p+0, -0x1.39e87b9fe8000p-5, -0x1.eafd480ad9015p-44},
    {0x1.0a00000000000p+0, -0x1.39e87b9fe8000p-5, -0x1.eafd480ad9015p-44},
    {0x1.0800000000000p+0, -0x1.f829b0e780000p-6, -0x1.980267c7e09e4p-45},
    {0x1.0800000000000p+0, -0x1.f829b0e780000p-6, -0x1.980267c7e09e4p-45},
    {0x1.0600000000000p+0, -0x1.7b91b07d60000p-6, 0x1.3b955b602ace4p-44},
    {0x1.0600000000000p+0, -0x1.7b91b07d60000p-6, 0x1.3b955b602ace4p-44},
    {0x1.0400000000000p+0, -0x1.fc0a8b0fc0000p-7, -0x1.f1e7cf6d3a69cp-50},
    {0x1.0400000000000p+0, -0x1.fc0a8b0fc0000p-7, -0x1.f1e7cf6d3a69cp-50},
    {0x1.0200000000000p+0, -0x1.fe02a6b100000p-8, -0x1.9e23f0dda40e4p-46},
    {0x1.0200000000000p+0, -0x1.fe02a6b100000p-8, -0x1.9e23f0dda40e4p-46},
    {0x1p+0, 0, 0},
    {0x1p+0, 0, 0},
    {0x1.fa00000000000p-1, 0x1.82448a3880000p-7, 0x1.4554412c584e0p-44},
    {0x1.f600000000000p-1, 0x1.432a925980000p-6, 0x1.98139928637fep-47},
    {0x1.f200000000000p-1, 0x1.c63d2ec150000p-6, -0x1.5439ce030a687p-44},
    {0x1.ee00000000000p-1, 0x1.252f32f8d0000p-5, 0x1.83e9ae021b67bp-45},
    {0x1.ea00000000000p-1, 0x1.67c94f2d48000p-5, 0x1.dac20827cca0cp-44},
    {0x1.e800000000000p-1, 0x1.894aa149f8000p-5, 0x1.9a19a8be97661p-44},
    {0x1.e400000000000p-1, 0x1.ccb73cddd8000p-5, 0x1.965c36e09f5fep-44},
    {0x1.e000000000000p-1, 0x1.08598b59e4000p-4, -0x1.7e5dd7009902cp-46},
    {0x1.dc00000000000p-1, 0x1.2aa04a4470000p-4, 0x1.7a48ba8b1cb41p-44},
    {0x1.da00000000000p-1, 0x1.3bdf5a7d20000p-4, -0x1.19bd0ad125895p-44},
    {0x1.d600000000000p-1, 0x1.5e95a4d978000p-4, 0x1.1cb7ce1d17171p-44},
    {0x1.d200000000000p-1, 0x1.8197e2f410000p-4, -0x1.c0fe460d20041p-44},
    {0x1.d000000000000p-1, 0x1.9335e5d594000p-4, 0x1.3115c3abd47dap-45},
    {0x1.cc00000000000p-1, 0x1.b6ac88dad4000p-4, 0x1.b1bdff50225c7p-44},
    {0x1.c800000000000p-1, 0x1.da72763844000p-4, 0x1.a89401fa71733p-46},
    {0x1.c600000000000p-1, 0x1.ec739830a0000p-4, 0x1.11fcba80cdd10p-44},
    {0x1.c200000000000p-1, 0x1.08598b59e4000p-3, -0x1.7e5dd7009902cp-45},
    {0x1.c000000000000p-1, 0x1.1178e8227e000p-3, 0x1.1ef78ce2d07f2p-45},
    {0x1.bc00000000000p-1, 0x1.23d712a49c000p-3, 0x1.00d238fd3df5cp-46},
    {0x1.ba00000000000p-1, 0x1.2d1610c868000p-3, 0x1.39d6ccb81b4a1p-47},
    {0x1.b600000000000p-1, 0x1.3fb45a5992000p-3, 0x1.19713c0cae559p-44},
    {0x1.b400000000000p-1, 0x1.4913d8333c000p-3, -0x1.53e43558124c4p-44},
    {0x1.b000000000000p-1, 0x1.5bf406b544000p-3, -0x1.27023eb68981cp-46},
    {0x1.ae00000000000p-1, 0x1.6574ebe8c2000p-3, -0x1.98c1d34f0f462p-44},
    {0x1.aa00000000000p-1, 0x1.7898d85444000p-3, 0x1.8e67be3dbaf3fp-44},
    {0x1.a800000000000p-1, 0x1.823c16551a000p-3, 0x1.e0ddb9a631e83p-46},
    {0x1.a600000000000p-1, 0x1.8beafeb390000p-3, -0x1.73d54aae92cd1p-47},
    {0x1.a200000000000p-1, 0x1.9f6c40708a000p-3, -0x1.337d94bcd3f43p-44},
    {0x1.a000000000000p-1, 0x1.a93ed3c8ae000p-3, -0x1.8724350562169p-45},
    {0x1.9e00000000000p-1, 0x1.b31d8575bc000p-3, 0x1.c794e562a63cbp-44},
    {0x1.9a00000000000p-1, 0x1.c6ffbc6f00000p-3, 0x1.ee138d3a69d43p-44},
    {0x1.9800000000000p-1, 0x1.d1037f2656000p-3, -0x1.84a7e75b6f6e4p-47},
    {0x1.9600000000000p-1, 0x1.db13db0d48000p-3, 0x1.2806a847527e6p-44},
    {0x1.9400000000000p-1, 0x1.e530effe72000p-3, -0x1.fdbdbb13f7c18p-44},
    {0x1.9000000000000p-1, 0x1.f991c6cb3c000p-3, -0x1.90d04cd7cc834p-44},
    {0x1.8e00000000000p-1, 0x1.01eae5626c000p-2, 0x1.a43dcfade85aep-44},
    {0x1.8c00000000000p-1, 0x1.07138604d6000p-2, -0x1.e76324e912b17p-44},
    {0x1.8a00000000000p-1, 0x1.0c42d67616000p-2, 0x1.7188b163ceae9p-45},
    {0x1.8800000000000p-1, 0x1.1178e8227e000p-2, 0x1.1ef78ce2d07f2p-44},
    {0x1.8400000000000p-1, 0x1.1bf99635a7000p-2, -0x1.1ac89575c2125p-44},
    {0x1.8200000000000p-1, 0x1.214456d0ec000p-2, -0x1.caf0428b728a3p-44},
    {0x1.8000000000000p-1, 0x1.269621134e000p-2, -0x1.1b61f10522625p-44},
    {0x1.7e00000000000p-1, 0x1.2bef07cdc9000p-2, 0x1.a9cfa4a5004f4p-45},
    {0x1.7c00000000000p-1, 0x1.314f1e1d36000p-2, -0x1.8e27ad3213cb8p-45},
    {0x1.7a00000000000p-1, 0x1.36b6776be1000p-2, 0x1.16ecdb0f177c8p-46},
    {0x1.7800000000000p-1, 0x1.3c25277333000p-2, 0x1.83b54b606bd5cp-46},
    {0x1.7600000000000p-1, 0x1.419b423d5f000p-2, -0x1.ce379226de3ecp-44},
    {0x1.7400000000000p-1, 0x1.4718dc271c000p-2, 0x1.06c18fb4c14c5p-44},
    {0x1.7200000000000p-1, 0x1.4c9e09e173000p-2, -0x1.e20891b0ad8a4p-45},
    {0x1.7000000000000p-1, 0x1.522ae0738a000p-2, 0x1.ebe708164c759p-45},
    {0x1.6e00000000000p-1, 0x1.57bf753c8d000p-2, 0x1.fadedee5d40efp-46},
}};

// atan(k/32) = high + low
inline constexpr std::array<AtanRow, 33> kAtanTable{{
    {0, 0},
    {0x1.ffd55bba97625p-6, -0x1.5ec431444912cp-60},
    {0x1.ff55bb72cfdeap-5, -0x1.c934d86d23f1dp-60},
    {0x1.7ee182602f10fp-4, -0x1.cfb654c0c3d98p-58},
    {0x1.fd5ba9aac2f6ep-4, -0x1.cd37686760c17p-59},
    {0x1.3d6eee8c6626cp-3, 0x1.61a3b0ce9281bp-57},
    {0x1.7b97b4bce5b02p-3, 0x1.347b0b4f881cap-58},
    {0x1.b90d7529260a2p-3, 0x1.17b10d2e0e5abp-61},
    {0x1.f5b75f92c80ddp-3, 0x1.8ab6e3cf7afbdp-57},
    {0x1.18bf5a30bf178p-2, 0x1.30ca4748b1bf9p-57},
    {0x1.362773707ebccp-2, -0x1.963a544b672d8p-57},
    {0x1.530ad9951cd4ap-2, -0x1.2566480884082p-57},
    {0x1.6f61941e4def1p-2, -0x1.c63aae6f6e918p-56},
    {0x1.8b24d394a1b25p-2, 0x1.b6d0ba3748fa8p-56},
    {0x1.a64eec3cc23fdp-2, -0x1.24dec1b50b7ffp-56},
    {0x1.c0db4c94ec9f0p-2, -0x1.cc1ce70934c34p-56},
    {0x1.dac670561bb4fp-2, 0x1.a2b7f222f65e2p-56},
    {0x1.f40dd0b541418p-2, -0x1.a3992dc382a23p-57},
    {0x1.0657e94db30d0p-1, -0x1.d5b495f6349e6p-56},
    {0x1.1255d9bfbd2a9p-1, -0x1.2bdaee1c0ee35p-58},
    {0x1.1e00babdefeb4p-1, -0x1.928df287a668fp-58},
    {0x1.2958e59308e31p-1, -0x1.09e73b0c6c087p-56},
    {0x1.345f01cce37bbp-1, 0x1.1021137c71102p-55},
    {0x1.3f13fb89e96f4p-1, 0x1.ecf8b492644f0p-56},
    {0x1.4978fa3269ee1p-1, 0x1.2419a87f2a458p-56},
    {0x1.538f57b89061fp-1, -0x1.1bb74abda520cp-55},
    {0x1.5d58987169b18p-1, 0x1.0028e4bc5e7cap-57},
    {0x1.66d663923e087p-1, -0x1.6ea6febe8bbbap-56},
    {0x1.700a7c5784634p-1, -0x1.8c34d25aadef6p-56},
    {0x1.78f6bbd5d315ep-1, 0x1.406a089803740p-55},
    {0x1.819d0b7158a4dp-1, -0x1.bf76229d3b917p-56},
    {0x1.89ff5ff57f1f8p-1, -0x1.55b9a5e177a1bp-55},
    {0x1.921fb54442d18p-1, 0x1.1a62633145c07p-55},
}};

// e^(x^2) erfc x, four intervals an octave from 1/2 to 32: at the middle, high + low, and further
// coefficients of powers of t = x - middle; error below 2^-56.9
inline constexpr std::array<ErfcRow, 24> kErfcTable{{
    {0x1.2b84f076e14fbp-1, 0x1.b8bd1accf8123p-55,
     {-0x1.e18ab7052be7fp-2, 0x1.482bd9fad9ed0p-2, -0x1.8bed65e01718dp-3, 0x1.b1a22aa7a6dc0p-4,
      -0x1.b65943018044bp-5, 0x1.9dcc15144e60fp-6, -0x1.6ff6b38454b12p-7, 0x1.364eb297166f5p-8,
      -0x1.f301024d7cec7p-10, 0x1.80374a095db53p-11, -0x1.1c5271bcd97edp-12, 0x1.95aaaf8c0b634p-14,
      -0x1.1823544dcc261p-15, 0x1.763b2191a98dap-17}},
    {0x1.0fce4e96dd619p-1, -0x1.7210607953137p-57,
     {-0x1.97fe7bf1c60f0p-2, 0x1.071da7f78298dp-2, -0x1.2ecd75f4d05d4p-3, 0x1.3e0e0ed6b5f18p-4,
      -0x1.358dce2b361d2p-5, 0x1.1a31bff52474bp-6, -0x1.e5d3e4fd95c1ap-8, 0x1.8d62a9331d4afp-9,
      -0x1.366c6d2fe6eadp-10, 0x1.d1156c4735cafp-12, -0x1.4f4101a48cb14p-13, 0x1.d273f93117f7dp-15,
      -0x1.3a645b5df4630p-16, 0x1.9a4d1087e68f6p-18}},
    {0x1.f0723ff5acdf9p-2, -0x1.7b669ffa31576p-58,
     {-0x1.5cbc2c216df00p-2, 0x1.aa32b83507192p-3, -0x1.d43ed8ca5d7a1p-4, 0x1.d7f26045a23f1p-5,
      -0x1.ba6d691685b3fp-6, 0x1.859d3cc5fa92bp-7, -0x1.44bd2e2b88f54p-8, 0x1.01b062044ada9p-9,
      -0x1.87347d1337bb5p-11, 0x1.1d2927624dbb7p-12, -0x1.9085667ebc7cdp-14, 0x1.0fbd562c5e056p-15,
      -0x1.658fedf6001b9p-17, 0x1.c7ea4b6ea1e3fp-19}},
    {0x1.c7f81382721efp-2, -0x1.3f947ee724dfcp-62,
     {-0x1.2c84af7c10e14p-2, 0x1.5c775dfc44978p-3, -0x1.6dcc9e7a2c9b5p-4, 0x1.61fee765ff5d7p-5,
      -0x1.3fc8366a2e3f3p-6, 0x1.102167daf7951p-7, -0x1.b75cb1aca97f1p-9, 0x1.524f5c6cff9efp-10,
      -0x1.f329c42f73254p-12, 0x1.621c1d84edcb8p-13, -0x1.e49dda914ddb8p-15, 0x1.40b413440bb47p-16,
      -0x1.9bf6319e8f6f3p-18, 0x1.00a0af82c0203p-19}},
    {0x1.9531e09b149b5p-2, -0x1.aa513235e9c37p-58,
     {-0x1.e78b356770fbbp-3, 0x1.05e72521ca1b8p-3, -0x1.01343a2c92265p-4, 0x1.d4e711a2df97dp-6,
      -0x1.910a5d7c0a738p-7, 0x1.446c5166ccf5ep-8, -0x1.f38c6d04fd9ffp-10, 0x1.6fd9a57ab6010p-11,
      -0x1.041e390adbe24p-12, 0x1.62743c4192233p-14, -0x1.d2b1c60efe83dp-16, 0x1.2997275a769ecp-17,
      -0x1.72278937bbc96p-19, 0x1.bd70471ec862fp-21}},
    {0x1.5f88f52f3c76bp-2, -0x1.b7eb97a02d0e7p-57,
     {-0x1.797a639d8129dp-3, 0x1.701342cbcea7bp-4, -0x1.4bcdb9d9083c2p-5, 0x1.17eba60d31fcap-6,
      -0x1.bdf24bccac627p-8, 0x1.51ab9ffce7490p-9, -0x1.e8ae68b41256bp-11, 0x1.535f57fdf2da5p-12,
      -0x1.c5fa6b4faa7edp-14, 0x1.254ed210d5abbp-15, -0x1.6f055a0011209p-17, 0x1.bdb65669fb6f9p-19,
      -0x1.08501dcd1644dp-20, 0x1.2fe71ca9288d7p-22}},
    {0x1.3583f6644327bp-2, -0x1.88eb8ebfdccaep-56,
     {-0x1.2b11e6959934cp-3, 0x1.0a15ac2adab35p-4, -0x1.ba018e6428103p-6, 0x1.5a142948a9b2fp-7,
      -0x1.014eae28304b3p-8, 0x1.6d609f6ab13b6p-10, -0x1.f1b43d3aafd44p-12, 0x1.465ecd15a8696p-13,
      -0x1.9d62285c6e3f4p-15, 0x1.fafc8f70b5b27p-17, -0x1.2db32b19eb814p-18, 0x1.5d22d00097108p-20,
      -0x1.8b1ab15e88ceep-22, 0x1.b24bdaad1370bp-24}},
    {0x1.13e5743b60480p-2, 0x1.ca1dfca5d5331p-56,
     {-0x1.e36580c7f734ap-4, 0x1.8a6efeed233adp-5, -0x1.2ef92f6f10797p-6, 0x1.b99589d40f23dp-8,
      -0x1.33237c3eeacf2p-9, 0x1.99b60e42dd5a7p-11, -0x1.070e0cb5df686p-12, 0x1.4631c4b0af324p-14,
      -0x1.87a61e65ef5c8p-16, 0x1.c859482564a0ep-18, -0x1.0285d0e551559p-19, 0x1.1d4ee366c87bdp-21,
      -0x1.344d4615bc580p-23, 0x1.442d9acd0c4e4p-25}},
    {0x1.d94446d627932p-3, -0x1.a8198a8216449p-58,
     {-0x1.6a70d2bb37411p-4, 0x1.0615670e25a7bp-5, -0x1.6883f9919a179p-7, 0x1.da595561f7d32p-9,
      -0x1.2bd251bb2f799p-10, 0x1.6d7743d3b2f17p-12, -0x1.aed7ebc6d4759p-14, 0x1.ec773cc682a61p-16,
      -0x1.117a6a5f5a9a8p-17, 0x1.27af46517bc78p-19, -0x1.37b3d0ebc0d92p-21, 0x1.40e2096e195bap-23,
      -0x1.47399628bd723p-25, 0x1.4238e8778be9fp-27}},
    {0x1.8c9eb68ff27d7p-3, -0x1.bb4e763c64a35p-57,
     {-0x1.0305781330099p-4, 0x1.43b98bac83823p-6, -0x1.84e9ab30e6ab3p-8, 0x1.c2c72fd72763ep-10,
      -0x1.f99e41ecb0dd4p-12, 0x1.131bb1612578ep-13, -0x1.2312b2588053ep-15, 0x1.2bfb5b0def438p-17,
      -0x1.2da32c584b240p-19, 0x1.2856fcf254f2cp-21, -0x1.1ccbd4b77374fp-23, 0x1.0c12b2fc6f8adp-25,
      -0x1.f44283867051ep-28, 0x1.c4d0fa38c95b8p-30}},
    {0x1.54a7a08d4bb45p-3, -0x1.6a0d91336bdc9p-61,
     {-0x1.82a8522b868a1p-5, 0x1.a7eddc9ee6425p-7, -0x1.c24b49c47a2c4p-9, 0x1.d085857a17f33p-11,
      -0x1.d25ebba1c4adbp-13, 0x1.c882f023815e1p-15, -0x1.b45d025ef6bddp-17, 0x1.97dd78d6aa612p-19,
      -0x1.753cad42615a6p-21, 0x1.4ec0938b64342p-23, -0x1.26896dce8ab58p-25, 0x1.fcf425b42dc90p-28,
      -0x1.b436b65151e5dp-30, 0x1.6c1de6d729e32p-32}},
    {0x1.2a2af19c14930p-3, -0x1.fa04a06a33f29p-57,
     {-0x1.2aa6503acda11p-5, 0x1.22f0664f3cbf9p-7, -0x1.1434ae05873abp-9, 0x1.fff032a0df889p-12,
      -0x1.cfcdea1b1f611p-14, 0x1.9b50d0d260e2dp-16, -0x1.65778aacf12bdp-18, 0x1.30c2fb3fb6595p-20,
      -0x1.fe3e344fe3890p-23, 0x1.a3bee44c83886p-25, -0x1.5392b50a5f4dep-27, 0x1.0e5bedd670ec7p-29,
      -0x1.ab5f530764396p-32, 0x1.4a13335d37916p-34}},
    {0x1.f5b2a049cf4c6p-4, -0x1.fc4bbbfb1695ap-58,
     {-0x1.aa3eb6a946f7ep-6, 0x1.62c12cb5f7577p-8, -0x1.218ed930b239ap-10, 0x1.d00785f2ed4dcp-13,
      -0x1.6d54b133e1dafp-15, 0x1.1ad6a32df395ap-17, -0x1.aef8ea2825beap-20, 0x1.4354fb079d898p-22,
      -0x1.de0985254e968p-25, 0x1.5c64d4876d54fp-27, -0x1.f4c4d68de7790p-30, 0x1.6345cb2291333p-32,
      -0x1.fee5cbcae7c93p-35, 0x1.613df32b47859p-37}},
    {0x1.9d8a8f2284f2cp-4, -0x1.5b0277fa1ecb8p-58,
     {-0x1.238ca71b93fc3p-6, 0x1.95252b932efe3p-9, -0x1.15976ddda3c9dp-11, 0x1.774f4826dc852p-14,
      -0x1.f4e46d17a1e30p-17, 0x1.4a17e19bff5adp-19, -0x1.add7ac91b071bp-22, 0x1.149cd77bdd5c5p-24,
      -0x1.60002e1ef0109p-27, 0x1.bb09cccbbcfb4p-30, -0x1.13ce55f015bd9p-32, 0x1.53e93e287365bp-35,
      -0x1.a7111368968b7p-38, 0x1.feed8bc761ca9p-41}},
    {0x1.5f75c42e97171p-4, -0x1.a1eaaa8191c30p-58,
     {-0x1.a6e2cf277a0cbp-7, 0x1.f75ef7a0fb2dbp-10, -0x1.28787f0e7f4c6p-12, 0x1.59b29296c518cp-15,
      -0x1.8f23feccb801cp-18, 0x1.c871a15eb04e3p-21, -0x1.028f4644d2ebbp-23, 0x1.22467955dd981p-26,
      -0x1.43003b18e1c43p-29, 0x1.6450c3f826147p-32, -0x1.85b76e23be8aap-35, 0x1.a6c850faf431fp-38,
      -0x1.ce1abffccf1e2p-41, 0x1.ed3e37760fc44p-44}},
    {0x1.31742f4d8d4d3p-4, -0x1.f82bc955e371ap-59,
     {-0x1.404455ba9f3bep-7, 0x1.4d07bba601411p-10, -0x1.5783a27fad25ap-13, 0x1.5f8a69c9ddb98p-16,
      -0x1.64fcbb71542fdp-19, 0x1.67ca2bf7ead8ep-22, -0x1.67f14d33dd6aep-25, 0x1.657f396053cd5p-28,
      -0x1.608ea5f6f0055p-31, 0x1.5946794e59b93p-34, -0x1.4fd2d469d8158p-37, 0x1.4478d023b13d8p-40,
      -0x1.3b58905af7585p-43, 0x1.2cb269bcc656cp-46}},
    {0x1.fe6cc4a0f9538p-5, 0x1.c95be62ca9a6dp-59,
     {-0x1.c046699d77d51p-8, 0x1.876373f4a0f3ap-11, -0x1.53c131b5cb21dp-14, 0x1.254381038c882p-17,
      -0x1.f773505c76068p-21, 0x1.adc5f7f2a7f14p-24, -0x1.6ce662b936436p-27, 0x1.342c86fab7eb1p-30,
      -0x1.02e7fceb326ffp-33, 0x1.b0c952186082dp-37, -0x1.67af89286ff97p-40, 0x1.299aaa99e0d68p-43,
      -0x1.fc9d1ab530208p-47, 0x1.a090000ae489ep-50}},
    {0x1.a273c57e476cep-5, -0x1.6d026e15898ddp-59,
     {-0x1.2ddd3d589bfb0p-8, 0x1.b1c8923879d89p-12, -0x1.3672f098120aep-15, 0x1.baa1d9d8421e7p-19,
      -0x1.3a555d7a8af6fp-22, 0x1.bcbee2a20c5d7p-26, -0x1.39728615be803p-29, 0x1.b82d45065512cp-33,
      -0x1.33ef11b7d311ep-36, 0x1.ad454a20fec97p-40, -0x1.2a0ca14799993p-43, 0x1.9c84379cee3d4p-47,
      -0x1.23f99a5d45c3fp-50, 0x1.9133457038fa2p-54}},
    {0x1.627bcc27cb4aep-5, -0x1.d520e73ec05a6p-60,
     {-0x1.b1be47a913fc3p-9, 0x1.0898f73586fcfp-12, -0x1.41e750b2e0634p-16, 0x1.8682d21856143p-20,
      -0x1.d868cc70fcd1ep-24, 0x1.1cf1ff6c65992p-27, -0x1.56cb0dcf6d8e7p-31, 0x1.9b410bab65597p-35,
      -0x1.ec0bb2c8030bbp-39, 0x1.258f5487fdbf9p-42, -0x1.5d4b07f1c5c59p-46, 0x1.9e907b698ae34p-50,
      -0x1.f43dfa9f9976fp-54, 0x1.27460254b4008p-57}},
    {0x1.33714a024097ep-5, 0x1.f3b4d0ae3b609p-59,
     {-0x1.467f441a50cf9p-9, 0x1.59fa2994d54efp-13, -0x1.6dd369db39093p-17, 0x1.81fb2ba7eb240p-21,
      -0x1.96605f1ea371ap-25, 0x1.aaf0d3bb7316fp-29, -0x1.bf9951f640507p-33, 0x1.d445b87d47a43p-37,
      -0x1.e8e124846bf71p-41, 0x1.fd55f602d760ep-45, -0x1.08c14a0b28eaep-48, 0x1.12b3b0f87b533p-52,
      -0x1.20a5ccfa58d84p-56, 0x1.2a42b4934dbdep-60}},
    {0x1.005fe090c5e5dp-5, -0x1.4a17d4faf57b0p-59,
     {-0x1.c661852c5133ap-10, 0x1.920b4fb071805p-14, -0x1.6332593657797p-18, 0x1.3955a9a783c77p-22,
      -0x1.13fdbd8e4ffa4p-26, 0x1.e578451c64433p-31, -0x1.aa5619cf80101p-35, 0x1.75d9d4016628ap-39,
      -0x1.4758532b0e0fap-43, 0x1.1e339e790b499p-47, -0x1.f3606e1d21774p-52, 0x1.b356d7ec130fdp-56,
      -0x1.8b44c98d41b0ep-60, 0x1.578ae986c6cf3p-64}},
    {0x1.a3bc12161d4ebp-6, -0x1.b352d33781d73p-61,
     {-0x1.30a253d642e9cp-10, 0x1.b9bd9f029a792p-15, -0x1.3ff35b4b9df95p-19, 0x1.cf017aa140a39p-24,
      -0x1.4eabfd67aa6e6p-28, 0x1.e35421d7d176dp-33, -0x1.5ca8140d58810p-37, 0x1.f6830e8bcedc7p-42,
      -0x1.69c4a15ee3613p-46, 0x1.042ee43b1dc31p-50, -0x1.75c13b7ec812ep-55, 0x1.0c4513b73cf2ep-59,
      -0x1.8bd39319a7cfep-64, 0x1.1b88d3523c28ep-68}},
    {0x1.63438bf2c3ee9p-6, -0x1.1fc7374725534p-61,
     {-0x1.b49a775427ef7p-11, 0x1.0c15fcc6f7feap-15, -0x1.48fb6bc69793ap-20, 0x1.936a6b39ad221p-25,
      -0x1.ee543f9175d53p-30, 0x1.2ea50cffc47dcp-34, -0x1.724f1c724809ep-39, 0x1.c4c5dc21d6948p-44,
      -0x1.1499a439df4e1p-48, 0x1.51b5115962934p-53, -0x1.9bf308b2249d8p-58, 0x1.f63c0f60b070ap-63,
      -0x1.3841a57c0d81fp-67, 0x1.7c22bd9728b5dp-72}},
    {0x1.33f3abfd60d6fp-6, 0x1.060d74c72796bp-60,
     {-0x1.481e34f76a622p-11, 0x1.5d6955b46bd2ap-16, -0x1.73e1a60e21d15p-21, 0x1.8b940e583cbfdp-26,
      -0x1.a48dc5749613fp-31, 0x1.bedc4e961e5e5p-36, -0x1.da8d76ac1e6f9p-41, 0x1.f7af518742c09p-46,
      -0x1.0b282027a8115p-50, 0x1.1b3f63a7e70c6p-55, -0x1.2c1db254b7697p-60, 0x1.3dd887abe63e1p-65,
      -0x1.55aa548c1b710p-70, 0x1.697381bed3d3bp-75}},
}};
}  // namespace haptometer::elementary
// clang-format on
