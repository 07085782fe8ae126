"""The validator: what every task must keep, measured and reported."""
