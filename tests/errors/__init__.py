"""Tests of the error classes."""
