"""What the tests have in common.

* `slave`, `harness`: an FMU's instance by names, and a small co-simulation master, on top of fmpy;
* `contract`: what the FMUs promise, written once more by hand; `capabilities`: the flags of their descriptions;
* `tool`: the command line tool; `browser`: headless Chromium for the pages;
* `measures`, `identify`, `units`: settling times, poles of an FMU, units of measurement;
* `continuation`: a program that goes on from a saved state in a process of its own.
"""
