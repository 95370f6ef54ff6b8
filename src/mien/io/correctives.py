"""The small JSON file that says which shapes of a character follow from others."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from mien.core import Correctives, FileError, InputError
from mien.core.correctives import correctives_of
from mien.io.values import is_number, read_document

FORMAT = "mien-correctives"


def read_correctives(path: Path | str, names: Sequence[str]) -> Correctives:
    """Read a `mien-correctives` file: for each corrective shape the pose at which it is full.

    Args:
        path: the file.
        names: the character's blendshapes.

    Raises:
        FileError: not such a file, an unknown shape, or a rule that makes no corrective.
    """
    path = Path(path)
    rules = read_document(path, FORMAT).get("correctives")
    if not isinstance(rules, dict) or not rules:
        example = '{"correctives": {"jawOpen_mouthFunnel": {"jawOpen": 1, "mouthFunnel": 1}}}'
        raise FileError(f"{path} names no correctives; give {example}.")
    for shape, pose in rules.items():
        if not isinstance(pose, dict) or not all(is_number(weight) for weight in pose.values()):
            raise FileError(
                f"{path}: {shape!r} needs its drivers and the weight of each at which it is full, "
                f'as in {{"jawOpen": 0.5}}, but has {str(pose)[:80]}.'
            )
    try:
        return correctives_of(rules, names)
    except InputError as error:
        raise FileError(f"{path}: {error}") from None
