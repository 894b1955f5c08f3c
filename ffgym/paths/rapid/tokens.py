"""Words of RAPID between lexer and parser, and what messages call them."""

from collections.abc import Iterator

from lark import Token

from ffgym.core.errors import FFGymError
from ffgym.paths.rapid.syntax import SourceLocation
from ffgym.paths.rapid.words import RESERVED, words

KEPT = words(
    "AND CONNECT CONST DIV EXIT FALSE FOR GOTO IF INOUT LOCAL MOD NOT OR PERS RAISE RETRY RETURN TASK TEST TRUE "
    "TRYNEXT VAR WHILE XOR"
)
"""Reserved words that the syntax tree is made of; the types of all others begin with '_', which leaves them out."""

TERMINALS = {
    "NAME": "a name",
    "NUMBER": "a number",
    "STRING": "text",
    "COMMA": "','",
    "SEMICOLON": "';'",
    "COLON": "':'",
    "LPAR": "'('",
    "RPAR": "')'",
    "LSQB": "'['",
    "RSQB": "']'",
    "LBRACE": "'{'",
    "RBRACE": "'}'",
    "DOT": "'.'",
    "QMARK": "'?'",
    "VBAR": "'|'",
    "PERCENT": "'%'",
    "_ASSIGN": "':='",
    "BACKSLASH": "'\\'",
    "PLUS": "'+'",
    "MINUS": "'-'",
    "TIMES": "'*'",
    "DIVIDED": "'/'",
    "RELATION": "a comparison",
    "$END": "the end of the file",
    "value": "a value",
    "operator": "an operator",
    "statement": "a statement",
}
"""Terminals of the grammar in words; keywords stand for themselves."""

VALUE_STARTS = words("NAME NUMBER STRING TRUE FALSE LPAR LSQB PLUS MINUS")
"""Tokens that a value can begin with; together they are called 'value'."""

OPERATORS = words("PLUS MINUS TIMES DIVIDED DIV MOD RELATION AND OR XOR")
"""Operators between two values; together they are called 'operator'."""

STATEMENT_STARTS = words("NAME IF FOR WHILE TEST GOTO RETURN CONNECT EXIT RETRY TRYNEXT RAISE PERCENT")
"""Tokens that a statement can begin with; together they are called 'statement'."""

PLACEHOLDERS = words("BAD BAD_STATEMENT BAD_ITEM")
"""Tokens that stand for what could not be read."""

WRONG_SIGNS = {
    "<": "placeholders such as <SMT> are no program, write the statement",
    '"': "text must end on the line on which it begins",
    "=": "':=' assigns, '=' compares",
}
"""Why a sign is not read where it stands."""

MAX_NESTING = 20
"""Deepest nesting of brackets and of blocks; chosen: data of RAPID need 4, and reading must not exhaust the stack."""

LONGEST_NAME = 32
"""Most characters of a name; technical reference manual RAPID overview (ABB 3HAC16580-1), identifiers."""

_DEEPER = words("LSQB LPAR LBRACE FOR WHILE TEST _THEN")
_HIGHER = words("RSQB RPAR RBRACE _ENDFOR _ENDWHILE _ENDTEST _ENDIF")


class Keywords:
    """Between lexer and parser: makes keywords of names; ends the text where names are too long or nesting too deep."""

    always_accept = ("WRONG",)

    def process(self, stream: Iterator[Token]) -> Iterator[Token]:
        """Pass the tokens on; the last of them is of type TOO_LONG or TOO_DEEP if reading stops there."""
        depth, last = 0, ""
        for token in stream:
            if token.type == last == "WRONG":  # the first of several says it all
                continue
            last = token.type
            if token.type == "NAME" and token.upper() in RESERVED:
                word = token.upper()
                token = token.update(type=word if word in KEPT else f"_{word}")
            if token.type in ("_MODULE", "_PROC", "_FUNC", "_TRAP"):
                depth = 0
            depth += (token.type in _DEEPER) - (token.type in _HIGHER)
            depth -= token.type == "_ELSEIF"  # whose THEN opens no block of its own
            if token.type == "NAME" and len(token) > LONGEST_NAME:
                yield token.update(type="TOO_LONG")
            elif depth > MAX_NESTING:
                yield token.update(type="TOO_DEEP")
                return
            else:
                yield token


def place_of(file: str, token: Token) -> SourceLocation:
    """Location of a token."""
    return SourceLocation(file, token.line or 1, token.column or 1)


def show(token: Token) -> str:
    """Show the text of a token, in quotes."""
    text = str(token)
    return repr(text if len(text) <= 40 else text[:37] + "...")


def explain(file: str, token: Token, accepted: set[str]) -> FFGymError:
    """Error at a token that the grammar does not take, beside those that it would."""
    place = place_of(file, token)
    if token.type == "TOO_LONG":
        return place.error(f"{show(token)} is too long, names have {LONGEST_NAME} characters at most.")
    if token.type == "TOO_DEEP":
        return place.error(f"brackets or blocks are nested deeper than {MAX_NESTING}.")
    if token.type == "$END":
        return place.error(f"the program ends too early; expected {_list(accepted)}.")
    if token.type == "WRONG" and token not in WRONG_SIGNS:
        return place.error(f"unexpected character {show(token)}: it begins nothing in RAPID.")
    reason = WRONG_SIGNS.get(str(token))
    if reason is not None and not (token == "<" and accepted & OPERATORS):
        return place.error(f"unexpected character {show(token)}: {reason}.")
    return place.error(f"unexpected {show(token)}; expected {_list(accepted)}.")


def _list(accepted: set[str]) -> str:
    """List the tokens that were expected, those of a kind by one word."""
    names = accepted - PLACEHOLDERS
    for kind, members in (("statement", STATEMENT_STARTS), ("value", VALUE_STARTS), ("operator", OPERATORS)):
        if names >= members:
            names = (names - members) | {kind}
    words = sorted(TERMINALS.get(name, name.removeprefix("_")) for name in names)
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} or {words[-1]}"
