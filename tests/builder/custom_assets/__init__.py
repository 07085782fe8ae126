"""Tests of `rlbench_pin.builder.custom_assets`."""
