"""Layout of a text file, as far as it cannot be seen in the file."""

from dataclasses import dataclass
from typing import Any, Self

from ffgym.core.errors import FFGymError, check_whole
from ffgym.logs.keys import check_table


@dataclass(frozen=True, kw_only=True)
class TextLayout:
    """Layout of a text file; the fields are the keys [file] of keys.toml, None where nothing is said."""

    delimiter: str | None = None
    decimal: str = "."
    comment: str = "#"
    encoding: str = "utf-8-sig"
    names_row: int | None = None
    units_row: int | None = None
    first_row: int | None = None

    def __post_init__(self) -> None:
        for name in ("decimal", "comment", "encoding"):
            if not isinstance(getattr(self, name), str) or not getattr(self, name):
                raise FFGymError(f"[file] {name} = {getattr(self, name)!r} must be text.")
        if self.decimal not in (".", ","):
            raise FFGymError(f"[file] decimal = {self.decimal!r} must be '.' or ','.")
        if self.delimiter is not None and (not isinstance(self.delimiter, str) or len(self.delimiter) != 1):
            raise FFGymError(f"[file] delimiter = {self.delimiter!r} must be one character.")
        try:
            "0".encode(self.encoding)  # names of codecs that are not for text, as base64, are refused here, too
        except (LookupError, ValueError) as error:
            raise FFGymError(
                f"[file] encoding = {self.encoding!r} is no encoding of text; e.g. utf-8, latin-1, utf-16."
            ) from error
        for name, low in (("names_row", 0), ("units_row", 1), ("first_row", 1)):
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, check_whole(f"[file] {name}", value, low=low))

    @classmethod
    def of(cls, table: Any) -> Self:
        """Layout of the table [file] of a column map.

        Raises:
            FFGymError: if a key is unknown, or a value invalid.
        """
        return cls(**check_table(table, "file"))
