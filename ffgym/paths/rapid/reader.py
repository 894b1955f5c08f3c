"""Parser of RAPID, from text to syntax tree, by lark; imported when the first program is read, as lark is an extra."""

from collections.abc import Iterator
from functools import cache, partial
from importlib import resources
from typing import Any

from lark import Lark, Token, Transformer, UnexpectedCharacters, UnexpectedToken, v_args

from ffgym.core.errors import FFGymError
from ffgym.paths.rapid import syntax


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


KEYWORDS = _words(
    "MODULE ENDMODULE SYSMODULE NOSTEPIN VIEWONLY READONLY NOVIEW LOCAL TASK CONST PERS VAR PROC ENDPROC TRUE FALSE"
)
"""Reserved words that are read."""

RESERVED = KEYWORDS | _words(
    "ALIAS AND BACKWARD CASE CONNECT DEFAULT DIV DO ELSE ELSEIF ENDFOR ENDFUNC ENDIF ENDRECORD ENDTEST ENDTRAP "
    "ENDWHILE ERROR EXIT FOR FROM FUNC GOTO IF INOUT MOD NOT OR RAISE RECORD RETRY RETURN STEP TEST THEN TO TRAP "
    "TRYNEXT UNDO WHILE WITH XOR"
)
"""All reserved words; technical reference manual RAPID overview (ABB 3HAC16580-1), reserved words."""

TERMINALS = {
    "NAME": "a name",
    "NUMBER": "a number",
    "STRING": "text",
    "TRUE": "TRUE",
    "FALSE": "FALSE",
    "COMMA": "','",
    "SEMICOLON": "';'",
    "LPAR": "'('",
    "RPAR": "')'",
    "LSQB": "'['",
    "RSQB": "']'",
    "DOT": "'.'",
    "_ASSIGN": "':='",
    "BACKSLASH": "'\\'",
    "PLUS": "'+'",
    "MINUS": "'-'",
    "TIMES": "'*'",
    "DIVIDED": "'/'",
    "$END": "the end of the file",
    "value": "a value",
}
"""Terminals of the grammar in words; keywords stand for themselves."""

VALUE_STARTS = frozenset({"NAME", "NUMBER", "STRING", "TRUE", "FALSE", "LPAR", "LSQB", "PLUS", "MINUS"})
"""Tokens that a value can begin with; together they are called 'value'."""

UNSUPPORTED_SIGNS = {
    "{": "arrays are not supported, declare each datum by a name of its own",
    "}": "arrays are not supported, declare each datum by a name of its own",
    "<": "comparisons and placeholders are not supported",
    ">": "comparisons and placeholders are not supported",
    "=": "comparisons are not supported, ':=' assigns",
    ":": "labels are not supported, ':=' assigns",
    '"': "text must end on the line on which it begins",
    "%": "a file header must begin and end with %%%",
}
"""Why a sign that RAPID has is not read."""


MAX_NESTING = 20
"""Deepest nesting of brackets; chosen: data of RAPID need 4, and reading a tree must not exhaust Python's stack."""

LONGEST_NAME = 32
"""Most characters of a name; technical reference manual RAPID overview (ABB 3HAC16580-1), identifiers."""


def read(name: str, text: str) -> syntax.Module:
    """Syntax tree of a program.

    Raises:
        FFGymError: if it is none; the message begins with the place, in a file of that `name`.
    """
    try:
        module: syntax.Module = _Builder(name).transform(_parser().parse(text))
    except UnexpectedCharacters as error:
        reason = UNSUPPORTED_SIGNS.get(error.char, "it begins nothing in RAPID")
        place = syntax.SourceLocation(name, error.line, error.column)
        raise place.error(f"unexpected character {error.char!r}: {reason}.") from None
    except UnexpectedToken as error:
        raise _bad_token(name, text, error) from None
    except _Refused as error:
        raise _place(name, error.token).error(str(error)) from None
    return module


@cache
def _parser() -> Lark:
    grammar = (resources.files("ffgym.paths.rapid") / "rapid.lark").read_text(encoding="utf-8")
    return Lark(grammar, parser="lalr", lexer="basic", postlex=_Keywords())


class _Refused(Exception):
    """A token that the grammar would take."""

    def __init__(self, token: Token, message: str) -> None:
        super().__init__(message)
        self.token = token


class _Keywords:
    """Between lexer and parser: makes keywords of names, and watches their length and the depth of brackets."""

    always_accept = ()

    def process(self, stream: Iterator[Token]) -> Iterator[Token]:
        """Pass the tokens on."""
        depth = 0
        for token in stream:
            if token.type == "NAME" and token.upper() in RESERVED:
                yield token.update(type=token.upper())
                continue
            if token.type == "NAME" and len(token) > LONGEST_NAME:
                raise _Refused(token, f"{_shown(token)} is too long, names have {LONGEST_NAME} characters at most.")
            depth += (token.type in ("LSQB", "LPAR")) - (token.type in ("RSQB", "RPAR"))
            if depth > MAX_NESTING:
                raise _Refused(token, f"brackets are nested deeper than {MAX_NESTING}.")
            yield token


