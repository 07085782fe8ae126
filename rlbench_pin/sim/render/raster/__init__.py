"""Rasterizer: draws moving objects as triangles with numpy, for all cameras at once."""
