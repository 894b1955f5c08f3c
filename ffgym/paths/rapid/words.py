"""The words of RAPID, and how messages speak of them."""


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
"""What a value can begin with; together they are called 'value'."""

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
