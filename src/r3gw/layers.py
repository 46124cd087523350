"""Import order of r3gw, bottom to top: a package imports only from layers below its own."""

LAYERS = (
    ("files",),
    ("native", "geometry", "imaging"),
    ("lighting", "scene"),
    ("benchmark", "masks", "raster"),
    ("stereo",),
    ("importing", "model"),
    ("rendering",),
    ("training",),
    ("relight",),
    ("evaluation", "view"),
    ("reporting",),
    ("pipeline",),
    ("cli",),
)
