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


class Indices(NamedTuple):
    """Indices of an element of an array, from 1."""

    items: "tuple[Expression, ...]"


class VariableReference(NamedTuple):
    """Data by name, or a part of it, e.g. `p10.trans.z` or `pick{2}.rot`."""

    name: str
    parts: tuple[str | Indices, ...]
    """Components by name, and elements."""
    place: SourceLocation


class Aggregate(NamedTuple):
    """Components or elements between brackets."""

    items: "tuple[Expression, ...]"
    place: SourceLocation


class OperatorChain(NamedTuple):
    """Operands of one rank from left to right, e.g. a + b - c; flat, so that a long sum is not a deep tree."""

    first: "Expression"
    rest: "tuple[tuple[str, Expression], ...]"
    """Operator, a sign or a word in upper case, and operand."""

    @property
    def place(self) -> SourceLocation:
        """Location of its start."""
        return self.first.place


class SignedOperand(NamedTuple):
    """An operand behind a sign."""

    negative: bool
    operand: "Expression"
    place: SourceLocation


class Negation(NamedTuple):
    """A truth value behind NOT."""

    operand: "Expression"
    place: SourceLocation


class Option(NamedTuple):
    r"""Optional argument, e.g. `\WObj:=wobj1`, or a switch, e.g. `\NoEOffs`."""

    name: str
    value: "Expression | None"
    place: SourceLocation
    passed_on: bool = False
    r"""True for `\WObj?wobj`, which gives it if the parameter `wobj` is present."""


class Call(NamedTuple):
    """Function, instruction or procedure with its arguments."""

    name: str
    values: "tuple[Expression, ...]"
    """Required arguments in their order."""
    options: tuple[Option, ...]
    place: SourceLocation
    text: str = ""
    """An instruction as it was written, on one line."""


class Missing(NamedTuple):
    """An expression that could not be read."""

    place: SourceLocation


Expression: TypeAlias = (
    Missing | Literal | VariableReference | Aggregate | OperatorChain | SignedOperand | Negation | Call
)


class Declaration(NamedTuple):
    """CONST, PERS or VAR data."""

    kind: str
    type_name: str
    name: str
    dimensions: tuple[Expression, ...]
    value: Expression | None
    place: SourceLocation
    local: bool = False


class Assignment(NamedTuple):
    """Target := value."""

    target: VariableReference
    value: Expression

    @property
    def place(self) -> SourceLocation:
        """Location of its start."""
        return self.target.place


class LateCall(NamedTuple):
    """Procedure whose name is found when the program runs, e.g. `%"cut" + part%;`."""

    name: Expression
    call: Call

    @property
    def place(self) -> SourceLocation:
        """Location of its start."""
        return self.call.place


class Goto(NamedTuple):
    """Jump to a label."""

    label: str
    place: SourceLocation


class Label(NamedTuple):
    """Target of GOTO."""

    name: str
    place: SourceLocation


class Return(NamedTuple):
    """End of a routine, with the value of a function."""

    value: Expression | None
    place: SourceLocation


class If(NamedTuple):
    """The first branch whose condition holds, or the last block."""

    branches: "tuple[tuple[Expression, tuple[Statement, ...]], ...]"
    otherwise: "tuple[Statement, ...]"
    place: SourceLocation


class For(NamedTuple):
    """A block that is repeated while a number counts."""

    variable: str
    first: Expression
    last: Expression
    step: Expression | None
    block: "tuple[Statement, ...]"
    place: SourceLocation


class While(NamedTuple):
    """A block that is repeated as long as a condition holds."""

    condition: Expression
    block: "tuple[Statement, ...]"
    place: SourceLocation


class Test(NamedTuple):
    """The first case that has the value, or the last block."""

    value: Expression
    cases: "tuple[tuple[tuple[Expression, ...], tuple[Statement, ...]], ...]"
    otherwise: "tuple[Statement, ...]"
    place: SourceLocation


Statement: TypeAlias = Assignment | Call | LateCall | Goto | Label | Return | If | For | While | Test


class RoutineParameter(NamedTuple):
    """Parameter of a routine."""

    name: str
    type_name: str
    mode: str
    """INOUT, VAR or PERS for data of the caller that may be changed; empty for a value."""
    dimensions: int
    """Number of dimensions of an array, 0 for none."""
    optional: bool
    place: SourceLocation


class Routine(NamedTuple):
    """PROC, FUNC or TRAP. Its error handler is left out: nothing goes wrong in a plan."""

    kind: str
    name: str
    type_name: str
    """Type of a function, empty for others."""
    parameters: tuple[RoutineParameter, ...]
    declarations: tuple[Declaration, ...]
    statements: tuple[Statement, ...]
    place: SourceLocation
    local: bool = False


class RecordDeclaration(NamedTuple):
    """Type with components, or another name for a type (ALIAS), which has one component without a name."""

    name: str
    components: tuple[tuple[str, str, SourceLocation], ...]
    """Type, name and place of each."""
    place: SourceLocation
    local: bool = False


class Module(NamedTuple):
    """Everything in a module."""

    name: str
    records: tuple[RecordDeclaration, ...]
    declarations: tuple[Declaration, ...]
    routines: tuple[Routine, ...]
