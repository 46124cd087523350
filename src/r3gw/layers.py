"""Import order of r3gw, bottom to top: a package imports only from layers below its own."""

LAYERS = (
    ("files",),
    ("settings",),
    ("geometry", "imaging"),
    ("lighting", "scene"),
    ("synthetic", "sfm", "masks", "raster"),
    ("shading",),
    ("gaussians",),
    ("losses",),
    ("training",),
    ("evaluation",),
    ("relightable",),
    ("relighting",),
    ("export",),
    ("reporting",),
    ("doctor",),
    ("cli",),
)
