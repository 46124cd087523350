"""Registers r3gw as a method of NerfBaselines; README.md beside this file says how to use it."""

import sys
from pathlib import Path

from nerfbaselines import register

# NerfBaselines loads this file by its path; the class beside it is imported by its name.
sys.path.append(str(Path(__file__).parent))

register(
    {
        "id": "r3gw",
        "method_class": "r3gw_method:R3gwMethod",
        "backends_order": ["python"],
        "metadata": {
            "name": "r3gw",
            "description": (
                "Relightable 3D Gaussians for outdoor scenes: a separate sky, a light per photo "
                "in spherical harmonics, and a Cook-Torrance material. Trains on a CPU."
            ),
            "paper_title": "R3GW: Relightable 3D Gaussians for Outdoor Scenes in the Wild",
            "paper_authors": [
                "Margherita Lea Corona",
                "Wieland Morgenstern",
                "Peter Eisert",
                "Anna Hilsmann",
            ],
            "licenses": [{"name": "Apache-2.0"}],
        },
        "presets": {
            # The schedule of half a minute that config/config.yaml has for the embedded scenes.
            "short": {
                "iterations": 1000,
                "init.light_radiance": 0.6,
                "rates.short_run_boost": 10.0,
                "rates.scale": 0.02,
                "rates.rotation": 0.006,
                "density.interval": 1000,
                "density.threshold_first": 2.0e-4,
                "density.threshold_last": 8.0e-4,
                "density.reset_interval": None,
                "density.max_gaussians": 25000,
                "sky.min_count": 1500,
                "sky.max_count": 2500,
            },
        },
    }
)
