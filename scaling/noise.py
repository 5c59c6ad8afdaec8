#!/usr/bin/env python3
"""What ranks that wait for their 26 neighbours lose to interrupts: a simulation beside the rule of model.py. Needs NumPy.

A rank ends a step when it and its neighbours have ended the one before, one time unit later if an interrupt hits it.

    scaling/noise.py
"""

import math

import numpy


def lost(chance, edge=24, steps=3000, seed=1):
    """Time lost per step, in units of an interrupt, that comes with a chance per rank and step, on edge^3 ranks."""
    random, ends = numpy.random.default_rng(seed), numpy.zeros((edge,) * 3)
    begun = steps // 4
    for step in range(steps):
        for axis in range(3):
            ends = numpy.maximum(ends, numpy.maximum(numpy.roll(ends, 1, axis), numpy.roll(ends, -1, axis)))
        ends = ends + (random.random(ends.shape) < chance)
        if step == begun:
            before = ends.max()
    return (ends.max() - before) / (steps - 1 - begun)


if __name__ == "__main__":
    print("| chance per rank and step | lost (interrupts per step) | 2 chance^(1/4) | if all waited for all |\n| --- | --- | --- | --- |")
    for chance in (1e-5, 3e-5, 1e-4, 1e-3, 1e-2, 1e-1):
        of_all = 1 - math.exp(-(24**3) * chance)
        print(f"| {chance:g} | {lost(chance):.3f} | {min(1.0, 2 * chance**0.25):.3f} | {of_all:.3f} |")
