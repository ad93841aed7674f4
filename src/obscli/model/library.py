"""The bundled models, and the models in a directory.

A wheel carries the models as ``obscli/bundled``; a checkout (an editable install too) has them in ``models``
beside ``src``. Nothing here reads a model.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Final


SUFFIXES: Final = (".yaml", ".yml")

#: A file is taken for a model if a line of it starts with this key; a model cannot do without.
STATES: Final = re.compile(rb"^states\s*:", re.MULTILINE)

#: Larger files are no models (the reader refuses them too).
LARGEST: Final = 5_000_000


def library_directory() -> Path | None:
    """Return the directory of the bundled models, None in an installation without them."""
    package = Path(__file__).resolve().parents[1]
    for candidate in (package / "bundled", package.parents[1] / "models"):
        if candidate.is_dir():
            return candidate
    return None


def bundled_models() -> Mapping[str, Path]:
    """Return the bundled models by name (``ins_calibration/horizontal``), in order of name."""
    directory = library_directory()
    if directory is None:
        return {}
    return {path.relative_to(directory).with_suffix("").as_posix(): path for path in model_files(directory)}


def bundled_model(name: str) -> Path:
    """Return the bundled model of that name; the last part of a name is enough where no other has it.

    Raises
    ------
    KeyError
        where no bundled model, or more than one, has the name.
    """
    models = bundled_models()
    if name in models:
        return models[name]
    matches = [path for known, path in models.items() if known.endswith("/" + name)]
    if len(matches) != 1:
        raise KeyError(name)
    return matches[0]


def model_files(directory: Path) -> tuple[Path, ...]:
    """Return every YAML file below the directory, in order of path."""
    return tuple(sorted(path for path in directory.rglob("*") if path.suffix in SUFFIXES and path.is_file()))


def models_here(directory: Path) -> tuple[Path, ...]:
    """Return all files under ``models``, else the files of the directory itself that look like models."""
    if (directory / "models").is_dir():
        return model_files(directory / "models")
    files = sorted(path for path in directory.iterdir() if path.suffix in SUFFIXES and path.is_file())
    return tuple(path for path in files if _looks_like_model(path))


def _looks_like_model(path: Path) -> bool:
    return path.stat().st_size <= LARGEST and STATES.search(path.read_bytes()) is not None
