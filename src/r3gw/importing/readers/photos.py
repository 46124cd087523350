"""Reader of anybody's own photos, or a video: their cameras are found by structure from motion."""

from collections.abc import Collection
from pathlib import Path

import pycolmap

from r3gw.files import InputError
from r3gw.importing.folders import MASK_FOLDERS, masks_beside, notes_on_masks
from r3gw.importing.named_files import (
    notes_on,
    other_files,
    pictures_below,
    pictures_by_key,
    refuse_undeveloped,
)
from r3gw.importing.normals import FOLDER as NORMALS
from r3gw.importing.reader import Effort, Reader
from r3gw.importing.reconstruction.copied import from_reconstruction
from r3gw.importing.reconstruction.incremental import reconstruct
from r3gw.importing.reconstruction.prepared import prepared_photos
from r3gw.importing.reconstruction.registration import (
    ADVICE,
    LEAST_PHOTOS,
    lost_photos,
    registration_facts,
)
from r3gw.importing.reconstruction.video import extract_frames
from r3gw.importing.settings import PhotosScene
from r3gw.importing.source import SourceScene, SourceView

_BESIDE = (*(name for name, _ in MASK_FOLDERS.values()), NORMALS)


class PhotosReader(Reader[PhotosScene]):
    """A folder of photos with ``masks/`` and ``sky_masks/``, if there are any; or a video file."""

    def missing(self, given: Collection[str] = ()) -> list[str]:  # noqa: ARG002
        """Nothing: any folder will do."""
        return []

    def facts(self) -> dict[str, str]:
        """How many photos there are."""
        if self.source.is_file():
            return {}
        photos = self._photos(self.source)
        others = other_files(self.source, _BESIDE)
        refuse_undeveloped(self.source, others)
        notes = notes_on(others)
        return {"photos": str(len(photos))} | ({"left out": notes[0]} if notes else {})

    def read(self, effort: Effort) -> SourceScene:
        """The upright photos that registered, in COLMAP's own frame."""
        is_video = self.source.is_file()
        folder = self.source
        if is_video:
            folder = effort.folder / "frames"
            extract_frames(self.source, folder, self.settings.video_frames)
        photos = self._photos(folder)
        others = {} if is_video else other_files(folder, _BESIDE)
        refuse_undeveloped(folder, others)
        masks = masks_beside(folder, list(photos))
        prepared = prepared_photos(photos, masks, effort.folder)
        mapped = reconstruct(
            prepared,
            self.source,
            effort,
            matching=self.settings.matching or ("sequential" if is_video else None),
            camera_mode=pycolmap.CameraMode.SINGLE if is_video else pycolmap.CameraMode.PER_IMAGE,
        )
        model = from_reconstruction(mapped.chosen, self.source)
        views = tuple(
            SourceView(
                path=photo.path,
                photo=photo.file,
                camera=model.cameras[photo.file.name],
                split="train",
                masks=photo.masks,
                lens=model.lenses.get(photo.file.name),
                exif=photo.exif,
            )
            for photo in prepared
            if photo.file.name in model.cameras
        )
        return SourceScene(
            views,
            model.points,
            left_out=lost_photos(prepared, mapped),
            notes=(*notes_on(others), *notes_on_masks(masks)),
            facts=registration_facts(prepared, mapped, views) | {"other_files": others},
        )

    def _photos(self, folder: Path) -> dict[str, Path]:
        """Photos by path.

        Raises:
            InputError: If there are fewer than three, or two share a stem in one folder.
        """
        photos = pictures_below(folder, without=_BESIDE)
        pictures_by_key(folder, without=_BESIDE)  # refuses a.jpg beside a.png: one photo twice
        if len(photos) < LEAST_PHOTOS:
            count = "one photo is" if len(photos) == 1 else f"{len(photos)} photos are"
            raise InputError(
                f"{self.source}: {count} here, but at least {LEAST_PHOTOS} are needed; {ADVICE}"
            )
        return photos
