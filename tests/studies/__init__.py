"""Studies made with the packaged FMUs: programs that draw the figures in `docs/figures` and measure what docs/performance.md says.

Tests hold the results of `cosimulation_error` and `coupling`. `compare_cost` and `performance` measure wall time, so they are
run by hand, and no test depends on them.
"""
