"""Tests of `rlbench_pin.builder.server`."""
