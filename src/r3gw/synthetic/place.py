"""A place: a building with its ground, plants and neighbours, its materials and its sessions."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from r3gw.synthetic import textures
from r3gw.synthetic.lights import Session
from r3gw.synthetic.materials import Kind, Material
from r3gw.synthetic.meshes import Part, box, gable, polygon
from r3gw.synthetic.ornaments import gable_roof
from r3gw.synthetic.plants import leaves
