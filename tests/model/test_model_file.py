"""Model files: earlier versions are read, damaged and foreign files refused in a sentence."""

import json
import struct
import zipfile
from pathlib import Path

import numpy as np
import pytest
import torch
from safetensors.torch import load, save

from r3gw.files import arrays
from r3gw.files.errors import InputError
from r3gw.geometry.cameras import Camera
from r3gw.model.model_file import load_model, save_model
from r3gw.rendering.compose import render

FROZEN = Path(__file__).parents[1] / "data" / "models"
CAMERA = Camera(torch.eye(4, dtype=torch.float64), (14.0, 14.0, 8.0, 6.0), 16, 12)
VARIANTS = ("full", "r3gw_plus")
FILES = [
    f"version_{version}_{variant}.{suffix}"
    for version, suffix in ((3, "pt"), (4, "safetensors"))
    for variant in VARIANTS
]
NEWEST = FROZEN / "version_4_full.safetensors"


@pytest.mark.parametrize("name", FILES)
def test_a_frozen_model_draws_what_it_drew_when_it_was_written(name):
    """Pictures were drawn by the r3gw that wrote version 3 (tests/data/models/README.md)."""
    model = load_model(FROZEN / name)
    assert (model.photos, model.sessions) == (("one", "two", "three"), ("a", "b", "a"))
    variant = name.split(".")[0].removeprefix("version_")[2:]
    assert (model.description.light.kind == "outdoor") == (variant == "r3gw_plus")
    with np.load(FROZEN / "pictures.npz") as pictures:
        for index, photo in enumerate(model.photos):
            expected = pictures[f"{variant}_{photo}"]
            with torch.no_grad():
                found = render(model, CAMERA, *model.appearance(index)[:2]).colour.numpy()
            np.testing.assert_allclose(found, expected, rtol=0, atol=2e-6)


@pytest.mark.parametrize("variant", VARIANTS)
def test_writing_it_again_gives_the_same_bytes(variant, tmp_path):
    frozen = FROZEN / f"version_4_{variant}.safetensors"
    # The settings of a training are kept, not understood: this one has a key of tomorrow.
    settings = {"iterations": 40000, "a_key_of_tomorrow": True}
    save_model(load_model(frozen), tmp_path / "again.safetensors", settings)
    assert (tmp_path / "again.safetensors").read_bytes() == frozen.read_bytes()


@pytest.mark.parametrize("name", FILES)
def test_a_damaged_file_is_refused_in_a_sentence_or_whole(name, tmp_path):
    """Cut short, bytes overwritten, bytes doubled: a sentence, or a model with other numbers."""
    whole = (FROZEN / name).read_bytes()
    random = np.random.default_rng(0)
    damaged = tmp_path / name
    sentences = []
    for case in range(60):
        at, length = int(random.integers(len(whole))), int(random.integers(1, 40))
        noise = random.bytes(length)
        kinds = (whole[:at], whole[:at] + noise + whole[at + length :], whole[:at] + whole)
        damaged.write_bytes(kinds[case % 3])
        try:
            load_model(damaged)
        except InputError as error:
            sentences.append(str(error))
    assert len(sentences) >= 40  # every one that is cut short or doubled
    for sentence in sentences:
        assert sentence.startswith(f"{damaged}: ")
        assert "\n" not in sentence
        assert len(sentence) < 400 + len(str(damaged))


@pytest.mark.parametrize(
    "content", [b"", b"PK\x03\x04", b"\x89PNG\r\n\x1a\n", b"ply\n", b"{}" * 9, b"\xff" * 64]
)
def test_a_foreign_file_is_refused(content, tmp_path):
    path = tmp_path / "model.safetensors"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"model\.safetensors: damaged, or no model of r3gw \("):
        load_model(path)


def changed(**parts):
    """The newest frozen model's arrays and record with parts of them replaced."""
    whole = NEWEST.read_bytes()
    (size,) = struct.unpack("<Q", whole[:8])
    record = json.loads(json.loads(whole[8 : 8 + size])["__metadata__"]["r3gw"])
    tensors = load(whole)
    for name, value in parts.get("tensors", {}).items():
        if value is None:
            del tensors[name]
        else:
            tensors[name] = value
    record["model"]["description"] |= parts.get("description", {})
    record |= parts.get("record", {})
    return save(tensors, {"r3gw": json.dumps(record)})


REFUSED = {
    "lacks array 'foreground.means'": {"tensors": {"foreground.means": None}},
    "unknown array 'more'": {"tensors": {"more": torch.zeros(1)}},
    "'foreground.albedo_logits' is torch.float32 of shape": {
        "tensors": {"foreground.albedo_logits": torch.zeros(14, 4)}
    },
    "'sky.opacity_logits' is torch.float64": {
        "tensors": {"sky.opacity_logits": torch.zeros(9, dtype=torch.float64)}
    },
    "'foreground.means' holds NaN": {"tensors": {"foreground.means": torch.full((14, 3), np.nan)}},
    "('description.hidden_size': Input should be less than or equal to 4096, got 9000000)": {
        "description": {"hidden_size": 9_000_000}
    },
    "('description.metallic': Extra inputs are not permitted, got True)": {
        "description": {"metallic": True}
    },
    "version 5, but this r3gw reads versions 3 and 4": {"record": {"version": 5}},
    "does not say what the model is": {"record": {"model": None}},
}


@pytest.mark.parametrize("sentence", REFUSED)
def test_a_file_that_contradicts_itself_is_refused(sentence, tmp_path):
    path = tmp_path / "model.safetensors"
    path.write_bytes(changed(**REFUSED[sentence]))
    with pytest.raises(InputError) as caught:
        load_model(path)
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)


def test_another_program_s_arrays_are_refused(tmp_path):
    path = tmp_path / "model.safetensors"
    path.write_bytes(save({"weight": torch.zeros(2)}, {"format": "pt"}))
    with pytest.raises(InputError, match="no model of r3gw: it lacks the record 'r3gw'"):
        load_model(path)


def test_a_pickle_that_runs_code_is_refused(tmp_path):
    """Torch's own format may hold calls; the file of version 3 is read as data alone."""

    class Call:
        def __reduce__(self):
            return (Path.touch, (tmp_path / "touched",))

    torch.save({"version": 3, "foreground": Call()}, tmp_path / "model.pt")
    with pytest.raises(InputError, match="damaged, or no model of r3gw"):
        load_model(tmp_path / "model.pt")
    assert not (tmp_path / "touched").exists()


def test_too_large_files_are_refused_unread(tmp_path, monkeypatch):
    with (tmp_path / "model.safetensors").open("wb") as stream:
        stream.truncate(arrays.LARGEST_BYTES + 1)  # a hole: it takes no room
    with pytest.raises(InputError, match=r"8\.0 GB, more than the 8\.0 GB that are read"):
        load_model(tmp_path / "model.safetensors")
    monkeypatch.setattr("r3gw.model.version_3.LARGEST_BYTES", 20_000)
    with zipfile.ZipFile(tmp_path / "bomb.pt", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("data.pkl", bytes(100_000))
    with pytest.raises(InputError, match="unpacked, more than"):
        load_model(tmp_path / "bomb.pt")
