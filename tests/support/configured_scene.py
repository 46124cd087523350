"""A small scene with everything made that the doctor looks at, for tests to spoil."""

import yaml

from r3gw.importing.settings import NerfOsrScene
from r3gw.importing.stage import import_scene
from r3gw.masks.settings import MaskSources
from r3gw.masks.stage import make_masks
from r3gw.model.stage import run_initialise
from r3gw.pipeline.config import Config, run_settings
from r3gw.pipeline.doctor.doctor import examine
from r3gw.scene import load_scene, save_scene
from support import nerf_osr_layout

FULL = {
    "variants": ["full"],
    "seeds": [0, 1],
    "ablations": {"variants": ["no_specular"], "seeds": [0]},
    "train": {"iterations": 1000},
}


class ConfiguredScene:
    """A configuration of one scene, with everything made that the doctor looks at."""

    def __init__(self, folder, defaults):
        self.folder, self.defaults = folder, defaults
        self.place = nerf_osr_layout.build(folder / "place")
        self.entry = {"format": "nerf-osr", "path": str(self.place.folder)}
        self.results = folder / "results"
        self.scene = self.results / "place" / "scene"
        self.masks = self.results / "place" / "masks"

    def values(self):
        return FULL | {"scenes": {"place": self.entry}}

    def make(self):
        """Import, masks and initial points."""
        settings = NerfOsrScene(**self.entry)
        import_scene("place", settings, self.place.folder, self.scene, num_threads=1)
        make_masks(self.scene, self.masks, MaskSources())
        names = ("train", "variants")
        files = {f"{name}_file": self.defaults / f"{name}.yaml" for name in names}
        sky = run_settings(Config.model_validate(self.values()), "full", 0, **files).sky
        run_initialise(self.scene, sky, self.results / "place" / "initial.npz")

    def examine(self):
        path = self.folder / "mine.yaml"
        path.write_text(yaml.safe_dump(self.values()))
        target = self.folder / "doctor"
        return examine(path, self.results, target, defaults=self.defaults)


def edit_views(configured, change):
    scene = load_scene(configured.scene)
    views = tuple(change(number, view) for number, view in enumerate(scene.views))
    save_scene(scene.model_copy(update={"views": views}), configured.scene)
