"""The names of PyRep as views on the simulated world of rlbench_pin; see `docs/compatibility.md`."""
