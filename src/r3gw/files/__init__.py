"""What every stage does with files: atomic writes, user-facing errors, provenance."""

from r3gw.files.atomic import atomic_path, write_bytes, write_json
from r3gw.files.errors import InputError, sentence_of

__all__ = ["InputError", "atomic_path", "sentence_of", "write_bytes", "write_json"]
