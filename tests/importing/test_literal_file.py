"""Foreign Python files are data: every construct that could do something is refused unexecuted."""

import math

import numpy as np
import pytest
from support import nerf_osr_layout

from r3gw.files import InputError
from r3gw.importing.evaluation_config import read_evaluation
from r3gw.importing.literal_file import read_literals


def written(tmp_path, text):
    path = tmp_path / "test_config.py"
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("-np.pi / 2", -math.pi / 2),
        ("numpy.pi * 2 - 1", 2 * math.pi - 1),
        ("+math.pi", math.pi),
        ("-95 / 180 * np.pi", math.radians(-95)),
        ("-(1 + 2) * 3", -9.0),
        ("1e-4", 1e-4),
        ("'text'", "text"),
        ("True", True),
        ("None", None),
        ("[1, (2, 'a')]", [1.0, [2.0, "a"]]),
        ("{'a': {1: 2.5}}", {"a": {1: 2.5}}),
    ],
)
def test_literals_have_their_value(tmp_path, expression, value):
    text = f'"""Doc."""\nimport numpy as np\nfrom math import pi\nx: object = {expression}\n'
    result = read_literals(written(tmp_path, text))["x"]
    assert type(result) is type(value)
    if isinstance(value, float):
        value = pytest.approx(value, rel=1e-15, abs=0)
    assert result == value


@pytest.mark.parametrize(
    "hostile",
    [
        "import os",
        "import numpy, subprocess",
        "from os import system",
        "from numpy import *",
        "x = __import__('os').system('touch {marker}')",
        "x = open('{marker}', 'w')",
        "x = [open(p, 'w') for p in ['{marker}']]",
        "x = (lambda: 1)()",
        "x = np.load",
        "x = ().__class__",
        "x = f'{{1}}'",
        "x = 9 ** 9 ** 9",
        "x = 1 << 99",
        "x = 'a' * 9",
        "x = {{**y}}",
        "x = [*y]",
        "x = {{1, 2}}",
        "x = y",
        "x = True + 1",
        "x = 1j",
        "x = b'a'",
        "x = (y := 1)",
        "x = 1 if 1 else 2",
        "x = 1 / 0",
        "x = 1e308 * 10",
        "x = 1e999",
        "x = " + "9" * 400,
        "x = " + "9" * 5000,
        "x = " + "-" * 100_000 + "1",
        "x = " + "(" * 500 + "1" + ")" * 500,
        "x += 1",
        "x.y = 1",
        "x, y = 1, 2",
        "open('{marker}', 'w')",
        "def f(): pass",
        "class C: pass",
        "if 1: open('{marker}', 'w')",
        "with open('{marker}', 'w'): pass",
        "x = ",
        "x = '\0'",
    ],
)
def test_anything_else_is_refused_and_never_run(tmp_path, hostile):
    marker = tmp_path / "marker"
    path = written(tmp_path, hostile.format(marker=marker) if len(hostile) < 99 else hostile)
    with pytest.raises(InputError, match=r"test_config\.py: ") as caught:
        read_literals(path)
    assert "\n" not in str(caught.value)
    assert not marker.exists()


ENTRY = (
    "{'env_map_path': 'sky.png', 'initial_env_map_rotation': {'x': 0, 'y': 0, 'z': 0},"
    " 'env_map_scaling': {'threshold': 0.9, 'scale': 10}, 'sun_angles': [0, 1]}"
)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (f"c = {{'a': {ENTRY.replace('sun_angles', 'sun')}}}", "view 'a' lacks 'sun_angles'"),
        (f"c = {{'a': {ENTRY.replace('[0, 1]', '[0]')}}}", "view 'a', sun_angles_rad"),
        (f"c = {{'a': {ENTRY.replace('0.9', repr('x'))}}}", "view 'a', threshold"),
        (f"c = {{'a': {ENTRY.replace(chr(39) + 'y' + chr(39), '1')}}}", "must give x, y, z"),
        (f"c = {{'a.jpg': {ENTRY}, 'A.JPG': {ENTRY}}}", "has two entries for 'A.JPG'"),
        ("c = {}", "has no entry with an env_map_path"),
        (f"c = {{'a': {ENTRY.replace('sky.png', '../../etc/passwd')}}}", "names passwd"),
    ],
)
def test_wrong_entries_get_one_sentence(tmp_path, text, sentence):
    written(tmp_path, text)
    nerf_osr_layout.picture(tmp_path / "sky.png", np.zeros((8, 16, 3), np.uint8))
    with pytest.raises(InputError, match=sentence):
        read_evaluation(tmp_path)
