"""Who renders and scores under each protocol.

To add one, say what it is (`r3gw.evaluation.protocols.facts`), write a `ViewProtocol` in a module
of its own and name it here: columns of the tables, titles, pictures and studies follow.
"""

from r3gw.evaluation.protocols.base import ViewProtocol
from r3gw.evaluation.protocols.exact import Exact
from r3gw.evaluation.protocols.half_image import HalfImage
from r3gw.evaluation.protocols.learned import Learned
from r3gw.evaluation.protocols.swept import FullYaw, NerfOsr, NerfOsrLinear

PROTOCOLS: tuple[ViewProtocol, ...] = (
    NerfOsr(),
    FullYaw(),
    NerfOsrLinear(),
    Exact(),
    HalfImage(),
    Learned(),
)
