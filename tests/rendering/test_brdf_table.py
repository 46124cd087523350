"""The split-sum table against a Monte Carlo integral that shares no code with it."""

import numpy as np
import pytest
import torch

from r3gw.rendering.brdf_table import brdf_table, lookup

SAMPLES = 200_000


def light_sampled(cosine: float, roughness: float, rng: np.random.Generator) -> tuple[float, float]:
    """F1, F2 by sampling the light direction: uniform in the hemisphere for rough surfaces.

    Evaluates GGX D, height-correlated Smith G2 and Schlick's weight literally:
    integral of D G2 / (4 n.v n.l) n.l over light directions.
    """
    z = rng.random(SAMPLES)
    phi = 2 * np.pi * rng.random(SAMPLES)
    s = np.sqrt(1 - z * z)
    light = np.stack([s * np.cos(phi), s * np.sin(phi), z], -1)
    view = np.array([np.sqrt(1 - cosine**2), 0.0, cosine])
    half = light + view
    half /= np.linalg.norm(half, axis=-1, keepdims=True)
    alpha2 = roughness**4
    n_h, v_h = half[:, 2], half @ view
    density = alpha2 / (np.pi * (n_h**2 * (alpha2 - 1) + 1) ** 2)

    def root(c: np.ndarray | float) -> np.ndarray | float:
        return np.sqrt(alpha2 + (1 - alpha2) * np.square(c))

    g2 = 2 * z * cosine / (cosine * root(z) + z * root(cosine))
    value = density * g2 / (4 * cosine) * 2 * np.pi
    fresnel = (1 - v_h) ** 5
    return float((value * (1 - fresnel)).mean()), float((value * fresnel).mean())


def half_sampled(cosine: float, roughness: float, rng: np.random.Generator) -> tuple[float, float]:
    """F1, F2 by sampling GGX half vectors: for glossy surfaces, seen not too flat."""
    alpha2 = roughness**4
    u, phi = rng.random(SAMPLES), 2 * np.pi * rng.random(SAMPLES)
    n_h = np.sqrt((1 - u) / (1 + (alpha2 - 1) * u))
    s = np.sqrt(np.maximum(0, 1 - n_h**2))
    v_h = np.sqrt(1 - cosine**2) * s * np.cos(phi) + cosine * n_h
    n_l = 2 * v_h * n_h - cosine
    lit = (n_l > 0) & (v_h > 0)

    def smith(c: np.ndarray | float) -> np.ndarray | float:
        return 0.5 * (np.sqrt(1 + alpha2 * (1 / np.square(c) - 1)) - 1)

    g2 = 1 / (1 + smith(cosine) + smith(np.maximum(n_l, 1e-6)))
    weight = np.where(lit, g2 * v_h / (n_h * cosine), 0.0)
    fresnel = (1 - np.clip(v_h, 0, 1)) ** 5
    return float((weight * (1 - fresnel)).mean()), float((weight * fresnel).mean())


@pytest.mark.parametrize("cosine", [0.05, 0.11, 0.3, 0.52, 0.77, 0.99])
@pytest.mark.parametrize("roughness", [0.08, 0.2, 0.35, 0.5, 0.7, 0.9, 1.0])
def test_matches_monte_carlo(cosine, roughness):
    rng = np.random.default_rng(0)
    integrate = light_sampled if roughness >= 0.7 else half_sampled
    expected = integrate(cosine, roughness, rng)
    found = lookup(torch.tensor([cosine]), torch.tensor([roughness]))
    np.testing.assert_allclose([float(f) for f in found], expected, rtol=0, atol=5e-3)


@pytest.mark.parametrize("cosine", [0.02, 0.3, 0.9])
def test_a_mirror_is_schlick(cosine):
    """Without roughness the integral is a delta: F1 + F2 = 1, F2 = (1 - n.v)^5."""
    f1, f2 = lookup(torch.tensor([cosine]), torch.tensor([0.0]))
    np.testing.assert_allclose(float(f2), (1 - cosine) ** 5, rtol=0, atol=1e-3)
    np.testing.assert_allclose(float(f1 + f2), 1.0, rtol=0, atol=1e-3)


def test_reflects_at_most_everything():
    total = brdf_table().sum(-1)
    assert float(total.max()) <= 1.0 + 1e-5
    assert float(brdf_table().min()) >= 0.0


def test_gradients_by_finite_differences():
    """At points inside grid cells, where the bilinear surface is smooth."""
    cosine = torch.tensor([0.21, 0.6, 0.93], dtype=torch.float64, requires_grad=True)
    roughness = torch.tensor([0.301, 0.502, 0.817], dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(lookup, (cosine, roughness), eps=1e-7, atol=1e-5)
