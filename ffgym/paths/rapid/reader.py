"""Parser of RAPID, from text to syntax tree, by lark; imported when the first program is read, as lark is an extra."""

from collections import Counter
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

from lark import Lark, Token, UnexpectedToken
from lark.parsers.lalr_interactive_parser import InteractiveParser

from ffgym.core.errors import FFGymError
from ffgym.paths.rapid import syntax
from ffgym.paths.rapid.tokens import Keywords, explain
from ffgym.paths.rapid.tree import build_tree
from ffgym.paths.rapid.words import words

MOST_ERRORS = 20
"""Most errors of one file that are looked for; chosen: what comes after them mostly follows from them."""

_CLOSING = {"IF": "_ENDIF", "FOR": "_ENDFOR", "WHILE": "_ENDWHILE", "TEST": "_ENDTEST"}
"""End of a block by its begin."""

_BORDERS = words(
    "_PROC _FUNC _TRAP _ENDPROC _ENDFUNC _ENDTRAP _ENDMODULE _ERROR _UNDO IF FOR WHILE TEST _ENDIF _ENDFOR _ENDWHILE "
    "_ENDTEST _ELSE _ELSEIF _CASE _DEFAULT $END"
)
"""Tokens that no statement goes beyond."""

_RESUMED = words("SEMICOLON _THEN _DO _TO _STEP COMMA RPAR COLON")
"""Tokens behind a value that could not be read at which reading goes on."""


@dataclass(frozen=True)
class ReadFile:
    """A file as far as it could be read."""

    modules: tuple[syntax.Module, ...]
    """None of them if reading stopped before the end."""
    errors: tuple[FFGymError, ...]
    """What could not be read; each begins with the place."""
    skipped: frozenset[str]
    """Names in lower case in what could not be read, which may be declarations."""


def read(file: str, text: str) -> ReadFile:
    """Read a program; `file` is its name, for messages."""
    tokens = list(_parser().lex(text))
    return _Reading(file, text, tokens).run()


@cache
def _parser() -> Lark:
    grammar = (resources.files("ffgym.paths.rapid") / "rapid.lark").read_text(encoding="utf-8")
    return Lark(grammar, parser="lalr", lexer="basic", postlex=Keywords(), propagate_positions=True)


def _next_of(tokens: Sequence[Token], types: frozenset[str]) -> list[int]:
    """Find for each token the first one from it on that is of some types, of which the last token is one."""
    found = [len(tokens) - 1] * len(tokens)
    for i in range(len(tokens) - 2, -1, -1):
        found[i] = i if tokens[i].type in types else found[i + 1]
    return found


class _Reading:
    """One pass over the tokens of a file, which goes on behind what it cannot read."""

    def __init__(self, file: str, text: str, tokens: list[Token]) -> None:
        self.file, self.text = file, text
        lines = text.rstrip().split("\n")
        end = Token("$END", "", line=len(lines), column=len(lines[-1]) + 1)
        self.tokens = [*tokens, end]
        self.signs = _next_of(self.tokens, _RESUMED | _BORDERS)
        """For each token the next sign at which a statement may go on, or its border."""
        self.ends = _next_of(self.tokens, _BORDERS | {"SEMICOLON"})
        """For each token the end of its statement."""
        self.parser: InteractiveParser = _parser().parse_interactive()
        self.errors: list[FFGymError] = []
        self.skipped: set[str] = set()
        self.lost: Counter[str] = Counter()
        """Ends of blocks whose begin could not be read."""
        self.clean = 0
        """First token after the last error, from which on another error is news."""

    def run(self) -> ReadFile:
        i = 0
        while i < len(self.tokens):
            token = self.tokens[i]
            try:
                tree = self.parser.feed_token(token)
                i += 1
            except UnexpectedToken:
                if self.lost[token.type] > 0:
                    self.lost[token.type] -= 1
                    i += 1
                    continue
                if i >= self.clean:
                    self.errors.append(explain(self.file, token, self.parser.accepts()))
                after = self._recover(i)
                if after is None or len(self.errors) >= MOST_ERRORS:
                    return ReadFile((), tuple(self.errors), frozenset(self.skipped))
                self.skipped |= {str(t).lower() for t in self.tokens[i:after] if t.type == "NAME"}
                self.clean = after + 1
                i = after
        return ReadFile(build_tree(self.file, self.text, tree), tuple(self.errors), frozenset(self.skipped))

    def _recover(self, i: int) -> int | None:
        """Put a placeholder in place of what cannot be read around token `i`; the token to go on with, None if none."""
        if self.tokens[i].type in ("TOO_DEEP", "$END"):
            return None
        after = self._resume_after_value(i)
        if after is not None:
            return after
        saved = self._save()
        after = self._next_statement(i)
        while self.parser.parser_state.state_stack:
            for placeholder in ("BAD_STATEMENT", "BAD_ITEM"):
                if self._takes(placeholder, self.tokens[after]):
                    self._feed(placeholder, self.tokens[i])
                    return after
            self._drop()
        self._restore(saved)
        return i + 1

    def _save(self) -> tuple[list[Any], list[Any], Counter[str]]:
        state = self.parser.parser_state
        return list(state.state_stack), list(state.value_stack), self.lost.copy()

    def _restore(self, saved: tuple[list[Any], list[Any], Counter[str]]) -> None:
        state = self.parser.parser_state
        state.state_stack[:], state.value_stack[:], self.lost = saved

    def _takes(self, placeholder: str, token: Token) -> bool:
        """Tell if the parser takes a placeholder and then a token where it stands."""
        if placeholder not in self.parser.choices():
            return False
        trial = self.parser.copy(deepcopy_values=False)
        trial.parser_state.parse_conf = copy(trial.parser_state.parse_conf)
        trial.parser_state.parse_conf.callbacks = {}  # which would change the values that both share
        try:
            trial.feed_token(Token(placeholder, ""))
            trial.feed_token(token)
        except UnexpectedToken:
            return False
        return True

    def _feed(self, placeholder: str, at: Token) -> None:
        self.parser.feed_token(Token.new_borrow_pos(placeholder, "", at))

    def _resume_after_value(self, i: int) -> int | None:
        """Take what stands up to the next sign of its statement as one value, if the statement goes on there."""
        after = self.signs[i]
        token = self.tokens[after]
        if token.type in _BORDERS:
            return None
        saved = self._save()
        while self.parser.parser_state.state_stack:
            choices = self.parser.choices()
            if self._takes("BAD", token):
                self._feed("BAD", token)
                return after
            if "BAD_STATEMENT" in choices or "BAD_ITEM" in choices:
                break
            self._drop()
        self._restore(saved)
        return None

    def _drop(self) -> None:
        """Drop the newest piece that was read; the end of a block that it began is lost."""
        state = self.parser.parser_state
        state.state_stack.pop()
        if state.value_stack:
            value = state.value_stack.pop()
            if isinstance(value, Token) and value.type in _CLOSING:
                self.lost[_CLOSING[value.type]] += 1

    def _next_statement(self, i: int) -> int:
        """Find the token behind the next semicolon, or at the next border of a statement."""
        end = self.ends[i]
        return end + 1 if self.tokens[end].type == "SEMICOLON" else end
