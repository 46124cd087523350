"""Where the sun stood when a photo was taken, as date, time and place tell."""

from pydantic import Field

from r3gw.files.strict import Strict


class SunPosition(Strict):
    """The sun over a place on the earth; where north is in the scene is another matter.

    Attributes:
        elevation_deg: Above the horizon; negative at night.
        azimuth_deg: From true north towards east.
    """

    elevation_deg: float = Field(ge=-90, le=90)
    azimuth_deg: float = Field(ge=0, le=360)
