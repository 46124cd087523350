"""Reader of COLMAP folders: photos in images/ and a model in sparse/ or sparse/0/."""

from pathlib import Path

from r3gw.files import InputError
from r3gw.importing.evaluation_config import read_evaluation
from r3gw.importing.folders import masks_beside, require_training_views, session_of, split_beside
from r3gw.importing.named_files import key_of, listed, pictures_by_key
from r3gw.importing.readers.colmap_model import model_suffix, read_model
from r3gw.importing.source import SourceScene, SourceView


def model_folder(source: Path) -> Path:
    """Where the model of a COLMAP folder is: ``sparse/`` if it holds one, else ``sparse/0/``."""
    plain = source / "sparse"
    return plain if model_suffix(plain) is not None else plain / "0"


def read_colmap_folder(source: Path) -> SourceScene:
    """Read ``images/``, ``sparse/`` and, if there are any, masks, split list and ``eval_files/``.

    Distorted cameras are allowed: the writer undistorts.

    Raises:
        InputError: On a missing file, a wrong size or an unreadable value; names it.
    """
    photos = pictures_by_key(source / "images")
    folder = model_folder(source)
    model = read_model(folder)
    images = {key_of(name): name for name in model.cameras}
    if len(images) < len(model.cameras):
        raise InputError(f"{folder}: two images share a stem; rename one")
    if missing := [name for key, name in images.items() if key not in photos]:
        raise InputError(
            f"{folder}: the model has images that are not in images/ ({listed(missing)}); "
            "put them there or remove them from the model"
        )
    splits = split_beside(source, model.cameras)
    chosen = sorted(set(images) & set(splits))
    require_training_views((splits[key] for key in chosen), source)
    masks = masks_beside(source)
    evaluation = read_evaluation(source / "eval_files")
    views = tuple(
        SourceView(
            name=photos[key].stem,
            photo=photos[key],
            camera=model.cameras[images[key]],
            split=splits[key],
            session=session_of(photos[key].stem),
            masks={kind: files[key] for kind, files in masks.items() if key in files},
            evaluation=evaluation.get(key),
            lens=model.lenses.get(images[key]),
        )
        for key in chosen
    )
    return SourceScene(views, model.points)