def _place(name: str, token: Token) -> syntax.SourceLocation:
    return syntax.SourceLocation(name, token.line or 1, token.column or 1)


def _bad_token(name: str, text: str, error: UnexpectedToken) -> FFGymError:
    token = error.token
    if token.type == "$END":
        lines = text.rstrip().split("\n")
        end = syntax.SourceLocation(name, len(lines), len(lines[-1]) + 1)
        return end.error(f"the program ends too early; expected {_list_expected(error)}.")
    place = _place(name, token)
    if token.type in RESERVED and token.type not in KEYWORDS:
        return place.error(f"{token.type} is not supported; a program is a list of moves, see docs/rapid.md.")
    if error.expected == {"RPAR"}:  # only the head of a procedure leaves no choice
        return place.error("procedures with arguments are not supported; write one for each case.")
    return place.error(f"unexpected {_shown(token)}; expected {_list_expected(error)}.")


def _shown(token: Token) -> str:
    text = str(token)
    return repr(text if len(text) <= 40 else text[:37] + "...")


def _list_expected(error: UnexpectedToken) -> str:
    names = set(error.expected)
    if names >= VALUE_STARTS:
        names = (names - VALUE_STARTS) | {"value"}
    words = sorted(TERMINALS.get(name, name) for name in names)
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} or {words[-1]}"


@v_args(inline=True)
class _Builder(Transformer[Token, syntax.Module]):
    """Makes the syntax tree of what the parser found, one method per rule of the grammar."""

    def __init__(self, name: str) -> None:
        super().__init__()
        self._place = partial(_place, name)

    def start(self, *children: Any) -> syntax.Module:
        (content,) = (child for child in children if isinstance(child, syntax.Module))
        return content

    def content(self, *children: Any) -> syntax.Module:
        return syntax.Module(
            declarations=tuple(child for child in children if isinstance(child, syntax.Declaration)),
            procedures=tuple(child for child in children if isinstance(child, syntax.Procedure)),
        )

    def kind(self, word: Token) -> str:
        return word.type

    def declaration(
        self, scope: Token | None, kind: str, type_name: Token, name: Token, value: Any
    ) -> syntax.Declaration:
        return syntax.Declaration(kind, str(type_name), str(name), value, self._place(name))

    def procedure(self, *children: Any) -> syntax.Procedure:
        name, declarations, statements = children[-4:-1]
        return syntax.Procedure(str(name), declarations, statements, self._place(name))

    def assignment(self, target: syntax.VariableReference, value: Any) -> syntax.Assignment:
        return syntax.Assignment(target, value)

    def instruction(self, name: Token, arguments: tuple[syntax.Argument, ...] | None) -> syntax.Call:
        return syntax.Call(str(name), arguments or (), self._place(name))

    def arguments(self, *children: Any) -> tuple[Any, ...]:
        return children

    declarations = statements = arguments

    def argument(self, value: Any, *options: syntax.Option) -> syntax.Argument:
        return value if isinstance(value, syntax.Argument) else syntax.Argument(value, options)

    def without_value(self, *options: syntax.Option) -> syntax.Argument:
        return syntax.Argument(None, options)

    def option(self, backslash: Token, name: Token, value: Any) -> syntax.Option:
        return syntax.Option(str(name), value, self._place(backslash))

    def chain(self, first: Any, *rest: Any) -> syntax.OperatorChain:
        return syntax.OperatorChain(
            first, tuple((str(sign), operand) for sign, operand in zip(rest[::2], rest[1::2], strict=True))
        )

    def signed(self, sign: Token, operand: Any) -> syntax.Signed:
        return syntax.Signed(sign.type == "MINUS", operand, self._place(sign))

    def number(self, token: Token) -> syntax.Literal:
        return syntax.Literal(float(token), self._place(token))

    def text(self, token: Token) -> syntax.Literal:
        return syntax.Literal(token[1:-1].replace('""', '"'), self._place(token))

    def truth(self, token: Token) -> syntax.Literal:
        return syntax.Literal(token.type == "TRUE", self._place(token))

    def reference(self, *names: Token) -> syntax.VariableReference:
        return syntax.VariableReference(tuple(str(name) for name in names), self._place(names[0]))

    def call(self, name: Token, arguments: tuple[syntax.Argument, ...]) -> syntax.Call:
        return syntax.Call(str(name), arguments, self._place(name))

    def aggregate(self, bracket: Token, *items: Any) -> syntax.Aggregate:
        return syntax.Aggregate(items, self._place(bracket))
