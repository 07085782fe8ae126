"""Tests of `rlbench_pin.builder.worker`."""
