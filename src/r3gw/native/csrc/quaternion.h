// Quaternions wxyz as rotations, sixteen at a time, with their gradient.
#pragma once

#include "native/csrc/simd.h"

namespace r3gw {

// Scales q to unit length and returns one over its length.
R3GW_INLINE Lanes make_unit(Lanes (&q)[4]) {
  const Lanes inverse = 1.0f / square_root(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (Lanes& component : q) component *= inverse;
  return inverse;
}

R3GW_INLINE void rotation_from_unit_quaternion(const Lanes (&q)[4], Lanes (&r)[3][3]) {
  const Lanes w = q[0], x = q[1], y = q[2], z = q[3];
  r[0][0] = 1.0f - 2.0f * (y * y + z * z);
  r[0][1] = 2.0f * (x * y - w * z);
  r[0][2] = 2.0f * (x * z + w * y);
  r[1][0] = 2.0f * (x * y + w * z);
  r[1][1] = 1.0f - 2.0f * (x * x + z * z);
  r[1][2] = 2.0f * (y * z - w * x);
  r[2][0] = 2.0f * (x * z - w * y);
  r[2][1] = 2.0f * (y * z + w * x);
  r[2][2] = 1.0f - 2.0f * (x * x + y * y);
}

// Gradient of a unit quaternion from the gradient `g` of its rotation matrix.
R3GW_INLINE void unit_quaternion_gradient(const Lanes (&q)[4], const Lanes (&g)[3][3],
                                          Lanes (&gradient)[4]) {
  const Lanes w = q[0], x = q[1], y = q[2], z = q[3];
  const Lanes skew_x = g[2][1] - g[1][2], skew_y = g[0][2] - g[2][0], skew_z = g[1][0] - g[0][1];
  const Lanes even_x = g[2][1] + g[1][2], even_y = g[0][2] + g[2][0], even_z = g[1][0] + g[0][1];
  gradient[0] = 2.0f * (x * skew_x + y * skew_y + z * skew_z);
  gradient[1] = 2.0f * (y * even_z + z * even_y + w * skew_x - 2.0f * x * (g[1][1] + g[2][2]));
  gradient[2] = 2.0f * (x * even_z + z * even_x + w * skew_y - 2.0f * y * (g[0][0] + g[2][2]));
  gradient[3] = 2.0f * (x * even_y + y * even_x + w * skew_z - 2.0f * z * (g[0][0] + g[1][1]));
}

// From the gradient of a unit quaternion to that of the one it was made from: normalisation lets
// only the part orthogonal to q through.
R3GW_INLINE void through_normalisation(const Lanes (&q)[4], Lanes inverse_length,
                                       Lanes (&gradient)[4]) {
  const Lanes radial =
      q[0] * gradient[0] + q[1] * gradient[1] + q[2] * gradient[2] + q[3] * gradient[3];
  for (int i = 0; i < 4; ++i) gradient[i] = (gradient[i] - radial * q[i]) * inverse_length;
}

}  // namespace r3gw
