"""Syntax tree of a RAPID program, with source locations; names and types have no meaning yet."""

from typing import NamedTuple, TypeAlias

from ffgym.core.errors import FFGymError


class SourceLocation(NamedTuple):
    """Location in a program: name of the file, line and column from 1."""

    file: str
    line: int
    column: int

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}"

    def error(self, message: str) -> FFGymError:
        """Error that begins with the place."""
        return FFGymError(f"{self}: {message}")


def decode(data: bytes) -> str:
    r"""Text of a program file: UTF-8, or Latin-1 as controllers write it; without byte order mark, lines end in \n."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("latin-1")  # has a character for every byte
    return unify_line_ends(text)


def unify_line_ends(text: str) -> str:
    r"""Return the text with lines that end in \n."""
    return text.replace("\r\n", "\n").replace("\r", "\n")


class Literal(NamedTuple):
    """Number >= 0, text or truth value, as written."""

    value: float | str | bool
    place: SourceLocation


class VariableReference(NamedTuple):
    """Data by name, or a component of it, e.g. `p10.trans.z`."""

    parts: tuple[str, ...]
    place: SourceLocation

    @property
    def name(self) -> str:
        """The whole, as it was written."""
        return ".".join(self.parts)


class Aggregate(NamedTuple):
    """Components between brackets."""

    items: "tuple[Expression, ...]"
    place: SourceLocation


class OperatorChain(NamedTuple):
    """Operands of one rank from left to right, e.g. a + b - c; flat, so that a long sum is not a deep tree."""

    first: "Expression"
    rest: "tuple[tuple[str, Expression], ...]"
    """Sign ('+', '-', '*' or '/') and operand."""

    @property
    def place(self) -> SourceLocation:
        """Location of its start."""
        return self.first.place


class Signed(NamedTuple):
    """An operand behind a sign."""

    negative: bool
    operand: "Expression"
    place: SourceLocation


class Option(NamedTuple):
    r"""Optional argument, e.g. `\WObj:=wobj1`, or a switch, e.g. `\NoEOffs`."""

    name: str
    value: "Expression | None"
    place: SourceLocation


class Argument(NamedTuple):
    """Required argument, with the optional ones that follow it; None where only optional ones stand."""

    value: "Expression | None"
    options: tuple[Option, ...]

    def names(self) -> list[str]:
        """Names of its options in lower case."""
        return [option.name.lower() for option in self.options]


class Call(NamedTuple):
    """Function, instruction or procedure with its arguments."""

    name: str
    arguments: tuple[Argument, ...]
    place: SourceLocation


Expression: TypeAlias = Literal | VariableReference | Aggregate | OperatorChain | Signed | Call


class Declaration(NamedTuple):
    """CONST, PERS or VAR data."""

    kind: str
    type_name: str
    name: str
    value: Expression | None
    place: SourceLocation


class Assignment(NamedTuple):
    """Target := value."""

    target: VariableReference
    value: Expression

    @property
    def place(self) -> SourceLocation:
        """Location of its start."""
        return self.target.place


Statement: TypeAlias = Assignment | Call


class Procedure(NamedTuple):
    """PROC without arguments."""

    name: str
    declarations: tuple[Declaration, ...]
    statements: tuple[Statement, ...]
    place: SourceLocation


class Module(NamedTuple):
    """Everything in a file."""

    declarations: tuple[Declaration, ...]
    procedures: tuple[Procedure, ...]
