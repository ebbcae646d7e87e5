"""`python -m dualarm`, as the command `dualarm`."""

from . import main

main()
