"""Import order of r3gw, bottom to top: a package imports only from layers below its own."""

LAYERS = (
    ("files",),
    ("settings",),
    ("geometry", "imaging"),
    ("lighting", "scene"),
    ("synthetic", "shading", "sfm", "masks", "raster"),
    ("gaussians",),
    ("losses",),
    ("training",),
    ("evaluation",),
    ("reporting",),
)
