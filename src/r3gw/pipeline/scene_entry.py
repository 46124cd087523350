"""The entry of a scene in config.yaml: where it is imported from, and where its masks come from.

Each half belongs to the stage that reads it, so that an edit of one does not repeat the other.
"""

from collections.abc import Mapping
from typing import Any

from pydantic import model_serializer, model_validator

from r3gw.files.strict import Strict, validated
from r3gw.importing.settings import SceneSettings
from r3gw.masks.settings import MaskSources

_SKY_MASKS = {"synthetic": "given"}  # where the default of `MaskSources` does not fit a format


class SceneEntry(Strict):
    """One entry of ``scenes``; in the file, its keys stand in one mapping.

    Attributes:
        source: Keys about the source, by its format.
        masks: Keys about masks.
    """

    source: SceneSettings
    masks: MaskSources

    @model_validator(mode="before")
    @classmethod
    def _halves(cls, values: Any) -> Any:
        """Sort the keys of the file to the half that knows them."""
        if not isinstance(values, Mapping):
            return values
        keys = MaskSources.model_fields
        masks = {key: value for key, value in values.items() if key in keys}
        source = {key: value for key, value in values.items() if key not in keys}
        default = _SKY_MASKS.get(str(source.get("format")))
        return {
            "source": source,
            "masks": ({"sky_masks": default} if default else {}) | masks,
        }

    @model_serializer
    def _joined(self) -> dict[str, Any]:
        """The keys in one mapping again, as in the file."""
        return self.source.model_dump(mode="json") | self.masks.model_dump(mode="json")

    @property
    def given_masks(self) -> tuple[str, ...]:
        """Kinds of masks that only the data can give."""
        return ("is_sky",) if self.masks.sky_masks == "given" else ()


def parse_entry(values: Mapping[str, Any], source: str) -> SceneEntry:
    """Validate one entry of ``scenes``; ``source`` names it in errors.

    Raises:
        InputError: On the first unknown key, missing key or wrong value.
    """
    return validated(SceneEntry, values, source)
