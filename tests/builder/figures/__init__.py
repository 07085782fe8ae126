"""Tests of `rlbench_pin.builder.figures`."""
