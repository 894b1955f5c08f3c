"""Syntax tree of what the parser found."""

from functools import partial
from typing import Any

from lark import ParseTree, Token, Transformer, v_args
from lark.tree import Meta

from ffgym.paths.rapid import syntax
from ffgym.paths.rapid.tokens import place_of


def build_tree(file: str, text: str, tree: ParseTree) -> tuple[syntax.Module, ...]:
    """Modules of a file, from what the parser found in its text; what could not be read is left out."""
    modules: tuple[syntax.Module, ...] = _TreeBuilder(file, text).transform(tree)
    return modules


@v_args(inline=True)
class _TreeBuilder(Transformer[Token, tuple[syntax.Module, ...]]):
    """Makes the syntax tree, one method per rule of the grammar."""

    def __init__(self, file: str, text: str) -> None:
        super().__init__()
        self._place = partial(place_of, file)
        self._text = text

    # modules and what they declare

    def start(self, *modules: syntax.Module) -> tuple[syntax.Module, ...]:
        return modules

    def module(self, name: Token, attributes: Any, content: syntax.Module) -> syntax.Module:
        return content._replace(name=str(name))

    def content(self, *items: Any) -> syntax.Module:
        def those(kind: type[Any]) -> tuple[Any, ...]:
            return tuple(item for item in items if isinstance(item, kind))

        return syntax.Module("", those(syntax.RecordDeclaration), those(syntax.Declaration), those(syntax.Routine))

    def kind(self, word: Token) -> str:
        return word.type

    def declaration(
        self, scope: Token | None, kind: str, type_name: Token, name: Token, dimensions: Any, value: Any
    ) -> syntax.Declaration:
        local = scope is not None and scope.type == "LOCAL"
        sizes = () if dimensions is None else dimensions.items
        return syntax.Declaration(kind, str(type_name), str(name), sizes, value, self._place(name), local)

    def record(self, local: Token | None, name: Token, *components: Any) -> syntax.RecordDeclaration:
        return syntax.RecordDeclaration(str(name), components, self._place(name), local is not None)

    def component(self, type_name: Token, name: Token) -> tuple[str, str, syntax.SourceLocation]:
        return str(type_name), str(name), self._place(name)

    def alias(self, local: Token | None, type_name: Token, name: Token) -> syntax.RecordDeclaration:
        same = ((str(type_name), "", self._place(type_name)),)
        return syntax.RecordDeclaration(str(name), same, self._place(name), local is not None)

    # routines

    def procedure(self, local: Token | None, name: Token, *rest: Any) -> syntax.Routine:
        return self._routine("PROC", local, "", name, *rest)

    def function(self, local: Token | None, type_name: Token, name: Token, *rest: Any) -> syntax.Routine:
        return self._routine("FUNC", local, str(type_name), name, *rest)

    def trap(self, local: Token | None, name: Token, *rest: Any) -> syntax.Routine:
        return self._routine("TRAP", local, "", name, None, *rest)

    def _routine(
        self, kind: str, local: Token | None, type_name: str, name: Token, parameters: Any, *body: Any
    ) -> syntax.Routine:
        declarations, statements = body[:2]
        place = self._place(name)
        return syntax.Routine(
            kind, str(name), type_name, parameters or (), declarations, statements, place, local is not None
        )

    def parameters(self, *groups: Any) -> tuple[syntax.RoutineParameter, ...]:
        return tuple(
            parameter
            for group in groups
            for parameter in ([group] if isinstance(group, syntax.RoutineParameter) else group)
        )

    def optional(self, *parameters: syntax.RoutineParameter) -> list[syntax.RoutineParameter]:
        return [parameter._replace(optional=True) for parameter in parameters]

    def parameter(
        self, mode: Token | None, type_name: Token, name: Token, dimensions: int | None
    ) -> syntax.RoutineParameter:
        word = "" if mode is None else mode.type
        return syntax.RoutineParameter(str(name), str(type_name), word, dimensions or 0, False, self._place(name))

    def open_dimensions(self, *stars: Token) -> int:
        return len(stars)

    def declarations(self, *children: Any) -> tuple[Any, ...]:
        return tuple(child for child in children if child is not None)

    statements = declarations

    def handler(self, *children: Any) -> None:
        """Leave error handlers out."""

    def bad(self, placeholder: Token) -> syntax.Missing:
        return syntax.Missing(self._place(placeholder))

    def bad_statement(self, *children: Any) -> None:
        """Leave out what could not be read; there is an error about it."""

    bad_item = bad_statement

    # statements

    def assignment(self, target: syntax.VariableReference, value: Any) -> syntax.Assignment:
        return syntax.Assignment(target, value)

    @v_args(meta=True)
    def instruction(self, meta: Meta, children: list[Any]) -> syntax.Call:
        name, arguments = children
        text = " ".join(self._text[meta.start_pos : meta.end_pos - 1].split())
        return self._call(name, arguments)._replace(text=text)

    def call(self, name: Token, arguments: Any) -> syntax.Call:
        return self._call(name, arguments)

    def _call(self, name: Token, arguments: Any) -> syntax.Call:
        values, options = arguments or ((), ())
        return syntax.Call(str(name), values, options, self._place(name))

    def late_call(self, name: Any, arguments: Any) -> syntax.LateCall:
        values, options = arguments or ((), ())
        return syntax.LateCall(name, syntax.Call("", values, options, name.place))

    def goto(self, word: Token, label: Token) -> syntax.Goto:
        return syntax.Goto(str(label), self._place(word))

    def label(self, name: Token) -> syntax.Label:
        return syntax.Label(str(name), self._place(name))

    def connect(self, word: Token, interrupt: Any, trap: Token) -> syntax.Call:
        text = f"CONNECT {interrupt.name} WITH {trap}"
        return syntax.Call("CONNECT", (), (), self._place(word), text)

    def command(self, word: Token, value: Any = None) -> syntax.Call:
        return syntax.Call(word.type, (), (), self._place(word), word.type)

    def compact_if(self, word: Token, condition: Any, statement: Any) -> syntax.If:
        block = () if statement is None else (statement,)
        return syntax.If(((condition, block),), (), self._place(word))

    def branching(self, word: Token, condition: Any, block: Any, *rest: Any) -> syntax.If:
        *branches, otherwise = rest
        return syntax.If(((condition, block), *branches), otherwise or (), self._place(word))

    def elseif(self, condition: Any, block: Any) -> tuple[Any, Any]:
        return condition, block

    def counting(self, word: Token, variable: Token, first: Any, last: Any, step: Any, block: Any) -> syntax.For:
        return syntax.For(str(variable), first, last, step, block, self._place(word))

    def looping(self, word: Token, condition: Any, block: Any) -> syntax.While:
        return syntax.While(condition, block, self._place(word))

    def choosing(self, word: Token, value: Any, *rest: Any) -> syntax.Test:
        *cases, otherwise = rest
        return syntax.Test(value, tuple(cases), otherwise or (), self._place(word))

    def case(self, *children: Any) -> tuple[Any, Any]:
        *values, block = children
        return tuple(values), block

    def returning(self, word: Token, value: Any) -> syntax.Return:
        return syntax.Return(value, self._place(word))

    # arguments

    def arguments(self, *groups: Any) -> tuple[tuple[Any, ...], tuple[syntax.Option, ...]]:
        children = [child for group in groups for child in group]
        options = tuple(child for child in children if isinstance(child, syntax.Option))
        return tuple(child for child in children if not isinstance(child, syntax.Option)), options

    def argument(self, *children: Any) -> tuple[Any, ...]:
        return children

    def option(self, backslash: Token, name: Token, value: Any) -> syntax.Option:
        return syntax.Option(str(name), value, self._place(backslash))

    def passing(self, backslash: Token, name: Token, parameter: Token) -> syntax.Option:
        place = self._place(parameter)
        value = syntax.VariableReference(str(parameter), (), place)
        return syntax.Option(str(name), value, self._place(backslash), passed_on=True)

    # expressions

    def chain(self, first: Any, *rest: Any) -> syntax.OperatorChain:
        return syntax.OperatorChain(
            first, tuple((sign.upper(), operand) for sign, operand in zip(rest[::2], rest[1::2], strict=True))
        )

    def signing(self, sign: Token, operand: Any) -> syntax.SignedOperand:
        return syntax.SignedOperand(sign.type == "MINUS", operand, self._place(sign))

    def negation(self, word: Token, operand: Any) -> syntax.Negation:
        return syntax.Negation(operand, self._place(word))

    def number(self, token: Token) -> syntax.Literal:
        value = float(int(token, 0)) if token[1:2].lower() in tuple("xbo") else float(token)
        return syntax.Literal(value, self._place(token))

    def text(self, token: Token) -> syntax.Literal:
        return syntax.Literal(token[1:-1].replace('""', '"'), self._place(token))

    def truth(self, token: Token) -> syntax.Literal:
        return syntax.Literal(token.type == "TRUE", self._place(token))

    def reference(self, name: Token, *parts: Any) -> syntax.VariableReference:
        named = [str(part) if isinstance(part, Token) else part for part in parts if part is not None]
        return syntax.VariableReference(str(name), tuple(named), self._place(name))

    def dimensions(self, *items: Any) -> syntax.Indices:
        return syntax.Indices(items)

    def aggregate(self, bracket: Token, *items: Any) -> syntax.Aggregate:
        return syntax.Aggregate(items, self._place(bracket))
