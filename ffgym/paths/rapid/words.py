"""Reserved words of RAPID, which no data and no routine may be called."""


def words(text: str) -> frozenset[str]:
    """Set of the words of a text."""
    return frozenset(text.split())


RESERVED = words(
    "ALIAS AND BACKWARD CASE CONNECT CONST DEFAULT DIV DO ELSE ELSEIF ENDFOR ENDFUNC ENDIF ENDMODULE ENDPROC ENDRECORD "
    "ENDTEST ENDTRAP ENDWHILE ERROR EXIT FALSE FOR FROM FUNC GOTO IF INOUT LOCAL MOD MODULE NOSTEPIN NOT NOVIEW OR "
    "PERS PROC RAISE READONLY RECORD RETRY RETURN STEP SYSMODULE TASK TEST THEN TO TRAP TRUE TRYNEXT UNDO VAR VIEWONLY "
    "WHILE WITH XOR"
)
"""Reserved words; technical reference manual RAPID overview (ABB 3HAC16580-1), reserved words."""
