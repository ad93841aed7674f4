"""How far a long computation is: text for whoever watches."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias


#: Told what is being done; may be called often.
Progress: TypeAlias = Callable[[str], None]


def silent(_: str) -> None:
    """Progress that nobody watches."""
