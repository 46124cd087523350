"""Which figures every scene has, as the workflow and the report name them."""

# A plot "sweep" comes on top where test views have an environment map, a picture "occluders" where
# training looked for some.
PICTURES = (
    "views",
    "depth",
    "sky_boundary",
    "surfaces",
    "decomposition",
    "lights",
    "relit_map",
    "relit_learned",
    "shared_light",
)
PLOTS = ("training", "initial", "sfm")
