"""Is a dataset complete? Looks at names only, so it can run before anything else does.

`missing_files` names what is not there; `require_complete` refuses with that list. What the files
hold is checked by the readers.
"""

from collections.abc import Callable, Collection
from pathlib import Path

from r3gw.files import InputError
from r3gw.importing.evaluation_config import evaluated_views, missing_evaluation_files
from r3gw.importing.folders import mask_files
from r3gw.importing.named_files import key_of, listed, pictures_by_key
from r3gw.importing.readers.colmap import model_folder
from r3gw.importing.readers.colmap_model import model_suffix
from r3gw.importing.readers.nerf_osr_original import MATRICES, SPLITS, final_folder, matrix_files
from r3gw.importing.readers.nerfstudio import photo_of, read_transforms
from r3gw.importing.settings import (
    ColmapScene,
    NerfOsrOriginalScene,
    NerfOsrScene,
    NerfstudioScene,
    PhotosScene,
    SceneSettings,
    SyntheticScene,
)
from r3gw.importing.split import find_split_file, read_split

_MOST = 20  # names in one sentence


def missing_files(settings: SceneSettings, source: Path, given: Collection[str] = ()) -> list[str]:
    """Names of the files that a scene needs and ``source`` does not hold, in a fixed order.

    Args:
        settings: What the scene's entry in the configuration says about its source.
        source: Folder (or video) of the scene.
        given: Kinds of masks that every photo of layout A must come with; the mask stage makes the
            others if they are missing.

    Raises:
        InputError: If a list that names the files is itself unreadable.
    """
    if not source.exists():
        return [str(source)]
    if isinstance(settings, PhotosScene):
        return []
    find: Callable[[Path], list[str]]
    if isinstance(settings, ColmapScene):
        find = _of_colmap
    elif isinstance(settings, NerfstudioScene):
        find = _of_nerfstudio
    elif isinstance(settings, NerfOsrOriginalScene):
        find = _of_nerf_osr_original
    else:
        return _of_layout_a(settings, source, given)
    return find(source) + _of_evaluation(source / "eval_files")


def require_complete(
    name: str, settings: SceneSettings, source: Path, given: Collection[str] = ()
) -> None:
    """Refuse a scene that lacks files (`missing_files`).

    Raises:
        InputError: Naming the missing files.
    """
    if missing := missing_files(settings, source, given):
        if missing == [str(source)]:
            raise InputError(f"{source}: no such file or folder; correct 'path' of scene '{name}'")
        files = f"{len(missing)} files are" if len(missing) > 1 else "one file is"
        raise InputError(
            f"{source}: {files} missing for scene '{name}' ({listed(missing, _MOST)}); put them "
            "in place (docs/scenes.md tells where data comes from)"
        )


def _of_layout_a(
    settings: SyntheticScene | NerfOsrScene, source: Path, given: Collection[str]
) -> list[str]:
    undistorted, eval_files = source / "undistorted", source / "eval_files"
    if not undistorted.is_dir():
        return ["undistorted/"]
    missing = [] if model_suffix(undistorted / "sparse" / "0") else _model("undistorted/sparse/0")
    lines = read_split(find_split_file(undistorted))
    photos = pictures_by_key(undistorted / "images")
    unseen = [line.filename for key, line in lines.items() if key not in photos]
    missing += [f"undistorted/images/{name}" for name in unseen]
    if "is_sky" in given:
        masks = mask_files(undistorted / "sky_masks")
        unmasked = [Path(line.filename).stem for key, line in lines.items() if key not in masks]
        missing += [f"undistorted/sky_masks/{stem}.png" for stem in unmasked]
    missing += _of_evaluation(eval_files)
    if isinstance(settings, NerfOsrScene):
        evaluated = evaluated_views(eval_files)
        for view in settings.evaluated_views:
            if key_of(view) not in photos:
                missing.append(f"undistorted/images/{view}.jpg")
            if key_of(view) not in evaluated:
                missing.append(f"entry of {view} in eval_files/test_config.py")
    return missing


def _of_evaluation(folder: Path) -> list[str]:
    return [f"eval_files: {name}" for name in missing_evaluation_files(folder)]


def _of_colmap(source: Path) -> list[str]:
    missing = [] if pictures_by_key(source / "images") else ["images/"]
    return missing + ([] if model_suffix(model_folder(source)) else _model("sparse"))


def _model(folder: str) -> list[str]:
    return [f"{folder}/{{cameras,images,points3D}}.bin or .txt"]


def _of_nerfstudio(source: Path) -> list[str]:
    if not (source / "transforms.json").is_file():
        return ["transforms.json"]
    transforms = read_transforms(source)
    named = [frame.mask_path for frame in transforms.frames] + [transforms.ply_file_path]
    missing = [
        frame.file_path
        for frame in transforms.frames
        if not photo_of(source, frame.file_path).is_file()
    ]
    return missing + [name for name in named if name and not (source / name).is_file()]


def _of_nerf_osr_original(source: Path) -> list[str]:
    folder = final_folder(source)
    missing = []
    for split in SPLITS:
        photos = pictures_by_key(folder / split / "rgb")
        if not photos:
            missing.append(f"{split}/rgb/")
        for kind in MATRICES:
            files = matrix_files(folder / split, kind)
            missing += [f"{split}/{kind}/{p.stem}.txt" for k, p in photos.items() if k not in files]
    return missing
