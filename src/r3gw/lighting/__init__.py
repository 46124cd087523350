"""Light from afar: spherical harmonics, environment maps, irradiance."""
