"""Studies made with the packaged FMUs: programs that draw the figures in `docs/figures`; tests hold their results."""
