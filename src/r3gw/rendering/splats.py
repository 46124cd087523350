"""From the stored parameters of both sets to what the rasterizer draws, as one C++ kernel.

`r3gw.rendering.reference` says in plain torch what it computes, and does it where the kernel does
not: on other devices, in float64, for lights of another degree.
"""

from jaxtyping import Float
from torch import Tensor

from r3gw.geometry.cameras import Camera
from r3gw.model.attributes import FOREGROUND, SKY
from r3gw.model.model import SceneModel
from r3gw.native import kernels, ops
from r3gw.rendering import reference
from r3gw.rendering.brdf_table import brdf_table
from r3gw.rendering.channels import Layers
from r3gw.rendering.splat_set import Splats, irradiance_beside

COEFFICIENTS = (9, 25)  # SH degree 2 and 4: what shading kernels are compiled for.


def splats_of(
    model: SceneModel,
    camera: Camera,
    light: Float[Tensor, "coeff 3"],
    sky_light: Float[Tensor, "4 3"] | None,
    layers: Layers = Layers.COLOUR,
    beside: Float[Tensor, "f 3"] | None = None,
) -> Splats:
    """Activate, shade and colour all Gaussians of a model as a camera sees them.

    Gradients go to every parameter, to ``light`` and to ``sky_light``; directions of view carry
    none.

    Args:
        model: The scene.
        camera: Where from.
        light: SH environment light, linear.
        sky_light: Sky coefficients (Eq. 11); None paints the sky white.
        layers: What the channels ``foreground`` and ``sky`` hold.
        beside: Irradiance of the foreground beside that of the light (`irradiance_beside`); None:
            what shadows take from the light, and nothing else.
    """
    foreground, sky = model.foreground, model.sky
    if beside is None:
        beside = irradiance_beside(foreground, light, None)
    is_compiled = len(light) in COEFFICIENTS
    if not (is_compiled and kernels.take("splats", foreground["means"], light)):
        return reference.splats_of(model, camera, light, sky_light, layers, beside)
    rows = ops.splats(
        ops.ForegroundRows(
            **{attribute.name: foreground[attribute.name] for attribute in FOREGROUND},
            shadow=beside,
        ),
        ops.SkyRows(
            **{attribute.name: sky.rows[attribute.name] for attribute in SKY},
            radius=sky.radius,
            centre=sky.centre,
        ),
        light.contiguous(),
        brdf_table().to(light.device) if model.description.specular else None,
        None if sky_light is None else sky_light.contiguous(),
        camera.cam_from_world,
        layers,
    )
    return Splats(*rows, layers=layers)
