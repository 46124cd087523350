"""What a model is: everything that its file must say so that its arrays can be read and drawn.

How it was trained is another matter (`r3gw.training.settings`); a model file keeps that as a record
which reading it does not need.
"""

from collections.abc import Callable, Sequence
from typing import Annotated, Any

from pydantic import Field, model_serializer

from r3gw.files.strict import Strict
from r3gw.model.light_models.daylight import DaylightDescription
from r3gw.model.light_models.fixed import FixedDescription
from r3gw.model.light_models.free import FreeDescription
from r3gw.model.light_models.outdoor import OutdoorDescription
from r3gw.model.limits import LARGEST_LAYER

LayerSize = Annotated[int, Field(ge=1, le=LARGEST_LAYER)]
LightDescription = Annotated[
    FreeDescription | OutdoorDescription | DaylightDescription | FixedDescription,
    Field(discriminator="kind"),
]


class ModelDescription(Strict):
    """What a trained scene is.

    Attributes:
        separate_sky: Whether the sky is a set of Gaussians of its own (Sec. 4.3).
        specular: Whether surfaces reflect (Eq. 7) or are diffuse alone.
        share_session_light: Whether photos of a session share one light, each with an exposure.
        photo_gains: Whether each photo has an exposure and white balance apart from its light.
        light: The light model and what it must know; its SH degree is the model's.
        embedding_size, hidden_size, light_hidden_size: Widths of the appearance MLP.
    """

    separate_sky: bool
    specular: bool
    share_session_light: bool
    photo_gains: bool = False
    light: LightDescription
    embedding_size: LayerSize
    hidden_size: LayerSize
    light_hidden_size: LayerSize

    @model_serializer(mode="wrap")
    def _as_before(self, values_of: Callable[[Any], dict[str, Any]]) -> dict[str, Any]:
        """Without a word of gains where there are none, as files were before there were any."""
        values = values_of(self)
        if not self.photo_gains:
            del values["photo_gains"]
        return values

    @property
    def light_degree(self) -> int:
        """SH degree of every light that falls on the scene."""
        return self.light.degree

    @property
    def has_point_sun(self) -> bool:
        """Whether surfaces are shaded with a light's sun itself, where it has one."""
        return isinstance(self.light, DaylightDescription)

    @property
    def sun_bounce(self) -> float:
        """Of a point sun's irradiance, what surfaces get from others that stand in it."""
        return self.light.sun_bounce if isinstance(self.light, DaylightDescription) else 0.0

    @property
    def sharp(self) -> float:
        """Share of a point sun that is shaded as such; the rest stays in the SH light."""
        return self.light.sharp if isinstance(self.light, DaylightDescription) else 1.0


def light_rows(sessions: Sequence[str], share_session_light: bool) -> list[int]:
    """Which embedding each photo uses: its own, or its session's where light is shared."""
    if not share_session_light:
        return list(range(len(sessions)))
    known = list(dict.fromkeys(sessions))
    return [known.index(session) for session in sessions]
