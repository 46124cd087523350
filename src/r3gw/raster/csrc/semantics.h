// The constants that define what the rasterizer draws; r3gw.raster.reference repeats them.
#pragma once

namespace r3gw {

constexpr float kNearPlane = 0.01f;         // Camera z of the nearest Gaussian drawn.
constexpr float kLowPassPx2 = 0.3f;         // Added to both variances of the projected Gaussian.
constexpr float kMaxAlpha = 0.99f;          // Larger alphas are clamped and lose their gradient.
constexpr float kLog2Of255 = 7.99435344f;   // Alphas below 1/255 are skipped.
constexpr float kMinTransmittance = 1e-4f;  // A pixel darker than this takes no more Gaussians.
constexpr float kFrustumMargin = 0.15f;     // Of the image size: where the EWA Jacobian is held.
constexpr float kLn2 = 0.693147181f;

}  // namespace r3gw
