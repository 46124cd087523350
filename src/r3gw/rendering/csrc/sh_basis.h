// The basis of r3gw.lighting.sh with its derivatives, for sixteen directions at a time.
#pragma once

#include "native/csrc/simd.h"

namespace r3gw {

constexpr int sh_count(int degree) { return (degree + 1) * (degree + 1); }

constexpr double constant_sqrt(double value) {
  double root = value > 1.0 ? value : 1.0;
  for (int i = 0; i < 64; ++i) root = 0.5 * (root + value / root);
  return root;
}

// sqrt((2l+1)/(4 pi) (l-m)!/(l+m)!), times sqrt(2) for m > 0.
constexpr float sh_norm(int l, int m) {
  double ratio = 1.0;
  for (int i = l - m + 1; i <= l + m; ++i) ratio /= i;
  constexpr double kPi = 3.14159265358979323846;
  return static_cast<float>(constant_sqrt((2 * l + 1) / (4.0 * kPi) * ratio * (m > 0 ? 2.0 : 1.0)));
}

constexpr int kMaxShDegree = 4;

struct ShNorms {
  float at[kMaxShDegree + 1][kMaxShDegree + 1] = {};
  constexpr ShNorms() {
    for (int l = 0; l <= kMaxShDegree; ++l) {
      for (int m = 0; m <= l; ++m) at[l][m] = sh_norm(l, m);
    }
  }
};
constexpr ShNorms kShNorms;

// Values Y_i and, by x, y and z, the derivatives of the same polynomials that sh.basis evaluates.
template <int Degree>
struct ShBasis {
  Lanes value[sh_count(Degree)];
  Lanes by[3][sh_count(Degree)];

  R3GW_INLINE explicit ShBasis(const Lanes (&direction)[3]) {
    const Lanes x = direction[0], y = direction[1], z = direction[2];
    Lanes cos_m = splat(1.0f), sin_m{}, cos_before{}, sin_before{};  // (x + iy)^m, ^(m-1)
    float double_factorial = 1.0f;                                   // (2m - 1)!!
#pragma GCC unroll 8
    for (int m = 0; m <= Degree; ++m) {
      Lanes before{}, p = splat(double_factorial), slope_before{}, slope{};
#pragma GCC unroll 8
      for (int l = m; l <= Degree; ++l) {  // p is P_l^m(z) / (1 - z^2)^(m/2), slope its derivative
        const float norm = kShNorms.at[l][m], times_m = static_cast<float>(m);
        const Lanes scaled = norm * p, scaled_slope = norm * slope, turned = times_m * scaled;
        set(l * l + l + m, scaled * cos_m, turned * cos_before, -turned * sin_before,
            scaled_slope * cos_m);
        if (m > 0) {
          set(l * l + l - m, scaled * sin_m, turned * sin_before, turned * cos_before,
              scaled_slope * sin_m);
        }
        const float a = 2.0f * l + 1.0f, b = static_cast<float>(l + m), c = 1.0f / (l - m + 1);
        const Lanes next = (a * z * p - b * before) * c;
        const Lanes next_slope = (a * (p + z * slope) - b * slope_before) * c;
        before = p, p = next;
        slope_before = slope, slope = next_slope;
      }
      cos_before = cos_m, sin_before = sin_m;
      cos_m = x * cos_before - y * sin_before;
      sin_m = x * sin_before + y * cos_before;
      double_factorial *= 2.0f * m + 1.0f;
    }
  }

 private:
  R3GW_INLINE void set(int i, Lanes y, Lanes by_x, Lanes by_y, Lanes by_z) {
    value[i] = y;
    by[0][i] = by_x;
    by[1][i] = by_y;
    by[2][i] = by_z;
  }
};

}  // namespace r3gw
