"""The channels that one rendering pass composites, as rendering/csrc/channels.h lists them."""

from enum import IntEnum

from r3gw.native import ops


class Layers(IntEnum):
    """What the channels ``foreground`` and ``sky`` of a pass hold of their sets (channels.h).

    Attributes:
        COLOUR: The sum of the three display colours, as Eq. 15 needs it.
        OPACITY: One, so that they composite to the opacity that each set contributes.
    """

    COLOUR = 0
    OPACITY = 1


def _slices() -> dict[str, slice]:
    first, found = 0, {}
    for name, width, _ in ops.rendered_channels():
        found[name] = slice(first, first + width)
        first += width
    return found


CHANNELS = _slices()  # Name to columns, in order.
NUM_CHANNELS = sum(width for _, width, _ in ops.rendered_channels())
# Learned channels come first: only they send gradients to the features of Gaussians.
NUM_LEARNED = sum(width for _, width, is_learned in ops.rendered_channels() if is_learned)

COLOUR, NORMAL = CHANNELS["colour"], CHANNELS["normal"]
DEPTH = CHANNELS["depth"].start
FOREGROUND, SKY = CHANNELS["foreground"].start, CHANNELS["sky"].start
