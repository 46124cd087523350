"""All evaluation protocols.

To add one, write a `ViewProtocol` in a module of its own and name it here: columns of the tables,
titles, pictures and studies follow from what it says of itself.
"""

from r3gw.evaluation.protocols.base import ViewProtocol
from r3gw.evaluation.protocols.exact import Exact
from r3gw.evaluation.protocols.half_image import HalfImage
from r3gw.evaluation.protocols.learned import Learned
from r3gw.evaluation.protocols.swept import FullYaw, NerfOsr, NerfOsrLinear

# In the order in which tables show them.
PROTOCOLS: tuple[ViewProtocol, ...] = (
    NerfOsr(),
    FullYaw(),
    NerfOsrLinear(),
    Exact(),
    HalfImage(),
    Learned(),
)
