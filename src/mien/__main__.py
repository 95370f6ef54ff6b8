"""`python -m mien`: the command line, where the script is not on the path."""

from mien.cli import main

main()
