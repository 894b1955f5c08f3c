"""`python -m ffgym` is the `ffgym` command."""

from ffgym.cli import main

main()
