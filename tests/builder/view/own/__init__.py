"""Tests of files of one's own."""
