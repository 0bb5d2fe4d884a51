"""The heads that are shipped: the default head, and others of its topology."""

from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

MAX_HEAD_NUMBER = 63  # on the wire; 0 is no choice
_FOLDER = Path(str(files("conf"))) / "assets" / "heads"


@dataclass(frozen=True)
class Head:
    """A head.

    number : on the wire, 1 for the default head; it never changes
    name : what the user types; about : what it looks like
    """

    number: int
    name: str
    about: str

    @property
    def is_default(self) -> bool:
        """Whether this is the default head."""
        return self.number == DEFAULT_NUMBER

    @property
    def path(self) -> Path:
        """The NPZ file of a head other than the default head; its texture is beside it."""
        return _FOLDER / f"{self.name}.npz"


DEFAULT_NUMBER = 1
HEADS = (
    Head(1, "alex", "person of thirty, short dark brown hair"),
    Head(2, "maria", "woman of thirty, long dark brown hair"),
    Head(3, "kofi", "man of thirty-five, dark skin, very short black hair, short beard"),
    Head(4, "mei", "woman of twenty-five, black hair in a bob"),
    Head(5, "henrik", "man of seventy, bald on top, white hair and beard"),
    Head(6, "amara", "woman of thirty, brown skin, black hair in a bun"),
    Head(7, "rosa", "woman of sixty-five, grey hair in a bun"),
    Head(8, "arjun", "man of thirty, brown skin, black hair, full beard"),
    Head(9, "ingrid", "woman of twenty, freckles, short red hair"),
)
HEADS_BY_NAME = {head.name: head for head in HEADS}
HEADS_BY_NUMBER = {head.number: head for head in HEADS}


def find_head(number: int, /) -> Head:
    """Return the head with a number on the wire; the default head if this version has none with it."""
    return HEADS_BY_NUMBER.get(number, HEADS_BY_NUMBER[DEFAULT_NUMBER])
