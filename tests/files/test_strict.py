"""Settings files that are no text, no YAML, or far larger than they look."""

import pytest

from r3gw.files import InputError
from r3gw.files.strict import read_json, read_yaml

LAUGHS = b"a: &a [x, x, x, x, x, x, x, x, x, x]\n" + b"".join(
    f"{b}: &{b} [{', '.join([f'*{a}'] * 10)}]\n".encode()
    for a, b in zip("abcdefghi", "bcdefghij", strict=True)
)


@pytest.mark.parametrize(
    ("name", "data", "sentence"),
    [
        ("a.yaml", b"scene: caf\xe9\n", r"a\.yaml: is not text in UTF-8 \(byte 10\)"),
        ("a.yaml", b"day: 2024-13-45\n", r"not readable as YAML \(month must be in 1\.\.12"),
        ("a.yaml", b"a: [1, 2\n", r"not readable as YAML"),
        ("a.yaml", b"[" * 5000, r"not readable as YAML"),
        ("a.yaml", b"a: &a [*a]\n", r"its aliases lead in a circle"),
        ("a.yaml", LAUGHS, r"it stands for more than 50000000 values"),
        ("a.yaml", b"- 1\n", r"expected a mapping of settings, got list"),
        ("a.yaml", b"!!python/object/apply:os.system ['true']", r"not readable as YAML"),
        ("a.json", b'{"a": 1', r"a\.json: not readable as JSON"),
        ("a.json", b"[" * 100_000, r"a\.json: not readable as JSON"),
        ("a.json", b'\xff\xfe{"a": 1}', r"is not text in UTF-8"),
    ],
)
def test_refused(tmp_path, name, data, sentence):
    (tmp_path / name).write_bytes(data)
    with pytest.raises(InputError, match=sentence):
        read_yaml(tmp_path / name)


def test_read(tmp_path):
    (tmp_path / "a.yaml").write_bytes(b"\xef\xbb\xbfbase: &b {x: 1}\nown:\n  <<: *b\n  y: 2\n")
    assert read_yaml(tmp_path / "a.yaml")["own"] == {"x": 1, "y": 2}
    (tmp_path / "a.json").write_bytes(b'{"a": 1e-05}')
    # YAML 1.1 takes 1e-05 for text.
    assert read_yaml(tmp_path / "a.json") == read_json(tmp_path / "a.json") == {"a": 1e-05}
    (tmp_path / "b.json").write_bytes(b"[1]")
    with pytest.raises(InputError, match=r"b\.json: expected a JSON object, got list"):
        read_json(tmp_path / "b.json")
