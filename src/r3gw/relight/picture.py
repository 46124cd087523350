"""One frame: shade, rasterize four channels, put the sky behind.

The fourth channel is the opacity of what has a colour of its own. A learned sky colours the sky's
Gaussians, as in training. A white sky or an environment map is seen per pixel instead: there the
sky's Gaussians only hide what is behind them, and the pixel's own background shows through them.
"""

from dataclasses import dataclass
from math import pi

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.geometry.cameras import Camera, pixel_rays
from r3gw.geometry.spherical import angles_from_direction
from r3gw.imaging.colour import linear_from_display
from r3gw.lighting import sh
from r3gw.raster import rasterize
from r3gw.relight.scene import Relightable
from r3gw.relight.tone import Curve
from r3gw.rendering.cook_torrance import face_camera, shade


@dataclass(frozen=True)
class EnvMap:
    """A linear map as it hangs around the scene.

    Attributes:
        padded: ``[1, 3, H, 2H + 2]``: the map and one column more on either side, from the other.
        yaw_rad: Turn about the vertical, towards the map's right.
        exposure: Factor.
    """

    padded: Float[Tensor, "1 3 h w"]
    yaw_rad: float = 0.0
    exposure: float = 1.0

    @staticmethod
    def of(pixels: Float[Tensor, "h w 3"]) -> "EnvMap":
        """Hang up a map (r3gw.lighting.envmap) as it is."""
        columns = torch.cat([pixels[:, -1:], pixels, pixels[:, :1]], dim=1)
        return EnvMap(columns.permute(2, 0, 1)[None].contiguous())

    def seen(self, directions: Float[Tensor, "*batch 3"]) -> Float[Tensor, "*batch 3"]:
        """Linear radiance from ``directions``, bilinear."""
        height, width = self.padded.shape[2], self.padded.shape[3] - 2
        theta, phi = angles_from_direction(directions.reshape(1, -1, 3))
        row = theta / pi * height - 0.5
        turn = torch.remainder((phi - self.yaw_rad) / (2 * pi) + 0.5, 1.0)
        column = turn * width + 0.5  # counted in the padded map
        grid = torch.stack([2 * column / (width + 1) - 1, 2 * row / (height - 1) - 1], dim=-1)
        values = torch.nn.functional.grid_sample(
            self.padded, grid[None], padding_mode="border", align_corners=True
        )
        return self.exposure * values[0, :, 0].T.reshape(directions.shape)


@dataclass(frozen=True)
class Illumination:
    """The light of one frame, and the sky that is seen; without either sky it is white.

    Attributes:
        light: SH environment light, linear.
        sky_light: Sky coefficients (Eq. 11), and
        sky_exposure: the factor on their linear colour.
        env_map: Map that is seen as the sky.
    """

    light: Float[Tensor, "coeff 3"]
    sky_light: Float[Tensor, "skycoeff 3"] | None = None
    sky_exposure: float = 1.0
    env_map: EnvMap | None = None

    def sky(self, directions: Float[Tensor, "*batch 3"], curve: Curve) -> Float[Tensor, "*batch 3"]:
        """The sky's value from ``directions`` after the tone curve."""
        if self.env_map is not None:
            return curve(self.env_map.seen(directions))
        if self.sky_light is None:
            return torch.ones_like(directions)
        display = (sh.radiance(self.sky_light, directions) + 0.5).clamp(0.0, 1.0)
        return curve(self.sky_exposure * linear_from_display(display))


def foreground_values(
    splats: Relightable,
    camera_centre: Float[Tensor, "3"],
    light: Float[Tensor, "coeff 3"],
    curve: Curve,
) -> Float[Tensor, "f 3"]:
    """Colours of the foreground as seen from a point, after the tone curve."""
    means = splats.means[: splats.num_foreground]
    to_camera = torch.nn.functional.normalize(camera_centre.to(means) - means, dim=-1)
    linear = shade(
        face_camera(splats.normals, to_camera),
        to_camera,
        splats.albedo,
        splats.roughness,
        light,
        with_specular=splats.with_specular,
    )
    if splats.occlusion is not None:
        linear = linear + splats.albedo / pi * (splats.occlusion[:, : len(light)] @ light)
    return curve(linear)


def sky_values(
    splats: Relightable, camera_centre: Float[Tensor, "3"], shown: Illumination, curve: Curve
) -> Float[Tensor, "s 3"]:
    """Colours of the sky's Gaussians as seen from a point, after the tone curve."""
    means = splats.means[splats.num_foreground :]
    looks = torch.nn.functional.normalize(means - camera_centre.to(means), dim=-1)
    return shown.sky(looks, curve)


def pixel_directions(camera: Camera) -> Float[Tensor, "h w 3"]:
    """Unit world directions that a camera's pixels look in, float32."""
    rays = pixel_rays(camera) @ camera.cam_from_world[:3, :3].float()
    return torch.nn.functional.normalize(rays, dim=-1)


@torch.no_grad()
def frame(
    splats: Relightable, camera: Camera, shown: Illumination, curve: Curve
) -> Float[Tensor, "h w 3"]:
    """One picture, in the values of the tone curve; what nothing covers shows the sky."""
    colours = foreground_values(splats, camera.centre, shown.light, curve)
    if shown.sky_light is not None:
        sky = sky_values(splats, camera.centre, shown, curve)
        features = torch.nn.functional.pad(torch.cat([colours, sky]), (0, 1), value=1.0)
    else:
        features = torch.zeros(len(splats.means), 4)
        features[: splats.num_foreground, :3] = colours
        features[: splats.num_foreground, 3] = 1.0
    image = rasterize(
        splats.means,
        splats.quaternions,
        splats.scales,
        splats.opacities,
        features,
        camera.cam_from_world.float(),
        camera.intrinsics,
        camera.width,
        camera.height,
    ).features
    return image[..., :3] + (1.0 - image[..., 3:]) * shown.sky(pixel_directions(camera), curve)
