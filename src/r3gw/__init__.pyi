from r3gw.evaluation.metrics import Scores as Scores
from r3gw.evaluation.metrics import score as score
from r3gw.files.errors import InputError as InputError
from r3gw.geometry.cameras import Camera as Camera
from r3gw.lighting.light import Light as Light
from r3gw.raster.api import rasterize as rasterize
from r3gw.raster.result import RasterResult as RasterResult
from r3gw.relight.export import export as export
from r3gw.relight.trained import TrainedScene as TrainedScene
from r3gw.relight.trained import load as load

__version__: str
