"""Tests of `rlbench_pin.builder.view`."""
