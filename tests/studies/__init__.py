"""Studies made with the packaged FMUs: programs that draw the figures in `docs/figures` and measure what docs/performance.md says.

Tests hold the results of `cosimulation_error` and `coupling`. `compare_cost`, `performance` and `tool_cost` measure times, so
they are run by hand, and no test depends on them.
"""
