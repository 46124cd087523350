"""Where the masks of a scene come from: the keys of its entry in config.yaml about masks."""

from typing import Annotated, Literal

from pydantic import AfterValidator, Field, model_validator

from r3gw.files.strict import Strict

SKY_SOURCES = ("given", "labels", "network", "classical", "none")
VALID_SOURCES = ("given", "labels", "network", "all")
_ALWAYS = ("classical", "none", "all")  # these never lack a mask
_Share3 = tuple[float, float, float]


def chain(value: str) -> tuple[str, ...]:
    """The sources of ``given-or-labels-or-classical``, in order of preference."""
    return tuple(value.split("-or-"))


def _checked(value: str, known: tuple[str, ...]) -> str:
    parts = chain(value)
    if unknown := [part for part in parts if part not in known]:
        raise ValueError(f"'{unknown[0]}' is no source of masks; join {', '.join(known)} by '-or-'")
    for number, part in enumerate(parts[:-1]):
        if part in _ALWAYS or part in parts[number + 1 :]:
            raise ValueError(f"nothing after '{part}' would ever be used; put it last, once")
    return value


def _sky(value: str) -> str:
    return _checked(value, SKY_SOURCES)


def _valid(value: str) -> str:
    return _checked(value, VALID_SOURCES)


SkyMasks = Annotated[str, AfterValidator(_sky)]
ValidMasks = Annotated[str, AfterValidator(_valid)]


class LabelClasses(Strict):
    """Which ids of a label map mean what."""

    sky: tuple[int, ...] = Field(min_length=1)
    occluders: tuple[int, ...] = ()


class NetworkSettings(Strict):
    """An ONNX network for semantic segmentation, named by the user, and how to feed it.

    Attributes:
        model: Path of the .onnx file.
        sky, occluders: Ids of its classes.
        width_px, height_px: Size that photos are scaled to for it.
        mean, std: Of red, green and blue in 0..1: the network gets (colour - mean) / std.
    """

    model: str
    sky: tuple[int, ...] = Field(min_length=1)
    occluders: tuple[int, ...] = ()
    width_px: int = Field(512, ge=16)
    height_px: int = Field(512, ge=16)
    mean: _Share3 = (0.485, 0.456, 0.406)
    std: _Share3 = (0.229, 0.224, 0.225)


class MaskSources(Strict):
    """The keys about masks that every scene's entry has.

    Attributes:
        sky_masks: Sources of sky masks in order of preference, joined by ``-or-``: ``given``,
            ``labels``, ``network``, ``classical``, ``none`` (no sky). A photo for which none of
            them has a mask is an error.
        valid_masks: The same for what is no occluder: ``given``, ``labels``, ``network``, ``all``.
        label_maps: Folder of label maps, one per photo, matched by stem; besides the label maps
            that came with the data.
        label_classes: How label maps are to be read.
        network: Needed where a chain names ``network``.
    """

    sky_masks: SkyMasks = "given-or-labels-or-classical"
    valid_masks: ValidMasks = "given-or-labels-or-all"
    label_maps: str | None = None
    label_classes: (
        Literal["cityscapes-colours", "cityscapes-ids", "cityscapes-train-ids"] | LabelClasses
    ) = "cityscapes-colours"
    network: NetworkSettings | None = None

    @model_validator(mode="after")
    def _network_is_named(self) -> "MaskSources":
        named = {*chain(self.sky_masks), *chain(self.valid_masks)}
        if "network" in named and self.network is None:
            raise ValueError("masks shall come from a network, but the entry names none: 'network'")
        return self
