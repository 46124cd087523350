"""A study: settings changed one at a time, each compared with the same baseline."""

from typing import Annotated, Any

from pydantic import Field

from r3gw.files.strict import Strict

# It names a folder of results, and stands in commands.
VariantName = Annotated[str, Field(pattern="^[A-Za-z0-9][A-Za-z0-9._-]*$")]


class StudySettings(Strict):
    """What ``snakemake study`` covers, on all scenes of the configuration.

    Attributes:
        baseline: The variant (variants.yaml) that everything is compared with.
        seeds: How often each is trained.
        changes: By name, what is changed in the baseline's settings. Each is a variant of this
            configuration, as if it stood in variants.yaml.
    """

    baseline: VariantName
    seeds: list[int] = Field(min_length=1)
    changes: dict[VariantName, Annotated[dict[str, Any], Field(min_length=1)]] = Field(min_length=1)

    @property
    def variants(self) -> list[str]:
        """All that is evaluated, the baseline first."""
        return [self.baseline, *self.changes]
