"""Integration tests of the packaged FMUs and their exact oracle."""

import os

# The systems here are so small that more threads of linear algebra only wait for each other. NumPy reads this when it
# is loaded.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
