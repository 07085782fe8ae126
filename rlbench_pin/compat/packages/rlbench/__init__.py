"""The names of RLBench as views on rlbench_pin; see `docs/compatibility.md`."""
