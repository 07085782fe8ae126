"""Formats of others: one exporter per module, and the reader of RLBench-style folders."""
