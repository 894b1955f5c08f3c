"""Names of programs that RAPID, KRL and URScript take."""

import re

from ffgym.paths.rapid.words import RESERVED, words

LONGEST = 24
"""Most characters of a name: KRL's."""
_KRL = words(
    "BOOL CASE CHANNEL CHAR CIRC CONFIRM CONTINUE DECL DEF DEFDAT DEFFCT DELAY DISTANCE END ENDDAT ENDFCT ENDLOOP "
    "ENDSPLINE ENDSWITCH ENUM EXT EXTFCT FRAME GLOBAL HALT HOME IMPORT INT INTERRUPT LIN LOOP MAXIMUM MINIMUM POS PRIO "
    "PTP PUBLIC PULSE REAL REPEAT RESUME SCIRC SEC SIGNAL SLIN SPL SPLINE SPTP STRUC SWITCH TRIGGER UNTIL WAIT WHEN"
)
"""Words of KRL that are not of RAPID."""
_URSCRIPT = words("BREAK DEF ELIF END GLOBAL HALT IN MOVEC MOVEJ MOVEL MOVEP PASS RUN SERVOJ STOPJ SYNC THREAD")
"""Words of URScript that are not of RAPID, and functions of motion."""
_OWN = re.compile(r"MAIN|PART\d+|TPATH|ZPATH|X\d+")
"""What is called so in the programs themselves."""


def program_name(name: str) -> str:
    """Make a name that controllers take: letters, digits and _, at most 24 characters, a letter first, no keyword."""
    word = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_")[:LONGEST]
    upper = word.upper()
    is_taken = upper in RESERVED | _KRL | _URSCRIPT or _OWN.fullmatch(upper) is not None
    return word if word[:1].isalpha() and not is_taken else f"p_{word}"[:LONGEST]
