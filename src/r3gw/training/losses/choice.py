"""Which form of the losses the settings choose."""

from collections.abc import Mapping

from r3gw.training.losses import fused, plain
from r3gw.training.losses.forms import LossForms
from r3gw.training.settings import FormName

FORMS: Mapping[FormName, LossForms] = {"fused": fused, "plain": plain}
