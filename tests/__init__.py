"""Integration tests of the packaged FMUs and their exact oracle."""
