"""Reader of COLMAP folders: photos in images/, models in sparse/, sparse/0/ and so on."""

from collections.abc import Collection
from pathlib import Path

from r3gw.files import InputError
from r3gw.importing.evaluation_config import read_evaluation
from r3gw.importing.folders import (
    masks_beside,
    masks_of,
    notes_on_masks,
    photos_named,
    require_training_views,
    session_of,
    split_beside,
)
from r3gw.importing.named_files import listed, notes_on, other_files, pictures_below
from r3gw.importing.reader import Effort, Reader
from r3gw.importing.readers import colmap_binary, colmap_text
from r3gw.importing.readers.colmap_model import model_suffix, read_model
from r3gw.importing.reconstruction.triangulate import with_points
from r3gw.importing.settings import ColmapScene
from r3gw.importing.source import SourceScene, SourceView
from r3gw.scene.names import ByPhoto


def model_folders(source: Path) -> list[Path]:
    """Where models of a COLMAP folder lie: in ``sparse/``, in its subfolders, or in the folder."""
    plain = source / "sparse"
    below = sorted(path for path in plain.glob("*") if path.is_dir())
    return [path for path in (plain, *below, source) if model_suffix(path) is not None]


def count_images(folder: Path) -> int:
    """How many images the model in ``folder`` has.

    Raises:
        InputError: If the list of images is damaged.
    """
    if model_suffix(folder) == ".bin":
        return colmap_binary.count_images(folder / "images.bin")
    return colmap_text.count_images(folder / "images.txt")


class ColmapReader(Reader[ColmapScene]):
    """``images/`` and, of all models, the one with most photos; masks, split, ``eval_files/``.

    Distorted cameras are allowed: the writer undistorts. A model of known poses without points
    is triangulated.
    """

    def missing(self, given: Collection[str] = ()) -> list[str]:  # noqa: ARG002
        """The folder of photos, and a model."""
        missing = [] if pictures_below(self.source / "images") else ["images/"]
        if not model_folders(self.source):
            missing.append("sparse/{cameras,images,points3D}.bin or .txt")
        return missing

    def facts(self) -> dict[str, str]:
        """Photos, and the model that would be taken."""
        images = self.source / "images"
        folder, notes = _largest(self.source)
        notes += notes_on(other_files(images))
        facts = super().facts() | {
            "photos": str(len(pictures_below(images))),
            "model": f"{folder.relative_to(self.source).as_posix()}, {count_images(folder)} images",
        }
        return facts | ({"left out": "; ".join(notes)} if notes else {})

    def read(self, effort: Effort) -> SourceScene:
        """The photos of the largest model."""
        pictures = pictures_below(self.source / "images")
        others = other_files(self.source / "images")
        folder, notes = _largest(self.source)
        model = read_model(folder)
        paths = photos_named(model.cameras, pictures, folder)
        if missing := [name for name in model.cameras if name not in paths]:
            raise InputError(
                f"{folder}: the model has images that are not in images/ ({listed(missing)}); "
                "put them there or remove them from the model"
            )
        splits = split_beside(self.source, list(pictures))
        masks = masks_beside(self.source, list(pictures))
        evaluation = ByPhoto(
            read_evaluation(self.source / "eval_files"), list(pictures), "test_config.py"
        )
        left_out = dict.fromkeys(set(pictures) - set(paths.values()), "not in the model")
        views = []
        for name, path in paths.items():
            if path not in splits:
                left_out[path] = "not in the split list"
                continue
            views.append(
                SourceView(
                    path=path,
                    photo=pictures[path],
                    camera=model.cameras[name],
                    split=splits[path],
                    session=session_of(path),
                    masks=masks_of(masks, path),
                    evaluation=evaluation.get(path),
                    lens=model.lenses.get(name),
                )
            )
        require_training_views((view.split for view in views), self.source)
        ordered = sorted(views, key=lambda view: view.path)
        points, triangulated = with_points(ordered, model.points, self.source, effort)
        return SourceScene(
            tuple(ordered),
            points,
            turn=self.settings.given_turn,
            left_out=left_out,
            notes=(*notes, *triangulated, *notes_on(others), *notes_on_masks(masks)),
            facts={"other_files": others},
        )


def _largest(source: Path) -> tuple[Path, tuple[str, ...]]:
    """The model with most images, and a sentence about the others if there are any."""
    counts = {folder: count_images(folder) for folder in model_folders(source)}
    if not counts:
        raise InputError(
            f"{source}: no COLMAP model in sparse/, in its subfolders or in the folder itself; it "
            "must hold cameras, images and points3D, all as .bin or all as .txt"
        )
    chosen = max(counts, key=lambda folder: counts[folder])
    if len(counts) == 1:
        return chosen, ()
    others = [
        f"{folder.relative_to(source).as_posix()} with {count}"
        for folder, count in counts.items()
        if folder != chosen
    ]
    place = chosen.relative_to(source).as_posix()
    return chosen, (
        f"took the largest model, {place} with {counts[chosen]} images; left out: "
        f"{listed(others)} (models share no frame, so they cannot be joined)",
    )
