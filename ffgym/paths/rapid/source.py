"""The text of a program, and errors that say where in it."""

from dataclasses import dataclass
from pathlib import Path

from ffgym.core.errors import FFGymError
from ffgym.paths.rapid.syntax import Place


@dataclass(frozen=True, kw_only=True)
class Source:
    """Text of a program and the name by which messages call it."""

    name: str
    text: str

    @property
    def end(self) -> Place:
        """Behind the last sign that is no blank."""
        lines = self.text.rstrip().split("\n")
        return Place(len(lines), len(lines[-1]) + 1)

    def at(self, place: Place) -> str:
        """A place as messages write it, 'file:line:column'."""
        return f"{self.name}:{place.line}:{place.column}"

    def error(self, place: Place, message: str) -> FFGymError:
        """Error that begins with a place."""
        return FFGymError(f"{self.at(place)}: {message}")


def decode(data: bytes) -> str:
    r"""Text of a program file: UTF-8, or Latin-1 as controllers write it; without byte order mark, lines end in \n."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("latin-1")  # has a character for every byte
    return unified(text)


def unified(text: str) -> str:
    r"""Text whose lines end in \n."""
    return text.replace("\r\n", "\n").replace("\r", "\n")


def read_source(path: str | Path) -> Source:
    """Program file.

    Raises:
        FFGymError: if it cannot be read.
    """
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise FFGymError(f"Cannot read RAPID program {path}: {error.strerror}.") from error
    return Source(name=Path(path).name, text=decode(data))
