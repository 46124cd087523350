"""Commands with many options: help in sections, and option types of a film."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

from r3gw.cli.group import FILE
from r3gw.files import InputError
from r3gw.relight.sweep import Sweep

if TYPE_CHECKING:  # generic since click 8.4
    SweepBase = click.ParamType[Sweep]
    ExposureBase = click.ParamType[float | str]
else:
    SweepBase = ExposureBase = click.ParamType


class SweepType(SweepBase):
    """A number, or FROM:TO over the film."""

    name = "sweep"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> Sweep:
        """Parse the option's text."""
        if isinstance(value, Sweep):
            return value
        try:
            return Sweep.parse(str(value))
        except InputError as error:
            self.fail(str(error), param, ctx)


class ExposureType(ExposureBase):
    """A factor above 0, or ``auto``."""

    name = "exposure"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float | str:
        """Parse the option's text."""
        if value == "auto":
            return "auto"
        try:
            factor = float(value)
        except ValueError:
            factor = -1.0
        if not 0 < factor < float("inf"):
            self.fail(f"'{value}' is neither a factor above 0 nor 'auto'", param, ctx)
        return factor


SWEEP, EXPOSURE = SweepType(), ExposureType()


class SectionOption(click.Option):
    """An option that knows its section of the help."""

    def __init__(self, *args: Any, section: str, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.section = section


class SectionCommand(click.Command):
    """A command whose help lists options by section, in the order of their definition."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write one list per section."""
        sections: dict[str, list[tuple[str, str]]] = {}
        for option in self.get_params(ctx):
            record = option.get_help_record(ctx)
            if record is not None:
                section = option.section if isinstance(option, SectionOption) else "Options"
                sections.setdefault(section, []).append(record)
        for section, records in sections.items():
            with formatter.section(section):
                formatter.write_dl(records)


Decorator = Callable[[Callable[..., Any]], Callable[..., Any]]


def option(section: str, *names: str, **kwargs: Any) -> Decorator:
    """`click.option` in a section."""
    return click.option(*names, cls=SectionOption, section=section, **kwargs)


LIGHT = "Light (exactly one of --env-map, --light-of, --sun)"
LIGHT_OPTIONS = (
    option(
        LIGHT, "--env-map", type=FILE, metavar="FILE",
        help="Map of the light all around, twice as wide as high: .exr or .hdr (linear light), "
        "or an 8-bit picture such as .jpg or .png.",
    ),
    option(
        LIGHT, "--light-of", multiple=True, metavar="PHOTO",
        help="Learned light of a training photo; twice for a blend of two.",
    ),
    option(
        LIGHT, "--blend", type=SWEEP, default="0", metavar="SWEEP",
        help="Share of the second --light-of, 0 to 1.",
    ),
    option(
        LIGHT, "--sun", type=(SWEEP, SWEEP), metavar="ELEVATION AZIMUTH",
        help="Sun and clear sky; degrees above the horizon, and from +z towards +x. Two SWEEPs.",
    ),
    option(
        LIGHT, "--turbidity", type=float, default=3.0, show_default=True,
        help="Haze under --sun, 1 to 10.",
    ),
    option(
        LIGHT, "--yaw-deg", type=SWEEP, default="0", metavar="SWEEP",
        help="Turn of the light and its sky about the vertical, from +z towards +x.",
    ),
    option(
        LIGHT, "--exposure", type=EXPOSURE, metavar="FACTOR|auto",
        help="Factor on the light and its sky; auto makes the light as strong as the photos' "
        "learned lights. Default: auto for --sun, else 1.",
    ),
    option(
        LIGHT, "--sky", metavar="white|map|learned[:PHOTO]",
        help="What is seen as the sky. Default: the map, or the learned sky of --light-of.",
    ),
    option(
        LIGHT, "--tone", type=click.Choice(["standard", "reinhard", "filmic"]), default="standard",
        show_default=True, help="Tone curve; standard clamps, as in training. Not for .exr.",
    ),
)  # fmt: skip


def light_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options that choose a light."""
    for each in reversed(LIGHT_OPTIONS):
        command = each(command)
    return command
